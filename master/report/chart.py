"""Charts as inline SVG, drawn for a screen 360 units wide, so that their words can be read on a phone; colours are the page's own
(page.css), light or dark. What a script may add (reading values, zooming) is in page.js; without it the charts say the same.

Units of an axis stand in its words. The legend stands under the chart, never on the data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from . import ticks
from .markup import Markup, join, tag
from .signals import thinned

WIDTH, RIGHT, TOP, BOTTOM, LETTER = 360.0, 10.0, 20.0, 36.0, 6.1
MOST = 900  # samples of a line


@dataclass(frozen=True)
class Line:
    """A line through (x, y), each (n,); nan leaves a gap. colour: a class of page.css without its "c-"."""

    x: np.ndarray
    y: np.ndarray
    label: str = ""
    colour: str = "blue"
    dashed: bool = False
    quiet: bool = False  # no reading of its values


@dataclass(frozen=True)
class Dots:
    """Marks at (x, y), each (n,), with a text each; `error` (n,) draws bars of that half height."""

    x: np.ndarray
    y: np.ndarray
    label: str = ""
    colour: str = "ink"
    mark: str = "circle"  # circle, diamond, triangle, cross, square
    hollow: bool = False
    error: np.ndarray | None = None
    texts: Sequence[str] = ()


@dataclass(frozen=True)
class Tiles:
    """A rectangle (left, right, bottom, top) each, with its colour and a text."""

    boxes: Sequence[tuple[float, float, float, float]]
    colours: Sequence[str]
    texts: Sequence[str]


@dataclass(frozen=True)
class Frames:
    """Pictures (data URIs) of one place: left, right, bottom, top; the script shows one after the other, with their `texts`."""

    pictures: Sequence[str]
    box: tuple[float, float, float, float]
    texts: Sequence[str]


@dataclass
class Chart:
    """Axes with what is drawn in them. x_label, y_label: words with unit. shaded: spans of x with a name. height: in units of a
    width of 360; equal: one unit of x is as long as one of y, which decides the height."""

    title: str
    x_label: str
    y_label: str
    parts: list[Line | Dots | Tiles | Frames] = field(default_factory=list)
    shaded: Sequence[tuple[float, float, str]] = ()
    lines_x: Sequence[tuple[float, str]] = ()
    zero: bool = False
    x_log: bool = False
    y_log: bool = False
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    height: float = 190.0
    equal: bool = False
    zoom: bool = False
    x_names: Sequence[str] = ()  # words in place of numbers at 0, 1, 2, …

    def html(self) -> Markup:
        """The figure."""
        x0, x1 = self._span([*self._values("x"), *(np.array(s[:2]) for s in self.shaded)], self.x_range, self.x_log, 0.0)
        y0, y1 = self._span(self._values("y"), self.y_range, self.y_log, 0.06)
        marks_y = self._marks(y0, y1, self.y_log, 5)
        left = 10.0 + LETTER * max((len(text) for _, text in marks_y), default=1)
        wide = WIDTH - left - RIGHT
        high = wide * (y1 - y0) / (x1 - x0) if self.equal else self.height - TOP - BOTTOM
        scale = _Scale(x0, x1, y0, y1, left, TOP, wide, high, self.x_log, self.y_log)
        marks_x = self._marks(x0, x1, self.x_log, 5) if not self.x_names else list(enumerate(self.x_names))
        bottom = TOP + high
        grid = [tag("line", x1=left, x2=left + wide, y1=_n(y), y2=_n(y)) for v, _ in marks_y for y in [scale.y(v)]]
        axis_x = [tag("text", text, x=_n(scale.x(v)), y=_n(bottom + 14), text_anchor="middle") for v, text in marks_x]
        axis_y = [tag("text", text, x=_n(left - 5), y=_n(scale.y(v) + 4), text_anchor="end") for v, text in marks_y]
        inner = join([*(self._shade(scale, *s) for s in self.shaded), *(self._drawn(p, scale) for p in self.parts)])
        view = f"{_n(left)} {_n(TOP)} {_n(wide)} {_n(high)}"
        where = {"x": _n(left), "y": _n(TOP), "width": _n(wide), "height": _n(high)}
        svg = tag(
            "svg",
            tag("g", *grid, class_="grid"),
            tag("svg", inner, class_="data", viewBox=view, preserveAspectRatio="none", **where),
            tag("g", *(self._vertical(scale, *line) for line in self.lines_x), class_="verticals"),
            tag("rect", class_="frame", **where),
            tag("g", *(self._marked(p, scale) for p in self.parts if isinstance(p, Dots)), class_="marks"),
            tag("g", *axis_x, class_="ticks-x"),
            tag("g", *axis_y, class_="ticks-y"),
            tag("text", self.y_label, class_="name", x=2, y=12),
            tag("text", self.x_label, class_="name", x=_n(left + wide / 2), y=_n(bottom + 31), text_anchor="middle"),
            viewBox=f"0 0 {_n(WIDTH)} {_n(bottom + BOTTOM)}",
            role="img",
            tabindex="0",
            aria_label=f"{self.title}: {self.y_label} over {self.x_label}",
            data_x0=x0, data_x1=x1, data_y0=y0, data_y1=y1, data_left=_n(left), data_wide=_n(wide), data_top=_n(TOP),
            data_high=_n(high), data_x_log=self.x_log, data_y_log=self.y_log, data_x_name=self.x_label, data_zoom=self.zoom,
        )  # fmt: skip
        named = [p for p in self.parts if isinstance(p, Line | Dots) and p.label]
        legend = tag("ul", *(_key(p) for p in named), class_="legend") if len(named) > 1 or self.shaded else None
        return tag("figure", tag("figcaption", self.title), svg, legend, class_="chart")

    def _values(self, axis: str) -> list[np.ndarray]:
        found = []
        for p in self.parts:
            if isinstance(p, Tiles):
                found.append(np.array([box[:2] if axis == "x" else box[2:] for box in p.boxes]).ravel())
            elif isinstance(p, Frames):
                found.append(np.array(p.box[:2] if axis == "x" else p.box[2:]))
            else:
                values = np.asarray(getattr(p, axis), dtype=float)
                found.append(values)
                if axis == "y" and isinstance(p, Dots) and p.error is not None:
                    found += [values - p.error, values + p.error]
        if axis == "y" and self.zero:
            found.append(np.zeros(1))
        return found

    def _span(self, values: list[np.ndarray], given: tuple[float, float] | None, log: bool, margin: float) -> tuple[float, float]:
        if given is not None:
            return given
        known = np.concatenate(values) if values else np.empty(0)
        if any(isinstance(p, Tiles | Frames) for p in self.parts):
            margin = 0.0
        elif any(isinstance(p, Dots) for p in self.parts):
            margin = max(margin, 0.06)
        if log:
            low, high = ticks.limits(np.log10(known[known > 0.0]), margin)
            return 10.0**low, 10.0**high
        return ticks.limits(known, margin)

    def _marks(self, low: float, high: float, log: bool, most: int) -> list[tuple[float, str]]:
        if log and high > 4.0 * low:
            return [(v, f"{v:g}" if 1e-3 <= v < 1e4 else f"1e{round(math.log10(v))}") for v in ticks.logarithmic(low, high)]
        found = ticks.linear(low, high, most)
        step = found[1] - found[0] if len(found) > 1 else abs(high - low)
        return [(v, ticks.text(v, step)) for v in found]

    def _shade(self, scale: _Scale, begin: float, end: float, name: str) -> Markup:
        a, b = scale.x(begin), scale.x(end)
        return tag(
            "rect", tag("title", name), class_="shade", x=_n(a), width=_n(max(0.0, b - a)), y=_n(TOP), height=_n(scale.high)
        )

    def _vertical(self, scale: _Scale, x: float, name: str) -> Markup:
        at = _n(scale.x(x))
        return tag("line", tag("title", name), x1=at, x2=at, y1=_n(scale.top), y2=_n(scale.top + scale.high))

    def _drawn(self, part: Line | Dots | Tiles | Frames, scale: _Scale) -> Markup | None:
        """What lies in the plane and is stretched with it."""
        if isinstance(part, Line):
            reading = {} if part.quiet else {"data_label": part.label or self.y_label}
            return tag("path", d=_path(part, scale), class_=f"line c-{part.colour}{' dashed' if part.dashed else ''}", **reading)
        if isinstance(part, Tiles):
            return join(
                tag("rect", tag("title", text), x=_n(scale.x(a)), width=_n(scale.x(b) - scale.x(a)), y=_n(scale.y(d)),
                    height=_n(scale.y(c) - scale.y(d)), fill=colour)
                for (a, b, c, d), colour, text in zip(part.boxes, part.colours, part.texts, strict=True)
            )  # fmt: skip
        if isinstance(part, Frames):
            a, b, c, d = part.box
            place = {"x": _n(scale.x(a)), "y": _n(scale.y(d)), "width": _n(scale.x(b) - scale.x(a))}
            place |= {"height": _n(scale.y(c) - scale.y(d)), "preserveAspectRatio": "none"}
            shown = zip(part.pictures, part.texts, strict=True)
            return join(
                tag("image", href=p, data_text=text, class_="film-frame" + (" shown" if n == 0 else ""), **place)
                for n, (p, text) in enumerate(shown)
            )
        return None

    def _marked(self, part: Dots, scale: _Scale) -> Markup:
        """Marks, which keep their shape, and their bars."""
        found: list[Markup] = []
        for n, (x, y) in enumerate(zip(np.asarray(part.x, dtype=float), np.asarray(part.y, dtype=float), strict=True)):
            if not (np.isfinite(x) and np.isfinite(y)) or (self.y_log and y <= 0.0) or (self.x_log and x <= 0.0):
                continue
            px, py = scale.x(float(x)), scale.y(float(y))
            if not (scale.top - 1 <= py <= scale.top + scale.high + 1):
                continue
            if part.error is not None and np.isfinite(part.error[n]) and part.error[n] > 0.0:
                up, down = (scale.y(float(y + sign * part.error[n])) for sign in (1.0, -1.0))
                bar = f"M{_n(px)} {_n(up)}V{_n(down)}M{_n(px - 3)} {_n(up)}h6M{_n(px - 3)} {_n(down)}h6"
                found.append(tag("path", d=bar, class_="bar"))
            title = tag("title", part.texts[n]) if len(part.texts) else None
            words = {"data_text": part.texts[n]} if len(part.texts) else {}
            found.append(_mark(part.mark, px, py, part.hollow, title, **words))
        return tag("g", *found, class_=f"c-{part.colour}")


@dataclass(frozen=True)
class _Scale:
    x0: float
    x1: float
    y0: float
    y1: float
    left: float
    top: float
    wide: float
    high: float
    x_log: bool
    y_log: bool

    def x(self, value: float) -> float:
        return self.left + self.wide * _share(value, self.x0, self.x1, self.x_log)

    def y(self, value: float) -> float:
        return self.top + self.high * (1.0 - _share(value, self.y0, self.y1, self.y_log))


def _share(value: float, low: float, high: float, log: bool) -> float:
    if log:
        return (math.log10(max(value, 1e-300)) - math.log10(low)) / (math.log10(high) - math.log10(low))
    return (value - low) / (high - low)


def _n(value: float) -> str:
    """A coordinate, a tenth of a unit being enough."""
    return f"{value:.1f}".removesuffix(".0")


def _path(line: Line, scale: _Scale) -> str:
    x, y = np.asarray(line.x, dtype=float), np.asarray(line.y, dtype=float)
    if scale.y_log:
        y = np.where(y > 0.0, y, np.nan)
    rising = x.size < 2 or bool(np.all(np.diff(x) > 0.0))
    if rising:
        x, y = thinned(x, y, MOST)
    elif x.size > 2 * MOST:  # a phase curve
        every = -(-x.size // (2 * MOST))
        x, y = x[::every], y[::every]
    text, begun = "", False
    low, high = scale.top - scale.high, scale.top + 2.0 * scale.high  # what is far outside is not seen
    for a, b in zip(x, y, strict=True):
        if not (np.isfinite(a) and np.isfinite(b)):
            begun = False
            continue
        text += f"{'L' if begun else 'M'}{_n(scale.x(float(a)))} {scale_n(min(max(scale.y(float(b)), low), high))}"
        begun = True
    return text


def scale_n(value: float) -> str:
    """An ordinate, to a hundredth: zoomed in, its steps must not show."""
    return f"{value:.2f}"


MARKS = {
    "diamond": "M{x} {u}L{r} {y}L{x} {d}L{l} {y}Z",
    "triangle": "M{x} {u}L{r} {d}L{l} {d}Z",
    "square": "M{l} {u}H{r}V{d}H{l}Z",
    "cross": "M{l} {u}L{r} {d}M{l} {d}L{r} {u}",
}


def _mark(kind: str, x: float, y: float, hollow: bool, title: Markup | None = None, **words: str) -> Markup:
    look = "mark" + (" hollow" if hollow or kind == "cross" else "")
    if kind == "circle":
        return tag("circle", title, cx=_n(x), cy=_n(y), r=3, class_=look, **words)
    r = 3.8
    shape = MARKS[kind].format(x=_n(x), y=_n(y), l=_n(x - r), r=_n(x + r), u=_n(y - r), d=_n(y + r))
    return tag("path", title, d=shape, class_=look, **words)


def _key(part: Line | Dots) -> Markup:
    """An entry of the legend."""
    if isinstance(part, Line):
        sign = tag("path", d="M1 6H21", class_="line" + (" dashed" if part.dashed else ""))
    else:
        sign = _mark(part.mark, 11, 6, part.hollow)
    return tag("li", tag("svg", sign, viewBox="0 0 22 12", class_=f"c-{part.colour}", aria_hidden="true"), part.label)
