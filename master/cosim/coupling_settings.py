"""The table [coupling] of a case or a system file."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..base.settings import key, rule


@dataclass
class Coupling:
    """How one step couples the components (docs/coupling.md). Components are those of the system: structure, aero, slosh."""

    scheme: str = key("gauss-seidel", "gauss-seidel, implicit or jacobi", choices=["gauss-seidel", "implicit", "jacobi"])
    order: list[str] = field(
        default_factory=list,
        metadata=rule("order of the components in a pass; empty: the one in which the fewest inputs lag", empty=True),
    )
    predictor_order: int | str = key(
        "auto", "order of the extrapolation of lagged inputs; auto: 2 of a flutter case, 1 of a system file", low=0, high=2,
        choices=["auto"],
    )  # fmt: skip
    substeps: dict[str, int] = field(
        default_factory=dict, metadata=rule("component = number of steps it makes in one", low=1, high=100000, empty=True)
    )
    waveform: dict[str, str] = field(
        default_factory=dict,
        metadata=rule(
            "component = course of its inputs in a step: hold, linear or quadratic",
            choices=["hold", "linear", "quadratic"],
            empty=True,
        ),
    )
    tolerance: float = key(1e-6, "implicit: change of a coupled quantity / its magnitude", above=0.0, high=0.1)
    absolute_tolerance: float = key(0.0, "implicit: a change below this will do too, in the quantity's unit", low=0.0)
    tolerance_of: dict[str, float] = field(
        default_factory=dict,
        metadata=rule('tolerance of single quantities, "component.output" = value', above=0.0, high=0.1, empty=True),
    )
    absolute_tolerance_of: dict[str, float] = field(
        default_factory=dict, metadata=rule("absolute_tolerance of single quantities", low=0.0, empty=True)
    )
    max_iterations: int = key(12, "implicit: most passes of an attempt at a step", low=1, high=1000)
    stall_iterations: int = key(6, "implicit: passes without progress after which an attempt ends", low=1, high=1000)
    retries: int = key(1, "implicit: further attempts at a step that does not converge", low=0, high=10)
    acceleration: str = key(
        "iqn-ils", "implicit: constant, aitken or iqn-ils (quasi-Newton)", choices=["constant", "aitken", "iqn-ils"]
    )
    relaxation: float = key(1.0, "implicit: part of the first residual that is taken (constant: of all)", above=0.0, high=2.0)
    reuse_steps: int = key(8, "iqn-ils: earlier steps whose passes are used", low=0, high=1000)
    filter: float = key(1e-6, "iqn-ils: columns with less new in them than this are left out", low=0.0, high=1.0)

    @property
    def extrapolated(self) -> int:
        """The order of the extrapolation; that of a system file where it is left open (a flutter case sets it)."""
        return self.predictor_order if isinstance(self.predictor_order, int) else 1
