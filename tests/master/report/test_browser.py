"""The page in a real browser: no complaint in its console, nothing cut off on a phone, keyboard, contrast, print."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aeroslosh.master.flutter.march import March
from aeroslosh.master.report import page
from support import browser
from support.browser import Page
from support.fields import flow

pytestmark = pytest.mark.skipif(
    browser.find() is None, reason="no browser: install Chromium (apt install chromium) or name one with AEROSLOSH_BROWSER"
)

CUT_OFF = """(() => {
  const wide = document.documentElement.clientWidth, found = [];
  for (const e of document.querySelectorAll('body *')) {
    const box = e.getBoundingClientRect();
    if (!box.width || e.closest('.wide') || e.closest('svg.data')) continue;
    const name = `${e.tagName}.${e.getAttribute('class')}: ${box.left} to ${box.right}`;
    if (box.left < -0.5 || box.right > wide + 0.5) found.push(name);
  }
  for (const t of document.querySelectorAll('figure > svg')) {
    const own = t.getBoundingClientRect();
    for (const text of t.querySelectorAll('text')) {
      const box = text.getBoundingClientRect();
      if (box.width && (box.left < own.left - 1 || box.right > own.right + 1)) found.push(`text ${text.textContent}`);
    }
  }
  for (const e of document.querySelectorAll('.wide'))
    if (e.scrollWidth > e.clientWidth + 1) found.push(`table ${e.innerText.slice(0, 40)}`);
  return found.slice(0, 10);
})()"""

CONTRAST = """(() => {
  const parse = (c) => { const m = c.match(/[\\d.]+/g).map(Number); return m.length > 3 && m[3] === 0 ? null : m; };
  const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  const light = (c) => [0, 1, 2].map((i) => linear(c[i] / 255))
    .reduce((s, v, i) => s + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ratio = (a, b) => { const [x, y] = [light(a), light(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
  const behind = (e) => {
    for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if (c) return c; }
    return [255, 255, 255];
  };
  const worst = { text: 99, line: 99, where: '' };
  for (const e of document.querySelectorAll('body *')) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    const style = getComputedStyle(e);
    if (own && e.getClientRects().length && !['SCRIPT', 'STYLE', 'title'].includes(e.tagName)) {
      const c = parse(e instanceof SVGElement ? style.fill : style.color);
      const found = ratio(c, behind(e instanceof SVGElement ? e.ownerSVGElement.parentElement : e));
      if (found < worst.text) { worst.text = found; worst.where = e.outerHTML.slice(0, 80); }
    }
    if (e.matches('path.line, .mark')) worst.line = Math.min(worst.line, ratio(parse(style.stroke), behind(e.closest('figure'))));
  }
  return worst;
})()"""


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A browser for all tests here."""
    with browser.page(tmp_path_factory.mktemp("browser")) as found:
        yield found


@pytest.fixture
def pages(
    point_run: Callable[..., Path],
    boundary_run: Callable[..., Path],
    sweep_run: Callable[..., Path],
    amplitude_run: Callable[..., Path],
    made_up: Callable[..., March],
) -> dict[str, Path]:
    """A page of each kind, the point's with a film."""
    folder = point_run("p", made_up(growth=0.01), ["flow.mach=0.3", "aero.cells_around=96"])
    for n in range(3):
        flow(folder / "fields", n + 1, 0.1 * n, sonic=0.7 + 0.1 * n)
    marches = [made_up(V_f=v, growth=g) for v, g in ((0.5, -0.01), (0.6, 0.0002), (0.7, 0.01))]
    crossings = {0.3: [(0.6, 0.01, "onset")]}
    swept = {v: made_up(V_f=v, growth=0.1 * (v - 0.6)) for v in (0.5, 0.55, 0.65)} | {0.7: None}
    found = {"point": folder, "boundary": boundary_run("b", crossings, marches), "sweep": sweep_run("s", swept)}
    found["amplitude"] = amplitude_run("a", {0.5: lambda a: -0.01 - 0.001 * a, 0.7: lambda a: 0.01 - 0.01 * math.log(a)})
    return {kind: page.write(path) for kind, path in found.items()}


@pytest.mark.parametrize("kind", ["point", "boundary", "sweep", "amplitude"])
@pytest.mark.parametrize(("width", "dark"), [(360, False), (360, True), (1280, False), (1280, True)])
def test_nothing_is_cut_off_everything_can_be_read_and_nobody_complains(
    tab: Page, pages: dict[str, Path], kind: str, width: int, dark: bool
) -> None:
    tab.complaints.clear()
    tab.open(pages[kind], width, dark=dark)
    assert tab.run("document.documentElement.dataset.ready") == "yes"
    assert tab.run("document.documentElement.scrollWidth") == width
    assert tab.run(CUT_OFF) == []
    worst = tab.run(CONTRAST)
    assert worst["text"] >= 4.5 and worst["line"] >= 3.0, worst  # WCAG 2.2, 1.4.3 and 1.4.11
    heights = "[...document.querySelectorAll('figure svg text')].map(t => t.getBoundingClientRect().height).filter(h => h > 0)"
    assert tab.run(f"Math.min(...{heights})") > 9.0
    assert tab.complaints == []


def test_pointer_and_keys_read_the_same_values(tab: Page, pages: dict[str, Path]) -> None:
    tab.open(pages["point"], 1280)
    box: dict[str, Any] = tab.run(
        "(() => { const s = document.querySelector('figure.chart > svg'); s.scrollIntoView();"
        "const b = s.getBoundingClientRect(); return { x: b.x, y: b.y, w: b.width, h: b.height } })()"
    )
    tab.move(box["x"] + 0.55 * box["w"], box["y"] + 0.5 * box["h"])
    said = tab.run("document.querySelector('.readout').textContent")
    assert said.startswith("cycles") and "computed:" in said and "envelope of the flutter mode:" in said
    tab.run("document.querySelector('figure.chart > svg').focus()")
    for _ in range(3):
        tab.press("ArrowRight")
    moved = tab.run("document.querySelector('.readout').textContent")
    assert moved != said and "computed:" in moved
    # charts of one group read at one place
    first, second = (
        r.split(" → ")[0]
        for r in tab.run("[...document.querySelectorAll('.linked .readout')].slice(0, 2).map(r => r.textContent)")
    )
    assert first == second


def test_values_read_are_those_of_the_history(tab: Page, pages: dict[str, Path], made_up: Callable[..., March]) -> None:
    tab.open(pages["point"], 1280)
    tab.run("[...document.querySelectorAll('figure.chart > svg')][1].focus()")
    tab.press("ArrowRight")
    said = tab.run("[...document.querySelectorAll('.readout')][1].textContent").replace("\N{MINUS SIGN}", "-")
    cycle = float(said.split(" → ")[0].split()[-1])
    value = float(said.split("computed: ")[1].split(";")[0])
    tau = 2.0 * np.pi * cycle
    expected = np.exp(0.01 * tau) * np.cos(0.9 * tau)
    assert value == pytest.approx(expected, abs=0.03)  # a chart a few hundred units wide


def test_everything_that_acts_can_be_reached_and_used_by_keys(tab: Page, pages: dict[str, Path]) -> None:
    tab.open(pages["boundary"], 1280)
    seen = set()
    for _ in range(200):
        tab.press("Tab")
        name = tab.run("(e => e.tagName + '/' + (e.getAttribute('aria-label') || e.textContent))(document.activeElement)")
        if name.startswith("BODY"):
            break
        seen.add(name)
        assert tab.run("getComputedStyle(document.activeElement).outlineStyle") != "none"
    shown = "[...document.querySelectorAll('button, input, figure.chart > svg')].filter(e => e.getClientRects().length)"
    wanted = set(tab.run(f"{shown}.map(e => e.tagName + '/' + (e.getAttribute('aria-label') || e.textContent))"))
    assert wanted and wanted <= seen


def test_the_slider_over_V_f_moves_curves_and_picks_the_march(tab: Page, pages: dict[str, Path]) -> None:
    tab.open(pages["boundary"], 1280)
    tab.run("document.querySelector('.along-here input').focus()")
    tab.press("Home")
    said = "['.along-here output', '.picker[data-name^=March] output'].map(s => document.querySelector(s).textContent)"
    first = tab.run(said)
    tab.press("End")
    last = tab.run(said)
    assert float(first[0].split()[-1]) < float(last[0].split()[-1])
    assert first[1].startswith("0.5000") and last[1].startswith("0.7000")
    assert tab.run("document.querySelectorAll('.picker[data-name^=March] > .choice:not(.away)').length") == 1


def test_zoom_shows_less_and_all_again(tab: Page, pages: dict[str, Path]) -> None:
    tab.open(pages["point"], 360)
    view = "document.querySelector('[data-zoom] svg.data').getAttribute('viewBox').split(' ').map(Number)"
    whole = tab.run(view)
    tab.run("document.querySelector('figure.chart .controls button').click()")
    near = tab.run(view)
    assert near[2] == pytest.approx(0.5 * whole[2], rel=1e-3) and near[3] == whole[3]
    tab.run("[...document.querySelectorAll('figure.chart .controls button')].find(b => b.textContent === 'All').click()")
    assert tab.run(view)[2] == pytest.approx(whole[2], rel=1e-3)


def test_a_film_plays_and_stops(tab: Page, pages: dict[str, Path]) -> None:
    tab.open(pages["point"], 360)
    shown = "[...document.querySelectorAll('.film-frame')].findIndex(f => f.classList.contains('shown'))"
    assert tab.run("document.querySelectorAll('.film-frame').length") == 3 and tab.run(shown) == 0
    tab.run("[...document.querySelectorAll('button')].find(b => b.textContent === 'Play').click()")
    tab.run(f"new Promise(done => {{ const wait = () => {shown} > 0 ? done() : setTimeout(wait, 20); wait(); }})")
    tab.run("[...document.querySelectorAll('button')].find(b => b.textContent === 'Stop').click()")
    assert tab.run("getComputedStyle(document.querySelector('.film-frame.shown')).visibility") == "visible"
    assert tab.run("document.querySelectorAll('.film-frame.shown').length") == 1


def test_paper_is_light_and_has_no_buttons(tab: Page, pages: dict[str, Path]) -> None:
    tab.open(pages["point"], 794, dark=True, media="print")
    assert tab.run("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert tab.run("[...document.querySelectorAll('button, input')].filter(e => e.getClientRects().length).length") == 0
    assert tab.run("document.documentElement.scrollWidth") <= 794
    assert tab.pdf().startswith(b"%PDF")


def test_without_script_everything_is_there(tab: Page, pages: dict[str, Path]) -> None:
    tab.call("Emulation.setScriptExecutionDisabled", value=True)
    try:
        tab.open(pages["boundary"], 360)
        assert tab.run("document.documentElement.dataset.ready") is None
        assert tab.run("[...document.querySelectorAll('.choice')].map(c => c.getClientRects().length)") == [1, 1, 1, 1]
        assert tab.run("document.querySelectorAll('path.line').length") > 6
        assert tab.run(CUT_OFF) == []
    finally:
        tab.call("Emulation.setScriptExecutionDisabled", value=False)
