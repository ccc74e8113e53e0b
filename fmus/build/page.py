"""documentation/index.html of an FMU: the component's README, a picture, and facts about the file.

Markdown is CommonMark with tables (markdown-it-py). Build only: no FMU carries this module.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape
from xml.etree.ElementTree import Element

from markdown_it import MarkdownIt

KINDS = {
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
}
STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #1b2733; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 2rem; border-bottom: 1px solid #d5dde5; }
code, pre { font: 0.88em ui-monospace, monospace; background: #f3f6f8; }
pre { padding: 0.7rem; overflow-x: auto; font-size: 0.8em; }
table { border-collapse: collapse; font-size: 0.9em; margin: 0.8rem 0; display: block; overflow-x: auto; }
th, td { border: 1px solid #d5dde5; padding: 0.2rem 0.5rem; text-align: left; vertical-align: top; } th { background: #f3f6f8; }
td:nth-child(3) code, td:nth-child(4):not(:last-child) { white-space: nowrap; }
img.icon { float: right; width: 6rem; height: 6rem; margin: 0 0 1rem 1rem; } img.wide { max-width: 100%; }
"""


def index(readme: str, description: Element, *, icon: bool, picture: bool) -> str:
    """Return documentation/index.html as text.

    Args:
        readme: the component's README in Markdown; "" where it has none.
        description: the root of modelDescription.xml.
        icon: whether the FMU holds model.png.
        picture: whether it holds documentation/reference/picture.svg.
    """
    name = description.get("modelName", "")
    body = MarkdownIt("commonmark", {"html": True}).enable("table").render(readme or bare_page(description))
    # links into the source tree lead nowhere from inside an FMU
    body = re.sub(r'<a href="(?!https?:|#|reference/)[^"]*">(.*?)</a>', r"\1", body)
    if picture:
        figure = f'<p><img class="wide" src="reference/picture.svg" alt="Reference result of {escape(name)}"></p>'
        head, found, tail = body.partition("<h2>Reference result</h2>")
        body = f"{head}{found}\n{figure}{tail}" if found else body + figure
    image = '<img class="icon" src="../model.png" alt="">' if icon else ""
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(name)}</title>'
        f"<style>{STYLE}</style></head>\n<body>\n{image}\n{body}\n{_facts(description)}\n</body></html>\n"
    )


def bare_page(description: Element) -> str:
    """Return what is said of a component without README, in Markdown."""
    return f"# {description.get('modelName')}\n\n{description.get('description', '')}\n\n{variable_tables(description)}"


def variable_tables(description: Element) -> str:
    """Return all variables as Markdown tables by causality: name, unit, start, range, description."""
    items = {
        simple.get("name", ""): [(item.get("value"), item.get("name"), item.get("description")) for item in simple.iter("Item")]
        for simple in description.iter("SimpleType")
    }
    parts = []
    for causality, title in KINDS.items():
        found = [v for v in description.iter("ScalarVariable") if v.get("causality") == causality]
        if not found:
            continue
        extra = causality != "output"
        ranges = extra and any(v[0].get("min") or v[0].get("max") for v in found)
        rows = [["name", "unit", *(["start"] if extra else []), *(["range"] if ranges else []), "meaning"]]
        for variable in found:
            kind = variable[0]
            text = variable.get("description", "")
            choices = items.get(kind.get("declaredType", ""), [])
            if choices:
                text += ": " + "; ".join(f"{value} {name} ({meaning})" for value, name, meaning in choices)
            unit = kind.get("unit") or {"Real": "", "Enumeration": "choice"}.get(kind.tag, kind.tag)
            start = [f"`{_shown(kind)}`" if kind.get("start") else ""] if extra else []
            bounds = [_range(kind, bool(choices))] if ranges else []
            rows.append([f"`{variable.get('name')}`", unit, *start, *bounds, text])
        parts.append(f"### {title}\n\n{table(rows)}")
    return "\n\n".join(parts)


def table(rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table; the first row is the header."""
    header, *body = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (header, ["---"] * len(header), *body))


def _shown(kind: Element) -> str:
    start = kind.get("start", "")
    return f"{float(start):.8g}" if kind.tag == "Real" else start


def _range(kind: Element, choices: bool) -> str:
    least, most = kind.get("min"), kind.get("max")
    if choices or (least is None and most is None):
        return ""
    low, high = (f"{float(bound):g}" if bound is not None else "" for bound in (least, most))
    if most is None:
        return f"≥ {low}"
    return f"{low} to {high}" if least is not None else f"≤ {high}"


def _facts(description: Element) -> str:
    simulation = description.find("CoSimulation")
    experiment = description.find("DefaultExperiment")
    assert simulation is not None and experiment is not None
    flags = [key for key, value in simulation.attrib.items() if value == "true"]
    rows = [
        ["Model identifier, version", f"{simulation.get('modelIdentifier')}, {description.get('version')}"],
        ["guid (names interface and sources)", f"<code>{description.get('guid')}</code>"],
        ["FMI", "2.0, co-simulation; " + ", ".join(f"<code>{flag}</code>" for flag in flags)],
        ["Default experiment", "0 to {stopTime} s, step {stepSize} s".format(**experiment.attrib)],
        ["Platforms", "linux64 (glibc 2.17 or later); no Windows, no macOS, no arm64"],
        ["Needs", "Python 3.11 or newer with the packages of <code>resources/requirements.txt</code>"],
        ["In a Python host (FMPy, libcosimpy, ecospy)", "nothing else"],
        [
            "In another host",
            "nothing else where this machine's Python is found: <code>AEROSLOSH_PYTHON</code>, the one in "
            "<code>resources/python.txt</code>, or <code>python3</code> on PATH; with its shared libpython",
        ],
        ["Reference result", "<code>documentation/reference/</code>: experiment.json, input.csv, output.csv"],
    ]  # fmt: skip
    cells = "\n".join(f"<tr><th>{name}</th><td>{text}</td></tr>" for name, text in rows)
    return f"<h2>This file</h2>\n<table>\n{cells}\n</table>"
