"""The cases that come with the package, by name."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).absolute().parents[2] / "cases"  # aeroslosh/cases: a link in a checkout, a folder where installed


def names() -> list[str]:
    """Their names, in alphabetical order."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def case_path(word: str) -> Path:
    """`resolve` for the command line."""
    return resolve(Path(word))


def resolve(path: Path) -> Path:
    """`path`, or the built-in case of that name where there is no such file."""
    found = FOLDER / f"{path.name}.toml"
    if path.parent == Path() and not path.suffix and not path.is_file() and found.is_file():
        return found
    return path
