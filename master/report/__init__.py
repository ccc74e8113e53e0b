"""A run, a sweep or a system's run as one HTML page that needs nothing but a browser."""
