"""One flutter point: computed in a run folder (the command) or in memory, and what a program gets of it."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis.verdict import Verdict
from ..base import notices, pvd
from ..case import airfoils, checks, fmu_parameters, fuel_tank, plausible
from ..case import case as cases
from ..cosim.checkpoint import Checkpoint, Keeper
from ..flutter import coarse_marches, ensemble
from ..flutter import march as flutter_march
from ..flutter.march import March
from ..flutter.setup import FlutterSetup, find_fmus
from ..fmi import installed, unpack
from ..results import summary
from ..results.history_writer import write_history
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from . import datasets, plots
from .case import Case
from .members import Members
from .progress import Callback, Reporter, interruptible, reporter

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


DOUBTS = 5  # warnings shown, of a sweep's points too


@dataclass
class Point:
    """The outcome of one march.

    case    the case that was marched
    data    the numbers, as in result.json
    folder  the run folder, None where nothing was written"""

    case: Case | None
    data: dict[str, Any]
    folder: Path | None = None
    march: March | None = field(default=None, repr=False)

    @property
    def verdict(self) -> Verdict:
        """Damped, neutral, flutter, divergence, limit cycle or undetermined; a text and an enum at once."""
        return Verdict(self.data["verdict"])

    @property
    def reason(self) -> str:
        """What the verdict rests on."""
        return str(self.data["reason"])

    @property
    def remedy(self) -> str:
        """What to do where there is no verdict; empty else."""
        return str(self.data.get("remedy") or "")

    @property
    def mach(self) -> float:
        """Mach number."""
        return float(self.data["mach"])

    @property
    def V_f(self) -> float:
        """U / (b omega_alpha sqrt(mu))."""
        return float(self.data["V_f"])

    @property
    def growth_rate(self) -> float:
        """Of the critical mode, over omega_alpha; nan where nothing could be fitted."""
        return _number(self.data["growth_rate"])

    @property
    def growth_rate_uncertainty(self) -> float:
        """Standard deviation of the growth rate, over omega_alpha: fit, mesh with step and outer boundary, and amplitude
        (docs/verdict.md); what is not in it is named in data["uncertainty_missing"]."""
        return _number(self.data["growth_rate_uncertainty"])

    @property
    def frequency(self) -> float:
        """Of the critical mode, over omega_alpha; 0 for divergence."""
        return _number(self.data["frequency"])

    @cached_property
    def history(self) -> xr.Dataset:
        """Every channel over time [s], with units. Raises AeroSloshError where the run kept none."""
        if self.march is not None:
            return datasets.of_march(self.march)
        assert self.folder is not None
        return datasets.of_file(self.folder / "history.nc")[0]

    def plot(self) -> Figure:
        """Plunge and pitch over time."""
        title = f"Mach {self.mach:g}, V_f {self.V_f:g}, {fuel_tank.LABEL[self.data['slosh']]}: {self.verdict}"
        return plots.motion(self.history, title)

    def __repr__(self) -> str:
        rate = f"growth rate {self.growth_rate:+.5f} ± {self.growth_rate_uncertainty:.5f}, frequency {self.frequency:.4f}"
        return f"Point(Mach {self.mach:g}, V_f {self.V_f:g}: {self.verdict}; {rate})"


def point(
    case: Case | str | os.PathLike[str],
    *,
    mach: float | None = None,
    V_f: float | None = None,
    slosh: str | None = None,
    folder: str | os.PathLike[str] | None = None,
    fmus: str | os.PathLike[str] | None = None,
    progress: bool | Callback = False,
) -> Point:
    """March one Mach number and V_f: does it flutter?

    mach, V_f, slosh  instead of flow.mach, flutter.V_f, slosh.model
    folder            a run folder to write, as the command does (an earlier one moves aside); None: all stays in memory
    fmus              the folder of the FMUs; None: AEROSLOSH_FMUS, dist/fmus of a checkout, or built once into the user's cache
    progress          True: a line on standard error; a callback is given `Update`s and cancels by returning False

    Raises AeroSloshError for what cannot be computed, ComponentError when an FMU fails, Cancelled."""
    core = with_changes(case, {"flow.mach": mach, "flutter.V_f": V_f, "slosh.model": slosh}, "point")
    found = find_fmus(fmu_folder(fmus), core.slosh.model, core.slosh.predictor)
    check_fmus(core, found)
    report, said = reporter(progress), warned([core], "point")
    with interruptible(), notices.to(report.say):
        if folder is None:
            computed = compute(core, found, report)
            computed.data |= said
            if computed.march.failure is not None:
                raise computed.march.failure
            return Point(Case(core), computed.data, None, computed.march)
        with RunFolder(Path(folder)) as run:
            run.write_case(core)
            computed = compute(core, found, report, run)
            computed.data |= said
            write(core, computed, run)
        if computed.march.failure is not None:
            raise computed.march.failure
        return Point(Case(core), computed.data, run.target, computed.march)


@dataclass
class Computed:
    """A march with its numbers, provenance and the line that the aero FMU says of its section."""

    march: March
    data: dict[str, Any]
    about: dict[str, Any]
    airfoil: str


def compute(
    case: cases.Case,
    fmus: dict[str, Path],
    report: Reporter,
    folder: RunFolder | None = None,
    keeper: Keeper | None = None,
    start: Checkpoint | None = None,
    fields: bool = True,
) -> Computed:
    """March `case`. With a `folder` its log is kept, and flow fields (unless not `fields`) and section are written there."""
    hashes = {name: unpack.sha256(path) for name, path in files(case, fmus).items()}
    mach, V_f = case.flow.mach, case.flutter.V_f
    place = folder.path / "fields" if folder is not None and case.output.fields and fields else None
    if place is not None:
        place.mkdir()
    section = section_file(folder) if folder is not None and case.output.pictures else None

    def say(text: str) -> None:
        if folder is not None:
            folder.log(text)
        report.say(text)

    with Members(case, fmus, say) as members, FlutterSetup(case, fmus, mach, place, say, section) as setup:
        if folder is not None:
            for loop in setup.system.loops:
                folder.log(f"algebraic loop, closed by the coupling scheme {case.coupling.scheme}: {' '.join(loop)}")
        say(f"march at Mach {mach:g}, V_f {V_f:g}")
        report.start(f"M {mach:g} V_f {V_f:.4g}")
        march = flutter_march.march(setup, V_f, place, report.watch, keeper, start)
        if len(ensemble.seeds(case)) > 1 and march.failure is None:
            found = members.gathered(ensemble.of_march(march, case.slosh.seed))
            march = ensemble.averaged(march, found, case.flutter.neutral_band)
        wanted = case.flutter.companion
        change = coarse_marches.beside(case, fmus, march, say) if wanted else coarse_marches.Change()
        march = coarse_marches.widened(march, change)
        data = summary.march_data(march, setup.steady_cpu, change) | {"airfoil_summary": setup.airfoil_summary or None}
        if folder is not None:
            folder.log_messages(setup.system.components)
        return Computed(march, data, provenance(hashes), setup.airfoil_summary)


def write(case: cases.Case, computed: Computed, folder: RunFolder) -> None:
    """The files of a point: history, result, pictures. Raises OSError."""
    march = computed.march
    write_history(folder.path / "history.nc", march, computed.about)
    folder.write_result(computed.data | {"provenance": computed.about})
    if march.fields:
        instants = {pvd.number(path): tau / march.scales.omega_alpha for tau, path in march.fields}
        pvd.write_beside(folder.path / "fields", instants)
    if not case.output.pictures:
        return
    from ..pictures import mach_field  # matplotlib takes half a second to import
    from ..pictures import march as pictures

    pictures.histories(march, folder.path / "histories.png")
    pictures.phase(march, folder.path / "phase.png")
    if march.fields:
        mach_field.save(march, folder.path / "mach_field.png", case.section.chord, case.section.elastic_axis)
    draw_section(folder, computed.airfoil)


def files(case: cases.Case, fmus: dict[str, Path]) -> dict[str, Path]:
    """The FMU of each component."""
    liquid = {"slosh": case.slosh.model, "slosh_predictor": case.slosh.predictor}
    own = {"structure": fmus["structure"], "aero": fmus["aero"]}
    return own | {name: fmus[fuel_tank.FMU[model]] for name, model in liquid.items() if model in fuel_tank.FMU}


def section_file(folder: RunFolder) -> Path:
    """Where the aero FMU writes the section of a run."""
    return folder.path / "airfoil.csv"


def draw_section(folder: RunFolder, said: str) -> None:
    """airfoil.png, from the table that the aero FMU wrote; `said`: its own line on the section."""
    if section_file(folder).is_file():
        from ..pictures import airfoil  # matplotlib takes half a second to import

        airfoil.draw(section_file(folder), folder.path / "airfoil.png", said)


def with_changes(case: Case | str | os.PathLike[str], changes: Mapping[str, Any], command: str) -> cases.Case:
    """The case with those `changes` that are not None, complete for `command`. Raises AeroSloshError."""
    given = {key: value for key, value in changes.items() if value is not None}
    return cases.changed(Case.of(case).changed(given).core, {}, f"ae.{command}", command)


def noted(asked: Sequence[cases.Case], command: str) -> dict[str, Any]:
    """What nobody gave in the cases `asked` (a sweep's points, or one) and what is unusual in any of them, for the results."""
    doubts = list(dict.fromkeys(doubt for case in asked for doubt in plausible.doubts(case)))
    return {"defaults": checks.defaults(asked[0], command), "warnings": doubts}


def warned(asked: Sequence[cases.Case], command: str) -> dict[str, Any]:
    """The same, and what is unusual as warnings of the caller's caller, DOUBTS of them at most."""
    found = noted(asked, command)
    for doubt in found["warnings"][:DOUBTS]:
        warnings.warn(doubt, stacklevel=3)
    return found


def check_fmus(case: cases.Case, fmus: dict[str, Path]) -> None:
    """Refuse an airfoil or a parameter that the FMUs do not know, before anything starts. Raises AeroSloshError."""
    airfoils.check(case.flow.airfoil, airfoils.place(case), fmus["aero"], Path(case.source).parent, Path())
    fmu_parameters.check(case, fmus)


def fmu_folder(fmus: str | os.PathLike[str] | None) -> Path:
    """The folder named, or this package's own."""
    return installed.folder() if fmus is None else Path(fmus)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
