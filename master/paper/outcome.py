"""What the module of a figure gives: tables, picture, conditions, claims; and how it is kept in a folder."""

from __future__ import annotations

import csv
import io
import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base import disk, files, interrupts
from .claims import Claim, verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULT, PICTURE = "result.json", "picture.png"


@dataclass(frozen=True)
class Table:
    """Columns with their units in `header`, and rows of numbers and words."""

    header: tuple[str, ...]
    rows: Sequence[Sequence[object]]

    def text(self) -> str:
        """CSV, six digits, `.` and a line feed."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(self.header)
        writer.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in row] for row in self.rows)
        return out.getvalue()


@dataclass
class Outcome:
    """One figure of the paper, computed.

    claims      what of it can be compared
    conditions  what was chosen where the paper is silent, and where it is coarser than our best
    tables      name of a CSV file → its content
    draw        makes the picture, in the style of `pictures.look`
    remarks     what the numbers say beyond the claims"""

    claims: list[Claim]
    conditions: list[str]
    tables: dict[str, Table]
    draw: Callable[[], Figure]
    remarks: list[str] = field(default_factory=list)

    def write(self, target: Path, about: dict[str, Any]) -> dict[str, Any]:
        """Everything into the folder `target`, whole or not at all; returns what result.json holds: `about` and the outcome.

        Raises OSError."""
        hidden = target.with_name(f".{target.name}.part")
        shutil.rmtree(hidden, ignore_errors=True)
        hidden.mkdir(parents=True)
        interrupts.UNFINISHED.add(hidden)
        try:
            for name, table in self.tables.items():
                (hidden / f"{name}.csv").write_text(table.text(), encoding="utf-8")
            from ..pictures import canvas, look  # matplotlib takes half a second to import

            with canvas.rc_context(look.STYLE):
                self.draw().savefig(hidden / PICTURE)
            data = about | {
                "verdict": verdict(self.claims), "claims": [c.data() for c in self.claims],
                "conditions": self.conditions, "remarks": self.remarks,
                "files": [PICTURE, *(f"{name}.csv" for name in self.tables)],
            }  # fmt: skip
            files.write(hidden / RESULT, (json.dumps(data, indent=2, ensure_ascii=False) + "\n").encode())
            with interrupts.held():
                shutil.rmtree(target, ignore_errors=True)
                hidden.rename(target)
        except OSError as error:
            shutil.rmtree(hidden, ignore_errors=True)
            raise disk.explained(error, target) if disk.of_disk(error) else error from None
        except BaseException:
            shutil.rmtree(hidden, ignore_errors=True)
            raise
        finally:
            interrupts.UNFINISHED.discard(hidden)
        return data


def read(target: Path) -> dict[str, Any] | None:
    """result.json of a figure's folder, None where there is none that can be read."""
    try:
        found = json.loads((target / RESULT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and all((target / name).is_file() for name in found.get("files", [RESULT])) else None
