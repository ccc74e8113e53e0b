"""Cases and system files as SSP archives."""
