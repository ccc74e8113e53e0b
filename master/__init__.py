"""The master: couples FMUs, finds flutter boundaries, records and reports. It knows FMUs only, no physics."""
