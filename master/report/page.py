"""The page: one HTML file with everything in it, styles, script and pictures; no network, nothing to install."""

from __future__ import annotations

from pathlib import Path

from ..base import files
from ..base.errors import AeroSloshError
from ..results import past_run
from ..results.past_run import PastRun
from . import about, amplitude, boundary, point, sweep, system
from .markup import Markup, join, paragraph, section, tag

KINDS = {
    "point": point.build, "boundary": boundary.build, "amplitude": amplitude.build, "sweep": sweep.build, "run": system.build,
}  # fmt: skip
WORDS = {
    "point": "Flutter point", "boundary": "Flutter boundary", "amplitude": "Limit cycles", "sweep": "Sweep",
    "run": "Run of a system",
}  # fmt: skip
HERE = Path(__file__).parent


def write(path: Path, out: Path | None = None) -> Path:
    """Write the page of the run, sweep or system's run in the folder `path`; returns where it is: `out`, or report.html in it.

    Raises AeroSloshError for what is no run folder, and for an `out` that cannot be written."""
    if path.suffix == ".toml":
        raise AeroSloshError("This is no run yet, but a case or a system file", str(path), "run it, then give its run folder")
    run = past_run.load(path)
    if run.kind not in KINDS:
        raise AeroSloshError("A lone history has no result to report", str(path), "give the run folder that it lies in")
    target = out or (path if path.is_dir() else path.parent) / "report.html"
    if target.suffix.lower() not in (".html", ".htm"):
        raise AeroSloshError(f"--out {target}", "command line", "a name that ends in .html")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        files.write(target, html(run).encode("utf-8"))
    except OSError as error:
        raise AeroSloshError(
            f"The page cannot be written: {error.strerror}", str(target), "give another --out FILE.html"
        ) from None
    return target


def html(run: PastRun) -> str:
    """The whole document."""
    title, parts = KINDS[run.kind](run)
    told = section("Settings that differ from the defaults", about.settings(run))
    origin = section("Provenance", about.provenance(run))
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="generator", content="aeroslosh"),
        tag("title", title),
        tag("link", rel="icon", href="data:,"),
        tag("style", Markup((HERE / "page.css").read_text(encoding="utf-8"))),
    )
    date = run.provenance.get("date", "")
    kind = paragraph(f"{WORDS[run.kind]} · {run.path.name}{f' · {date}' if date else ''}", class_="kind")
    top = tag("header", tag("div", kind, tag("h1", title)), class_="top")
    script = tag("script", Markup((HERE / "page.js").read_text(encoding="utf-8")))
    body = tag("body", top, tag("main", *parts, told, origin), script)
    return "<!DOCTYPE html>\n" + join([tag("html", head, body, lang="en")]) + "\n"
