"""Drives a slosh FMU through motions of its tank, for records that a surrogate learns from.

`Drive` is a picklable function: fmus/slosh_rbf/training/dataset.py takes it and calls it in processes of its own
(studies/slosh_records.py puts the two together). Any slosh FMU on any grid: its parameters come with each record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import AeroSloshError
from ..fmi import table_drive
from ..fmi.component import Component
from ..fmi.unpack import sha256

Array = NDArray[np.float64]

INPUTS = ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot", "x", "x_dot", "x_ddot")
LOADS = ("force_x", "force_y", "moment", "force_x_tank", "force_y_tank", "force_west", "force_east")
LINEAR_LOADS = LOADS[:3]
"""What every slosh FMU has; the others are of slosh_vof."""


@dataclass(frozen=True)
class Drive:
    """Loads of the FMU at `path`, whose content is `sha256`, in a motion. outputs: the names wanted."""

    path: Path
    sha256: str
    outputs: tuple[str, ...] = LOADS

    @classmethod
    def of(cls, path: Path, outputs: tuple[str, ...] = LOADS) -> Drive:
        """The drive of the FMU that lies there now. Raises AeroSloshError where there is none."""
        if not path.is_file():
            raise AeroSloshError(f"The FMU {path.name} is missing", str(path), "build the FMUs with `make fmus`")
        return cls(path.absolute(), sha256(path), outputs)

    @property
    def model(self) -> dict[str, str]:
        """What names these loads: for `generate`."""
        return {"fmu": self.path.stem, "fmu_sha256": self.sha256, "outputs": " ".join(self.outputs)}

    def __call__(self, parameters: Mapping[str, Any], times: Array, motions: Array) -> dict[str, Array]:
        """Outputs {name: (n,)} at times (n,) [s] under motions (n, 9) in the order of INPUTS [m, rad, s].

        Raises AeroSloshError for an FMU that has changed, an unknown parameter or output, ComponentError when the FMU fails."""
        component = Component(self.path, self.path.stem)
        try:
            if component.sha256 != self.sha256:
                raise AeroSloshError("The FMU has changed meanwhile", str(self.path), "start again: all records of one FMU")
            missing = [name for name in self.outputs if name not in component.variables]
            if missing:
                known = ", ".join(component.outputs.names)
                raise AeroSloshError(f"{self.path.name} has no output '{missing[0]}'", str(self.path), f"its outputs are {known}")
            component.set_all(parameters)
            columns = table_drive.run(component, table_drive.Table(times, list(INPUTS), motions))
            return {name: columns[name] for name in self.outputs}
        finally:
            component.close()
