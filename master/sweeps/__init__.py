"""Sweeps: what is to be computed, by whom, what became of it; resumable, in processes or on a cluster."""
