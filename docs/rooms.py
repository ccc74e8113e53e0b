"""Draw the rooms of `master/` and who imports whom, from the code: `python docs/rooms.py` writes docs/pictures/rooms.svg and
docs/data/rooms.csv. tests/test_rooms.py reads the code with the functions here, and sees that the table is up to date."""

from __future__ import annotations

import ast
import csv
import io
from collections import Counter
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DATA, PICTURE = ROOT / "docs" / "data" / "rooms.csv", ROOT / "docs" / "pictures" / "rooms.svg"
PACKAGE = "aeroslosh"
# from the ground up: rooms on one floor do not know of each other, and nobody looks up
FLOORS = (
    ("base",),
    ("fmi",),
    ("cosim",),
    ("case", "analysis"),
    ("flutter",),
    ("linear",),
    ("boundary",),
    ("results",),
    ("pictures",),
    ("report",),
    ("sweeps", "ssp", "hosts", "training"),
    ("api",),
    ("paper",),
    ("commands",),
    ("cli",),
)
WHAT = {
    "base": "errors, files, settings, texts",
    "fmi": "one FMU",
    "cosim": "coupled FMUs, step by step",
    "case": "the case file",
    "analysis": "growth rate, verdict",
    "flutter": "one march",
    "linear": "aerodynamics as a linear model",
    "boundary": "the V_f of flutter",
    "results": "what a run leaves",
    "pictures": "what a run draws",
    "report": "a run as one HTML page",
    "sweeps": "many points",
    "ssp": "archives for other tools",
    "hosts": "other people's tools",
    "training": "a network's records",
    "api": "the Python interface",
    "paper": "the paper's figures",
    "commands": "one module a command",
    "cli": "the command line",
}


class Import(NamedTuple):
    """One name that one module takes from another; both as written inside the package: `master.base.errors`."""

    user: str
    used: str
    line: int


def modules() -> dict[str, Path]:
    """Every module of the package by its name without `aeroslosh.`."""
    found = {}
    for path in sorted([*ROOT.glob("master/**/*.py"), *ROOT.glob("fmus/**/*.py")]):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(name: str, path: Path, known: dict[str, Path]) -> list[Import]:
    """Every import of the package by module `name`, those in functions too; not those for type checkers alone."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    found = []
    for node in _run(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif node.level:
            base = [PACKAGE, *package[: len(package) + 1 - node.level], *filter(None, [node.module])]
            names = [".".join([*base, alias.name]) for alias in node.names]
        else:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for full in names:
            inside = full.removeprefix(f"{PACKAGE}.")
            while inside not in known and "." in inside:  # a name in a module
                inside = inside.rpartition(".")[0]
            if inside in known and inside != name:
                found.append(Import(name, inside, node.lineno))
    return found


def _run(tree: ast.AST) -> list[ast.Import | ast.ImportFrom]:
    """The imports of a syntax tree but for those under `if TYPE_CHECKING:`."""
    found: list[ast.Import | ast.ImportFrom] = []
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING"):
            found += [inner for other in node.orelse for inner in _run(ast.Module([other], []))]
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found.append(node)
        else:
            found += _run(node)
    return found


def every_import() -> list[Import]:
    """Of all modules."""
    known = modules()
    return [found for name, path in known.items() for found in imports(name, path, known)]


def room(module: str) -> str:
    """`base` of `master.base.errors`, `fmus` of whatever lies there; "" for the package `master` itself."""
    top, _, rest = module.partition(".")
    return rest.partition(".")[0] if top == "master" else top


def edges(found: list[Import]) -> Counter[tuple[str, str]]:
    """(room, room it imports) → number of pairs of modules; none within a room or within fmus."""
    pairs = {(one.user, one.used) for one in found}
    counted = Counter((room(user), room(used)) for user, used in pairs)
    return Counter({edge: n for edge, n in counted.items() if edge[0] != edge[1] and "" not in edge})


def table(counted: Counter[tuple[str, str]]) -> str:
    """The text of rooms.csv."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["room", "imports", "pairs_of_modules"])
    writer.writerows((user, used, n) for (user, used), n in sorted(counted.items()))
    return out.getvalue()


def main() -> None:
    """Write the table and the picture."""
    counted = edges(every_import())
    DATA.write_text(table(counted), encoding="utf-8")
    draw(counted)
    print(DATA, PICTURE, sep="\n")


def draw(counted: Counter[tuple[str, str]]) -> None:
    """Rooms as boxes on a stair. From a room a line goes along its floor to the column of each room that it imports, and an
    arrow from there to that room; the number of module pairs stands at the corner. Arrows that go up are red."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.patches import FancyBboxPatch

    matplotlib.rcParams.update({"svg.hashsalt": "rooms", "svg.fonttype": "none", "font.family": "sans-serif"})
    ink, grey, pale, down, up = "#1b2733", "#66788a", "#f3f6f9", "#3f8fd2", "#d2583f"
    order = [name for floor in FLOORS for name in floor]
    modules_in = Counter(room(module) for module, path in modules().items() if path.name != "__init__.py")
    step, high = 1.2, 0.62
    figure = pyplot.figure(figsize=(15.0, 9.0))
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_axis_off()
    axis.set_xlim(-0.65 * step, (len(order) + 1.6) * step)
    axis.set_ylim(-0.6, len(order) - 0.4)
    for n, floor in enumerate(FLOORS):
        rows = [order.index(name) for name in floor]
        if n % 2 == 0:
            axis.axhspan(min(rows) - 0.5, max(rows) + 0.5, color=pale, zorder=0)
    for (user, used), n in sorted(counted.items()):
        if user not in order or used not in order:
            continue
        row, column = order.index(user), order.index(used)
        color = down if column < row else up
        x, y = step * column, float(row)
        axis.plot([step * row, x], [y, y], color=color, lw=0.9, zorder=1)
        end = column + (0.5 if column < row else -0.5) * high
        axis.annotate(
            "",
            (x, end),
            (x, y),
            arrowprops={"arrowstyle": "-|>", "color": color, "lw": 0.9, "shrinkA": 0, "shrinkB": 0},
            zorder=1,
        )
        around = {"boxstyle": "circle,pad=0.18", "facecolor": "white", "edgecolor": color, "linewidth": 0.8}
        axis.text(x, y, str(n), ha="center", va="center", fontsize=8, color=ink, bbox=around, zorder=3)
    for row, name in enumerate(order):
        corner = (step * row - 0.46 * step, row - 0.5 * high)
        box = FancyBboxPatch(corner, 0.92 * step, high, boxstyle="round,pad=0,rounding_size=0.08")
        box.set(facecolor="white", edgecolor=ink, linewidth=1.4, zorder=4)
        axis.add_patch(box)
        axis.text(step * row, row + 0.08, name, ha="center", va="center", fontsize=8, weight="bold", color=ink, zorder=5)
        size = f"{modules_in[name]} modules" if name != "cli" else "1 module"
        axis.text(step * row, row - 0.19, size, ha="center", va="center", fontsize=7, color=grey, zorder=5)
        axis.text(step * (row + 0.55), row - 0.2, WHAT[name], ha="left", va="center", fontsize=8.5, color=grey, zorder=5)
    figure.savefig(PICTURE, bbox_inches="tight", metadata={"Date": None})
    pyplot.close(figure)


if __name__ == "__main__":
    main()
