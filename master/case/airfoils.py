"""The section's name in a case: a file is found once and then named by its full path, an unknown name is refused before anything
starts.

Which names there are the aero FMU tells itself, in the table `airfoil_names.json` among its resources; of an FMU without that
table nothing is known and every name is let through."""

from __future__ import annotations

import difflib
import itertools
import json
import re
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import AeroSloshError

if TYPE_CHECKING:
    from .case import Case

KEY = "flow.airfoil"
TABLE = "airfoil_names.json"
_LOOKALIKE = str.maketrans("OQILSZB", "0011528")
_NAME = re.compile(r"(naca)?[\s_-]*[0-9a]{4,6}", re.IGNORECASE)


def is_file(path: Path | str) -> bool:
    """Whether there is such a file; False for words that no file can be called."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def resolved(word: str, *folders: Path) -> str:
    """The full path of the file `word` in the first of `folders` that has it, else `word` as it is."""
    for folder in folders:
        if word and is_file(folder / word):
            return str((folder / word).resolve())
    return word


def found(word: str, case: Path, set_: bool) -> str:
    """`resolved` for a case: beside its file, then in the current directory; the other way round where --set gave the word.

    What looks like a NACA name is a file's beside the case alone."""
    here = [] if _NAME.fullmatch(word.strip()) else [Path()]
    return resolved(word, *here, case.parent) if set_ else resolved(word, case.parent, *here)


def set_by(overrides: Sequence[str]) -> str:
    """The last override of the key, or nothing."""
    return next((text for text in reversed(overrides) if text.partition("=")[0].strip() == KEY), "")


def place(case: Case) -> str:
    """Where the airfoil of a case was named, for messages: the override, or file and line."""
    return case.places.get(KEY) or f"{case.source or 'ae.Case'}, key {KEY} (at its default)"


def check(word: str, where: str, fmu: Path, *folders: Path) -> None:
    """Refuse an airfoil that is no file and no name that `fmu` knows, with the nearest name or the nearest file of `folders`.

    Raises AeroSloshError."""
    table = _table(fmu)
    if table is None or is_file(word) or _known(word, table):
        return
    families = {f["family"]: f["example"] for f in reversed(table["families"])}
    known = ", ".join(f"{family} as '{example}'" for family, example in reversed(families.items()))
    near = _nearest(word, table, folders)
    raise AeroSloshError(
        f'{KEY} = "{word}" is neither a section that {fmu.name} knows nor a file',
        where,
        (f"did you mean '{near}'? " if near else "") + f"(known: {known}; or a coordinate file by its path)",
    )


def fault(what: str) -> str | None:
    """What the aero FMU says of an airfoil that gives no mesh, in `what` of its failure: the user's input, wrong at every Mach
    number. None where the failure is another."""
    match = re.search(r"(?:Airfoil|Mapping)Error: (airfoil .*)", what, re.DOTALL)
    return match[1][0].upper() + match[1][1:] if match else None


def _table(fmu: Path) -> dict[str, Any] | None:
    """The FMU's table of names, or None."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            name = next((n for n in archive.namelist() if n.endswith(f"/{TABLE}")), "")
            return json.loads(archive.read(name)) if name else None
    except (OSError, ValueError, zipfile.BadZipFile):
        return None  # what is wrong with the FMU is told when it is loaded


def _code(word: str, table: dict[str, Any]) -> str:
    """The name without the prefix, in capitals."""
    return re.sub(rf"^{table['prefix']}[\s_-]*", "", word.strip(), flags=re.IGNORECASE).upper()


def _known(word: str, table: dict[str, Any]) -> bool:
    code = _code(word, table)
    for family in table["families"]:
        stem, (low, high) = family["stem"], family["thickness"]
        fits = len(code) == len(stem) + 2 and all(c in allowed for c, allowed in zip(code, stem, strict=False))
        if fits and re.fullmatch("[0-9]{2}", code[-2:]) and low <= int(code[-2:]) <= high:
            return True
    return False


def _nearest(word: str, table: dict[str, Any], folders: Sequence[Path]) -> str:
    """The name or the file most like `word`; letters are taken for the digits they look like. Empty where nothing is like it."""
    code = _code(word, table)
    names = [
        "".join(letters) + f"{percent:02d}"
        for family in table["families"]
        for letters in itertools.product(*family["stem"])
        for percent in range(family["thickness"][0], family["thickness"][1] + 1)
    ]
    files = [path for folder in folders for path in _beside(folder / word)]
    scored = [(_like(code.translate(_LOOKALIKE), name), 0.75, f"{table['prefix']} {name}") for name in names]
    scored += [(_like(Path(word).name.lower(), path.name.lower()), 0.6, str(path)) for path in files]
    best = max((s for s in scored if s[0] >= s[1]), key=lambda s: s[0], default=(0.0, 0.0, ""))
    return best[2]


def _like(a: str, b: str) -> float:
    return difflib.SequenceMatcher(None, a, b).ratio()


def _beside(path: Path) -> list[Path]:
    """The files in the folder of `path`, at most a thousand."""
    try:
        return sorted(itertools.islice((p for p in path.parent.iterdir() if p.is_file()), 1000))
    except (OSError, ValueError):
        return []
