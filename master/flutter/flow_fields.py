"""The flow fields of a march: at which steps the aero FMU writes them, and where they end up."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterable
from pathlib import Path

from ..fmi.component import Component


class Fields:
    """Asks `aero` for its fields at the steps that `again` names; they end up in `folder` (None: no fields are asked for)."""

    def __init__(self, aero: Component, folder: Path | None) -> None:
        self._aero, self._folder, self._source = aero, folder, folder
        self._steps = set[int]()
        self._writing = False
        self._taken: list[int] = []

    @property
    def wanted(self) -> bool:
        """Whether fields are written at all."""
        return self._folder is not None

    def resume(self) -> None:
        """The FMU has the state of an interrupted march: its folder is that run's, and it may have been about to write."""
        if "write_fields" not in self._aero.variables:
            return
        self._aero.set("write_fields", False)
        if self._folder is None:
            return
        self._source = Path(self._aero.get("field_folder"))  # fixed since its initialisation: gathered from there at the end
        try:
            self._source.mkdir(parents=True, exist_ok=True)
        except OSError:  # another machine, or a folder of another user: a march is worth more than its pictures
            self._folder = None

    def before(self, step: int) -> None:
        """The march is about to make `step`."""
        wanted = step in self._steps
        if wanted is not self._writing:
            self._writing = wanted
            self._aero.set("write_fields", wanted)
        if wanted:
            self._taken.append(step)

    def again(self, steps: Iterable[int]) -> None:
        """The march goes on: `steps` instead of those before, whose files go."""
        if self._folder is None:
            return
        if self._writing:
            self._writing = False
            self._aero.set("write_fields", False)
        for pattern in ("fields_*.vts", "surface_*.vtp"):
            for path in sorted(self._source.glob(pattern))[-len(self._taken) :] if self._taken and self._source else []:
                path.unlink()
        self._steps, self._taken = set(steps), []

    def end(self, done: int, failed: bool) -> list[tuple[int, Path]]:
        """The march is over after `done` steps that count; returns step and file of each flow field, oldest first."""
        if failed:  # in the step after the last one: it wrote nothing
            self._taken = [step for step in self._taken if step <= done]
        elif self._writing:
            self._aero.set("write_fields", False)
        if self._folder is None or self._source is None:
            return []
        if self._source != self._folder:
            self._gather(self._source, self._folder)
        files = sorted(self._folder.glob("fields_*.vts"))
        return [(step, path) for step, path in zip(self._taken, files, strict=False) if step <= done]

    def _gather(self, source: Path, folder: Path) -> None:
        """Move the newest files, those of this process, from `source`; leave no empty folders there."""
        for pattern in ("fields_*.vts", "surface_*.vtp"):
            for path in sorted(source.glob(pattern))[-len(self._taken) :] if self._taken else []:
                shutil.move(path, folder / path.name)
        for place in (source, source.parent):  # made anew for this march, unless the interrupted run left them
            with contextlib.suppress(OSError):
                place.rmdir()
