"""How a network is trained: motions, records, fit, study. The FMU needs none of it."""
