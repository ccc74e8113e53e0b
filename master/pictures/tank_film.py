"""Pictures and a short animation of the liquid in a tank: `aeroslosh animate FOLDER`.

Reads the fields_<number>.vts files that a slosh FMU wrote; draws each with the tank where it was, in inertial axes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from ..base import files as base_files
from ..base import vtk
from ..base.errors import AeroSloshError
from . import canvas

LIQUID = LinearSegmentedColormap.from_list("liquid", ["#ffffff", "#9cc4e4", "#1f6fb2"])
EDGE, SURFACE = "#333333", "#0b3c66"
NAME = re.compile(r"fields_(\d+)\.vts")
RATES = (1, 50)  # pictures a second: players slow down what is faster than 50
FOLLOW = 3.0
"""A tank that travels more of its own size than this is followed; else the window stands still."""


def find(folder: Path) -> list[Path]:
    """The field files of a folder in the order of their numbers. Raises AeroSloshError where there are none."""
    if not folder.is_dir():
        raise AeroSloshError("There is no such folder", str(folder), "give the folder with the files fields_<number>.vts")
    found = [(int(match[1]), path) for path in folder.iterdir() if (match := NAME.fullmatch(path.name))]
    if not found:
        raise AeroSloshError(
            "The folder holds no files fields_<number>.vts",
            str(folder),
            "let a slosh FMU write them: `aeroslosh drive dist/fmus/slosh_vof.fmu --fields 10 …`",
        )
    return [path for _, path in sorted(found)]


def read(path: Path) -> vtk.Field:
    """A field with liquid. Raises AeroSloshError for another one (of the flow around a wing, of another program)."""
    field = vtk.read(path)
    if field.cells.get("volume_fraction", np.empty(0)).ndim != 2:
        raise AeroSloshError("The file has no volume_fraction", str(path), "give the folder of a slosh FMU's fields")
    return field


def animate(files: Sequence[Path], out: Path, fps: int = 20, pictures: Path | None = None) -> list[Path]:
    """Draw the files into the GIF `out` at fps pictures a second, and each as a PNG in the folder `pictures` if given.

    Returns the paths of what was written; each appears whole or not at all. Raises AeroSloshError.
    """
    if not RATES[0] <= fps <= RATES[1]:
        raise AeroSloshError(f"--fps {fps}", "command line", f"{RATES[0]} to {RATES[1]} pictures a second")
    if out.suffix.lower() != ".gif":
        raise AeroSloshError(f"--out {out}", "command line", "a name that ends in .gif")
    views = windows(np.array([box(read(path)) for path in files]))
    wide, high = np.diff(views[0])[[0, 2]]
    figure, axes = canvas.subplots(figsize=(7.2, min(max(7.2 * high / wide, 1.5), 7.2) + 0.7), layout="constrained")
    writer = PillowWriter(fps=fps)
    for folder in (out.parent, pictures):
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
    written = [out]
    with base_files.part(out, ".gif") as hidden:  # its ending tells the writer what to write
        writer.setup(figure, str(hidden), dpi=90)
        for path, window in zip(files, views, strict=True):
            axes.clear()
            draw(axes, read(path), window, path.stem)
            writer.grab_frame()
            # the first picture's margins for all of them
            figure.set_layout_engine("none")
            if pictures is not None:
                written.append(_picture(figure, pictures / f"{path.stem}.png"))
        writer.finish()
    return written


def draw(axes: Axes, field: vtk.Field, window: np.ndarray, name: str) -> None:
    """One tank with its liquid. window (4,): limits of x and y [m]; name: for the title, where the file tells no time."""
    share = np.clip(field.cells["volume_fraction"], 0.0, 1.0)
    # up to the walls: values of the cells there, at the walls' points
    nodes, share = (_middle(field.x), _middle(field.y)), np.pad(share, 1, mode="edge")
    axes.pcolormesh(*nodes, share, cmap=LIQUID, vmin=0.0, vmax=1.0, shading="gouraud", rasterized=True)
    if share.min() < 0.5 < share.max():
        axes.contour(*nodes, share, levels=[0.5], colors=SURFACE, linewidths=1.2)
    x, y = _outline(field.x), _outline(field.y)
    axes.plot(x, y, color=EDGE, lw=2.0, solid_joinstyle="miter")
    for foot, tip in field.whole.get("baffles", np.empty((0, 3))).reshape(-1, 2, 3):
        axes.plot([foot[0], tip[0]], [foot[1], tip[1]], color=EDGE, lw=2.0)
    time = field.whole.get("TimeValue", np.empty(0))
    axes.set_title(f"t = {time[0]:.4f} s" if time.size else name.replace("_", " "), fontsize=10)
    axes.set(xlim=window[:2], ylim=window[2:], xlabel="aft $X$ [m]", ylabel="up $Y$ [m]", aspect="equal")


def _picture(figure: Figure, path: Path) -> Path:
    with base_files.part(path) as hidden:
        figure.savefig(hidden, dpi=150, format="png")
    return path


def _outline(nodes: np.ndarray) -> np.ndarray:
    """Nodes once around the tank."""
    return np.concatenate([nodes[0], nodes[1:, -1], nodes[-1, -2::-1], nodes[-2::-1, 0]])


def _middle(nodes: np.ndarray) -> np.ndarray:
    """Middles of the cells, with the walls on either side: (nj + 1, ni + 1) → (nj + 2, ni + 2)."""
    for _ in range(2):
        nodes = np.concatenate([nodes[:1], 0.5 * (nodes[1:] + nodes[:-1]), nodes[-1:]]).T
    return nodes


def box(field: vtk.Field) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of the tank [m]."""
    return float(field.x.min()), float(field.x.max()), float(field.y.min()), float(field.y.max())


def windows(boxes: np.ndarray) -> np.ndarray:
    """Limits of x and y of each picture, all of one size, from the boxes around the tank, shapes (n, 4)."""
    sizes = np.stack([boxes[:, 1] - boxes[:, 0], boxes[:, 3] - boxes[:, 2]], axis=1).max(axis=0)
    whole = np.array([boxes[:, 0].min(), boxes[:, 1].max(), boxes[:, 2].min(), boxes[:, 3].max()])
    if whole[1] - whole[0] > FOLLOW * sizes[0] or whole[3] - whole[2] > FOLLOW * sizes.max():
        centre = np.stack([boxes[:, :2].mean(axis=1), boxes[:, 2:].mean(axis=1)], axis=1)
        low, high = centre - 0.5 * sizes, centre + 0.5 * sizes
        found = np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=1)
    else:
        found = np.tile(whole, (len(boxes), 1))
    margin = 0.06 * sizes.max()
    return found + margin * np.array([-1.0, 1.0, -1.0, 1.0])
