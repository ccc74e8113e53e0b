"""One flutter point: set-up of the system, the march, what is recorded."""
