"""The linear model of the air from frequency sweeps, and the roots of the section in it."""
