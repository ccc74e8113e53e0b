"""Cheap FMUs that stand in for the product's, and small systems whose motion is known exactly."""

LINKED = [
    "a.x -> link.x_a",
    "a.v -> link.v_a",
    "a.a -> link.a_a",
    "b.x -> link.x_b",
    "b.v -> link.v_b",
    "link.force_a -> a.force",
    "link.force_b -> b.force",
]
"""The wires of two oscillators, a and b, and the link between them."""
