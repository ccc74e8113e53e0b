"""The page of a run as a document: whole, closed in itself, with what the run found; no browser is needed for that."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.flutter.march import March
from aeroslosh.master.report import markup, page, signals, ticks
from aeroslosh.master.report.chart import Chart, Dots, Line
from support.processes import called

VOID = {"meta", "link", "input", "br", "img", "hr", "col"}


class Document(HTMLParser):
    """Elements in order; complains of what is not nested. `text`: all words outside style and script."""

    def __init__(self, content: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(content)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, (tag, self.open)
        self.open.pop()

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("style", "script"):
            self.text += f" {data}"

    def of(self, tag: str, **attributes: str) -> list[dict[str, str | None]]:
        return [a for t, a in self.elements if t == tag and all(a.get(k.rstrip("_")) == v for k, v in attributes.items())]

    @property
    def headings(self) -> list[str]:
        return re.findall(r"<h2>(.*?)</h2>", self.rawdata_kept)

    rawdata_kept = ""


def document(path: Path) -> Document:
    content = path.read_text(encoding="utf-8")
    found = Document(content)
    found.rawdata_kept = content
    return found


def closed_in_itself(d: Document) -> None:
    """Nothing is fetched: every address is data, or a place in the page."""
    for _, attributes in d.elements:
        for name in ("src", "href", "action", "srcset", "data"):
            assert (attributes.get(name) or "data:").startswith(("data:", "#"))
    assert not re.search(r"@import|url\((?!data:)|https?://(?!www\.w3\.org/2000/svg)", d.rawdata_kept)


def test_a_point_has_all_its_parts_and_needs_no_network(point_run: Callable[..., Path], made_up: Callable[..., March]) -> None:
    folder = point_run("p", made_up(growth=-0.01), ["flow.mach=0.3", "aero.cells_around=96"])
    written = page.write(folder)
    d = document(written)
    assert written == folder / "report.html"
    closed_in_itself(d)
    assert d.elements[0] == ("html", {"lang": "en"}) and d.of("meta", name="viewport")
    assert d.headings == [
        "Verdict", "Motion", "Phase", "Modes of the motion", "Coupling health", "Cost", "Settings that differ from the defaults",
        "Provenance",
    ]  # fmt: skip
    result = json.loads((folder / "result.json").read_text())
    assert result["verdict"] in d.text and result["reason"] in d.text
    assert f"{result['growth_rate']:.5f}" in d.text and "Mach 0.3" in d.text
    assert "aero.cells_around" in d.text and "cells around the airfoil" in d.text and "aero.cells_normal" not in d.text
    assert "b" * 64 in d.text
    for svg in d.of("svg", role="img"):
        assert " over " in (svg["aria-label"] or "") and svg["tabindex"] == "0"


def test_envelope_of_a_page_is_the_motion_that_was_made(made_up: Callable[..., March]) -> None:
    march = made_up(growth=0.02, frequency=0.9)
    poles = {"growth_rate": 0.02, "frequency": 0.9, "modes": [{"growth_rate": 0.02, "frequency": 0.9}]}
    found = signals.envelope(march.tau, march.history["alpha"], poles)
    assert found is not None
    expected = np.radians(1.0) * np.exp(0.02 * march.tau)
    np.testing.assert_allclose(found[1], expected, rtol=1e-6)
    np.testing.assert_allclose(found[0], -expected, rtol=1e-6)
    assert signals.envelope(march.tau[:4], march.history["alpha"][:4], poles) is None  # too short for its poles
    assert signals.envelope(march.tau, march.history["alpha"], {"growth_rate": 0.1, "frequency": 0.0}) is None  # divergence


def test_thinning_keeps_ends_and_peaks() -> None:
    x = np.arange(5000.0)
    y = np.sin(x / 90.0)
    y[1234] = 7.0
    a, b = signals.thinned(x, y, 300)
    assert a.size <= 300 and a[0] == 0.0 and a[-1] == 4999.0 and b.max() == 7.0 and b.min() == y.min() and np.all(np.diff(a) > 0)


def test_a_boundary_tells_every_crossing_and_every_march(
    boundary_run: Callable[..., Path], made_up: Callable[..., March]
) -> None:
    marches = [made_up(V_f=0.5, growth=-0.01), made_up(V_f=0.7, growth=0.01)]
    folder = boundary_run("b", {0.3: [(0.6, 0.01, "onset"), (0.9, 0.02, "recovery")]}, marches)
    d = document(page.write(folder))
    closed_in_itself(d)
    assert "0.6000 ± 0.0100" in d.text and "0.9000 ± 0.0200" in d.text and "recovery" in d.text
    choices = d.of("div", class_="choice")
    assert [c["data-number"] for c in choices] == ["0.3", "0.5", "0.7"]
    assert len(d.of("div", **{"data-along": "flutter speed index V_f [–]"})) == 1


def test_limit_cycles_are_told_with_every_amplitude_and_where_the_numbers_come_from(amplitude_run: Callable[..., Path]) -> None:
    folder = amplitude_run("a", {0.5: lambda a: -0.01 - 0.001 * a, 0.7: lambda a: 0.01 - 0.01 * math.log(a)})
    d = document(page.write(folder))
    closed_in_itself(d)
    assert d.headings == [
        "Limit cycles", "Over V_f and over amplitude", "Amplitudes and growth rates", "Cost",
        "Settings that differ from the defaults", "Provenance",
    ]  # fmt: skip
    found = json.loads((folder / "result.json").read_text())["speeds"]
    assert [len(row["cycles"]) for row in found] == [0, 1]
    cycle = found[1]["cycles"][0]
    assert cycle["stable"] and cycle["amplitude_deg"] == pytest.approx(math.e, rel=0.02)  # its rate passes zero there
    assert f"{cycle['amplitude_deg']:.3f} ±" in d.text and "both" in d.text
    assert "V_f 0.5: no limit cycle, motions of 0.1 to 9 deg decay" in d.text
    assert [c["data-number"] for c in d.of("div", class_="choice")] == ["0.5", "0.7"]
    titles = re.findall(r"<title>(V_f [^<]*)</title>", d.rawdata_kept)
    assert any(t.startswith("V_f 0.7: stable") for t in titles)
    assert {f"V_f {v:g}, {a:.3g} deg: growth rate {r:+.4g}" for v in (0.5, 0.7) for a in (0.1, 0.3, 1.0, 3.0, 9.0)
            for r in [-0.01 - 0.001 * a if v == 0.5 else 0.01 - 0.01 * math.log(a)]} <= set(titles)  # fmt: skip
    assert "b" * 64 in d.text


def test_an_amplitude_without_any_envelope_is_said(amplitude_run: Callable[..., Path]) -> None:
    d = document(page.write(amplitude_run("a", {0.5: lambda a: -0.01}, sizes=())))
    assert "no march was long enough to read an envelope" in d.text and not d.of("svg", role="img")


def test_a_sweep_tells_every_point_and_every_failure(sweep_run: Callable[..., Path], made_up: Callable[..., March]) -> None:
    marches = {0.5: made_up(V_f=0.5, growth=-0.02), 0.6: made_up(V_f=0.6, growth=0.01), 0.7: None}
    d = document(page.write(sweep_run("s", marches)))
    closed_in_itself(d)
    assert "3 points" in d.text and "made to fail" in d.text and "-0.0200" in d.text
    assert {"damped", "flutter"} <= set(d.text.split()) and len(d.of("div", class_="choice")) == 2
    assert "flutter speed index V_f [–]" in d.text


def test_a_system_shows_what_moves_and_names_what_does_not(springs: Path, tmp_path: Path) -> None:
    case = tmp_path / "pair.toml"
    parts = ""
    for name, x in (("a", 1.0), ("b", 0.0)):
        parts += f'[components.{name}]\nfmu = "spring.fmu"\n[components.{name}.parameters]\ninitial_x = {x}\n'
    case.write_text(parts + "[run]\nend = 1.0\nstep = 0.01\n")
    ran = called("run", case, "--fmus", springs, "--no-pictures", "--quiet", "--out", tmp_path / "r")
    assert ran.returncode == 0, ran.stderr
    d = document(page.write(tmp_path / "r"))
    closed_in_itself(d)
    assert "Outputs over time" in d.headings and "Coupling health" in d.headings
    assert "components.a.initial_x" in d.text


def test_what_is_no_run_is_refused_with_a_remedy(
    tmp_path: Path, point_run: Callable[..., Path], made_up: Callable[..., March]
) -> None:
    (tmp_path / "case.toml").write_text("")
    with pytest.raises(AeroSloshError, match="no run yet"):
        page.write(tmp_path / "case.toml")
    folder = point_run("p", made_up())
    with pytest.raises(AeroSloshError, match="lone history"):
        page.write(folder / "history.nc")
    with pytest.raises(AeroSloshError, match="--out"):
        page.write(folder, tmp_path / "page.pdf")
    done = called("report", tmp_path / "nowhere")
    assert done.returncode == 2 and "remedy" in done.stderr
    done = called("report", folder, "--json", "--out", tmp_path / "new" / "page.html")
    told = json.loads(done.stdout)
    assert done.returncode == 0 and Path(told["file"]).stat().st_size == told["bytes"]


def test_names_from_files_cannot_break_the_page() -> None:
    drawn = Chart("<script>", "x [m]", "a & b", [Line(np.arange(3.0), np.arange(3.0), '"><b>')]).html()
    assert "<script>" not in drawn and "<b>" not in drawn and "a &amp; b" in drawn
    assert markup.tag("p", "1 < 2", title='"') == '<p title="&quot;">1 &lt; 2</p>'
    Document(drawn)


def test_marks_of_axes_are_round_and_inside() -> None:
    for low, high in ((0.0, 1.0), (-3.7e-6, 2.1e-6), (0.31, 0.33), (-12.0, 950.0)):
        marks = ticks.linear(low, high)
        assert 2 <= len(marks) <= 6 and marks[0] >= low - 1e-12 and marks[-1] <= high * (1 + 1e-12)
    assert ticks.logarithmic(0.2, 3.0) == pytest.approx([0.2, 0.5, 1.0, 2.0])
    assert ticks.text(-0.02, 0.01) == "\N{MINUS SIGN}0.02" and ticks.text(0.0, 0.1) == "0" and ticks.text(1200.0, 100.0) == "1200"


def test_marks_stand_where_their_values_are() -> None:
    drawn = Chart(
        "t", "x [m]", "y [m]", [Dots(np.array([0.0, 10.0]), np.array([0.0, 5.0]))], x_range=(0.0, 10.0), y_range=(0.0, 5.0)
    )
    svg = Document(drawn.html()).of("svg", role="img")[0]
    circles = Document(drawn.html()).of("circle")
    left, wide, top, high = (float(svg[f"data-{n}"] or "nan") for n in ("left", "wide", "top", "high"))
    assert float(circles[0]["cx"] or "nan") == pytest.approx(left, abs=0.1)
    assert float(circles[0]["cy"] or "nan") == pytest.approx(top + high, abs=0.1)
    assert float(circles[1]["cx"] or "nan") == pytest.approx(left + wide, abs=0.1)
    assert float(circles[1]["cy"] or "nan") == pytest.approx(top, abs=0.1)
