"""The surrogate's training case, records and report."""
