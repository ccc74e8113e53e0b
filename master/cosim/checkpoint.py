"""A march in a file, to be continued in another process to the same bits.

The file is a numpy archive (.npz, no pickles): the FMUs' serialised states, what the coupling scheme remembers, the history so
far, and a JSON text with where the march stood and what it was. It is written beside its name and renamed: a kill leaves the
one before."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from ..base import files
from ..base.errors import AeroSloshError, ExitCode
from ..fmi import unpack
from ..fmi.component import no_serialization
from .scheme import Scheme
from .system import System

FORMAT = 1
Arrays = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Checkpoint:
    """`about`: JSON data of the march (its case, FMU hashes, step …); `arrays` by "part/name"."""

    path: Path
    about: dict[str, Any]
    arrays: dict[str, np.ndarray]

    def part(self, name: str) -> dict[str, np.ndarray]:
        """The arrays of one part."""
        start = f"{name}/"
        return {k.removeprefix(start): v for k, v in self.arrays.items() if k.startswith(start)}

    def restore(self, system: System, scheme: Scheme) -> None:
        """Bring a system of the same FMUs, initialised, and its scheme, reset, to where the march stood.

        Raises ComponentError when an FMU refuses its state."""
        for component in system.everyone:
            part = self.part(f"component.{component.name}")
            component.inputs.values[:] = part["inputs"]
            component.restore(part["state"].tobytes(), float(part["time"]), int(part["steps"]))
        for component, stride in zip(system.components, system.strides, strict=True):
            stride.restore(self.part(f"stride.{component.name}"))
        system.collect()
        scheme.restore(self.part("scheme"))


@dataclass
class Keeper:
    """Writes checkpoints to `path`, meant for every `every` steps. `about`: JSON data that is the same in all."""

    path: Path
    every: int
    about: dict[str, Any]

    def check(self, system: System) -> None:
        """Before the march: raise AeroSloshError when an FMU cannot serialise its state."""
        for component in system.everyone:
            if not component.can_serialize:
                raise no_serialization(component.name, component.path)

    def write(self, system: System, scheme: Scheme, more: Mapping[str, Arrays], now: Mapping[str, Any]) -> None:
        """Write a checkpoint: `more` are further parts, `now` further JSON data.

        Raises AeroSloshError when the file cannot be written or an FMU cannot serialise."""
        parts: dict[str, Arrays] = {"scheme": scheme.state(), **more}
        for component in system.everyone:
            parts[f"component.{component.name}"] = {
                "state": np.frombuffer(component.serialized(), dtype=np.uint8),
                "time": np.array(component.time),
                "steps": np.array(component.steps),
                "inputs": component.inputs.values,
            }
        for component, stride in zip(system.components, system.strides, strict=True):
            parts[f"stride.{component.name}"] = stride.state()
        arrays = {f"{part}/{name}": array for part, content in parts.items() for name, array in content.items()}
        text = json.dumps({"format": FORMAT, **self.about, **now}).encode()
        whole = io.BytesIO()
        np.savez(whole, about=np.frombuffer(text, dtype=np.uint8), **arrays)  # type: ignore[arg-type]
        try:
            files.write(self.path, whole.getvalue())
        except OSError as error:
            what, remedy = f"The checkpoint cannot be written: {error.strerror}", "free space, or name another file"
            raise AeroSloshError(what, str(self.path), remedy, ExitCode.INCOMPLETE) from None


def read(path: Path) -> Checkpoint:
    """Read a checkpoint. Raises AeroSloshError for a file that is none."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        about = json.loads(arrays.pop("about").tobytes())
        version = about["format"]
    except OSError as error:
        raise AeroSloshError(
            f"The checkpoint cannot be read: {error.strerror}", str(path), "give a file that a run wrote"
        ) from None
    except (ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:  # all that numpy has for it
        raise AeroSloshError(
            f"This is no checkpoint, or a damaged one ({type(error).__name__})",
            str(path),
            "give a whole file that --checkpoint wrote",
        ) from None
    if version != FORMAT:
        raise AeroSloshError(
            f"The checkpoint has format {version}, this version reads {FORMAT}", str(path), "use the version that wrote it"
        )
    return Checkpoint(path, about, arrays)


def check_files(fmus: Mapping[str, Path]) -> None:
    """Before any of them is instantiated: raise AeroSloshError when an FMU (component → file) cannot serialise its state."""
    for name, path in fmus.items():
        description = fmpy.read_model_description(str(unpack.unzip(path)[0]), validate=False)
        simulation = description.coSimulation
        if simulation is not None and not (simulation.canGetAndSetFMUstate and simulation.canSerializeFMUstate):
            raise no_serialization(name, path)


def check(checkpoint: Checkpoint, case: Mapping[str, Any], fmus: Mapping[str, str], free: tuple[str, ...]) -> None:
    """Refuse to continue another march: settings (`case`: key → value) and FMU hashes must be the same, but for keys in `free`.

    Raises AeroSloshError naming what differs."""
    before = checkpoint.about["case"]
    if ("flow.mach" in before) is not ("flow.mach" in case):
        kind = "a flutter point" if "flow.mach" in before else "a system file's run"
        raise AeroSloshError(f"The checkpoint is of {kind}", str(checkpoint.path), "restart it with the command that wrote it")
    changed = [k for k in sorted({*before, *case}) if before.get(k) != case.get(k) and k not in free]
    if changed:
        lines = ", ".join(f"{k}: {before.get(k)!r} then, {case.get(k)!r} now" for k in changed[:5])
        raise AeroSloshError(
            f"The checkpoint belongs to another case ({lines})", str(checkpoint.path), "restart with the case it was written with"
        )
    other = [name for name, value in fmus.items() if checkpoint.about["fmu_sha256"].get(name) != value]
    if other:
        raise AeroSloshError(
            f"The FMU of '{other[0]}' is not the one of the checkpoint",
            str(checkpoint.path),
            "restart with the FMUs it was written with, or start again",
        )
