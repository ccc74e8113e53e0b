"""Put the site's sources together: the repository's own pages at their own paths, so that links between them hold, with the
pictures and files that they link to, and the reference that is made from the code.

    python docs/site/stage.py FOLDER [--fmus dist/fmus]"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

import case_pages  # noqa: E402  (scripts beside this one)
import code_pages  # noqa: E402
import fmu_pages  # noqa: E402

LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def pages() -> list[Path]:
    """The Markdown pages of the repository that the site shows, and their links are checked by tests/docs."""
    found = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
    for pattern in ("docs/*.md", "docs/tutorials/*.md", "docs/howto/*.md", "fmus/*/README.md", "examples/**/README.md"):
        found += sorted(ROOT.glob(pattern))
    return found


def links(page: Path) -> list[Path]:
    """Local files that a page links to, code left out."""
    text = re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
    return [(page.parent / word).resolve() for word in LINK.findall(text) if "://" not in word and not word.startswith("mailto:")]


def stage(out: Path, fmus: Path) -> None:
    """Write the sources into `out`, anew; `fmus` holds the built FMUs. Raises FileNotFoundError for a link to nothing."""
    shutil.rmtree(out, ignore_errors=True)
    copied = {*pages(), ROOT / "docs" / "pictures" / "flutter.png"}
    for page in pages():
        copied |= set(links(page))
    for path in sorted(copied):
        target = out / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    for path in HERE.glob("*.md"):
        shutil.copyfile(path, out / path.name)
    (out / "_static").mkdir()
    for name, place in (("conf.py", out), ("site.css", out / "_static")):
        shutil.copyfile(HERE / name, place / name)
    (out / "reference").mkdir()
    for name, text in {**case_pages.pages(), **code_pages.pages(), **fmu_pages.pages(fmus)}.items():
        (out / "reference" / f"{name}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    options = parser.parse_args()
    stage(options.out, options.fmus)
