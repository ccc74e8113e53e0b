"""Systems of FMUs: wires, order, schemes, checkpoints. Knows no flutter."""
