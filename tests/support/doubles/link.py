"""Spring, damper and mass between two points a and b: forces on them, without state (direct feed-through)."""

from double_base import Double, pin

pin(globals())


class Link(Double):
    VARIABLES = (
        ("stiffness", "parameter", 1.0, "N/m"),
        ("damping", "parameter", 0.0, "kg/s"),
        ("mass_a", "parameter", 0.0, "kg"),
        ("x_a", "input", 0.0, "m"),
        ("v_a", "input", 0.0, "m/s"),
        ("a_a", "input", 0.0, "m/s2"),
        ("x_b", "input", 0.0, "m"),
        ("v_b", "input", 0.0, "m/s"),
        ("force_a", "output", 0.0, "N"),
        ("force_b", "output", 0.0, "N"),
    )

    def begin(self):
        self.advance(0.0, 0.0)

    def advance(self, time, dt):
        pull = self.stiffness * (self.x_b - self.x_a) + self.damping * (self.v_b - self.v_a)
        self.force_a, self.force_b = pull - self.mass_a * self.a_a, -pull
