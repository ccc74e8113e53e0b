"""What a run leaves behind: one folder, complete or not there at all.

Everything is written to a hidden folder beside the target, which is renamed at the end. A run folder
already there is moved aside to `<name>.001`, `.002`, …; any other folder of that name is refused.
  case.toml       the resolved case
  result.json     the numbers of the command's JSON output, with provenance
  history*.nc     netCDF-3 history of each march, every variable with `units` and `long_name`
  run.log         what the run said, and the log messages of the FMUs
  *.png, fields/  pictures and flow fields; fields.pvd opens them in ParaView
"""

from __future__ import annotations

import contextlib
import datetime
import errno
import json
import os
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

from ..base import disk, files, interrupts
from ..base.errors import AeroSloshError
from ..case.case import Case, dump
from ..fmi.component import Component


class RunFolder:
    """Context manager over the hidden folder `path`; renamed to `target` when the block ends well, or by `publish` before.

    On an exception the hidden folder is removed, unless `keep()` was called: then what was written is published too. The
    exception carries as a note what became of the folder; what the disk refused becomes an AeroSloshError (INCOMPLETE).
    """

    def __init__(self, target: Path) -> None:
        self.target = target.absolute()
        if (
            self.target.exists()
            and not (self.target / "case.toml").is_file()
            and (not self.target.is_dir() or any(self.target.iterdir()))
        ):
            raise AeroSloshError(
                "The output folder exists and holds something else than a run",
                str(self.target),
                "give another folder with --out, or remove it",
            )
        self.path = self.target.with_name(f".{self.target.name}.part-{os.getpid()}")
        self._keep = False

    def __enter__(self) -> RunFolder:
        with self._writable():
            interrupts.UNFINISHED.add(self.path)
            shutil.rmtree(self.path, ignore_errors=True)
            self.path.mkdir(parents=True)
            self._log = (self.path / "run.log").open("w", encoding="utf-8")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _t: TracebackType | None) -> None:
        with contextlib.suppress(OSError):
            self._log.close()
        if error is None or self._keep:
            self.publish()
            if error is not None:
                error.add_note(f"what was written is kept in {self.target}")
        else:
            self._remove(error)
        if isinstance(error, OSError) and disk.of_disk(error):
            kept = f" (what could be written is kept in {self.target})" if self._keep else ""
            raise disk.explained(error, f"{error.filename or self.target}{kept}") from None

    def keep(self) -> None:
        """Publish the folder even when the run ends with an error."""
        self._keep = True

    def publish(self) -> None:
        """Give the folder its name now: whatever happens from here on, what is in it stays. An earlier run there moves aside."""
        if self.path == self.target:
            return
        while True:
            try:
                os.rename(self.path, self.target)
                break
            except OSError as error:  # an earlier run, or one that another process published this very moment
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
            self._move_aside()
        interrupts.UNFINISHED.discard(self.path)
        self.path, self._keep = self.target, True

    def log(self, text: str) -> None:
        """One entry in run.log; a full disk must not keep the user from reading it elsewhere."""
        with contextlib.suppress(OSError):
            self._log.write(f"{datetime.datetime.now().isoformat(timespec='milliseconds')}  {text}\n")
            self._log.flush()

    def log_messages(self, components: Iterable[Component]) -> None:
        """The FMUs' log messages into run.log, each once."""
        for component in components:
            self.log_lines([(component.name, *said) for said in component.messages])
            component.messages.clear()

    def log_lines(self, lines: Iterable[tuple[str, int, str]]) -> None:
        """Log messages of FMUs: component, FMI status, text."""
        for name, status, text in lines:
            self.log(f"{name} (status {status}): {text}")

    def write_case(self, case: Case) -> None:
        """case.toml of a case. Raises AeroSloshError (INPUT)."""
        self.write_settings(dump(case))

    def write_settings(self, text: str) -> None:
        """case.toml, before anything is computed. Raises AeroSloshError (INPUT)."""
        with self._writable():
            files.write(self.path / "case.toml", text.encode())

    def write_result(self, result: dict[str, Any]) -> None:
        """result.json, whole or as it was. Raises OSError."""
        text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False)
        files.write(self.path / "result.json", f"{text}\n".encode())

    @contextlib.contextmanager
    def _writable(self) -> Iterator[None]:
        """What cannot be written at the start is an input that cannot be used."""
        try:
            yield
        except OSError as error:
            shutil.rmtree(self.path, ignore_errors=True)
            raise AeroSloshError(
                f"The output folder cannot be written: {error.strerror}",
                str(self.target),
                "free space, or give another with --out" if error.errno in disk.FULL else "give another with --out",
            ) from None

    def _remove(self, error: BaseException) -> None:
        shutil.rmtree(self.path, ignore_errors=True)
        gone = not self.path.exists()
        error.add_note("the unfinished run folder was removed" if gone else f"the unfinished {self.path} could not be removed")
        if gone:
            interrupts.UNFINISHED.discard(self.path)

    def _move_aside(self) -> None:
        for number in range(1, 1000):
            aside = self.target.with_name(f"{self.target.name}.{number:03d}")
            if aside.exists():
                continue
            try:
                os.rename(self.target, aside)
                return
            except FileNotFoundError:  # another process moved it
                return
            except OSError as error:  # another process took this number
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
        else:
            raise AeroSloshError(f"999 earlier runs of {self.target.name} are kept", str(self.target.parent), "remove old ones")
