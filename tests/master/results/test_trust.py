"""A slosh model outside its limits: no verdict, in results, summaries, tables, pictures and exit codes."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure

from aeroslosh.master.analysis.crossings import Crossing
from aeroslosh.master.analysis.verdict import Verdict
from aeroslosh.master.boundary.search import BoundaryPoint
from aeroslosh.master.flutter.march import March
from aeroslosh.master.pictures import boundary
from aeroslosh.master.pictures import march as pictures_march
from aeroslosh.master.pictures import sweep as pictures_sweep
from aeroslosh.master.results import history_writer, summary, trust
from aeroslosh.master.sweeps import results
from aeroslosh.master.sweeps.ledger import Row

Marcher = Callable[..., March]


def told(march: March, values: list[float]) -> March:
    """The march with a validity that goes through `values`."""
    n = march.tau.size
    march.slosh = "ems"
    march.history["slosh_validity"] = np.interp(np.linspace(0, 1, n), np.linspace(0, 1, len(values)), values)
    return march


def test_the_worst_of_the_march_counts_not_its_last_sample(made_up: Marcher) -> None:
    assert trust.validity(told(made_up(), [0.0, 3.0, 0.5])) == pytest.approx(3.0, rel=0.02)
    broken = told(made_up(), [0.1, 0.2])
    broken.history["slosh_validity"][-3:] = np.nan  # the FMU failed
    assert trust.validity(broken) == pytest.approx(0.2, rel=0.02)
    assert trust.validity(made_up()) is None and trust.verdict(made_up()) is Verdict.DAMPED


def test_a_march_outside_the_model_has_no_verdict(made_up: Marcher) -> None:
    data = summary.march_data(told(made_up(), [0.0, 34.0]))
    assert (data["verdict"], data["motion_verdict"], data["slosh_holds"]) == ("undetermined", "damped", False)
    assert data["slosh_validity"] == 34.0 and "does not hold (validity 34, edge 1)" in data["reason"]
    assert "37 times smaller" in data["remedy"] and data["growth_rate"] is not None
    said = summary.march_summary(data)
    assert "UNDETERMINED" in said and "remedy" in said and "as computed: damped" in said
    assert history_writer.march_attributes(told(made_up(), [0.0, 34.0]))["verdict"] == "undetermined"
    assert "does not hold" in pictures_march.headline(told(made_up(), [0.0, 34.0]))


def test_a_liquid_too_viscous_at_rest_is_not_helped_by_smaller_motions(made_up: Marcher) -> None:
    data = summary.march_data(told(made_up(), [2.0, 2.0]))
    assert 'slosh.model = "vof"' in data["remedy"] and "smaller" not in data["remedy"].replace("small enough", "")


def test_a_march_inside_keeps_its_verdict(made_up: Marcher) -> None:
    data = summary.march_data(told(made_up(), [0.0, 1.0]))
    assert (data["verdict"], data["slosh_holds"], data["remedy"]) == ("damped", True, None)
    assert "UNDETERMINED" not in summary.march_summary(data)
    assert summary.march_data(made_up())["slosh_holds"] is None


def point(marches: list[March], *crossings: Crossing) -> BoundaryPoint:
    return BoundaryPoint(0.8, list(crossings), [], "onset at V_f = 0.7", bool(crossings), marches)


ONSET = Crossing(0.7, 0.8, "onset", 0.1, True, {"fit": 1e-4}, True)


def test_a_crossing_rests_on_the_marches_beside_it(made_up: Marcher) -> None:
    """A march far from it, grown out of the model, does not spoil it."""
    near = [told(made_up(V_f=0.69), [0.0, 0.5]), told(made_up(V_f=0.71), [0.0, 0.8])]
    far = told(made_up(V_f=0.9, growth=0.05), [0.0, 50.0])
    sound = point([far, *near], ONSET)
    data = summary.point_data(sound)
    assert trust.decided(sound) and data["slosh_holds"] and data["verdict"] == "neutral"
    assert data["slosh_validity"] == data["crossings"][0]["slosh_validity"] == pytest.approx(0.8)
    spoilt = point([far, near[0], told(made_up(V_f=0.71), [0.0, 18.0])], ONSET)
    data = summary.point_data(spoilt)
    assert not trust.decided(spoilt) and data["slosh_holds"] is False and data["verdict"] == "undetermined"
    assert "does not hold (validity 18" in data["outcome"] and data["V_f"] == 0.7
    assert "UNDETERMINED" in summary.boundary_summary([data]) and "UNDETERMINED" not in summary.boundary_summary(
        [summary.point_data(sound)]
    )


def test_without_a_crossing_all_marches_count(made_up: Marcher) -> None:
    assert (
        summary.point_data(point([told(made_up(V_f=0.5), [0, 0.5]), told(made_up(V_f=0.9), [0, 7.0])]))["slosh_validity"] == 7.0
    )
    assert summary.point_data(point([made_up()]))["slosh_holds"] is None


def test_the_boundary_picture_marks_it(made_up: Marcher, monkeypatch: pytest.MonkeyPatch) -> None:
    labels: list[list[str]] = []

    def look(self: Figure, *_: object, **__: object) -> None:
        labels.append([text.get_text() for text in self.legends[0].get_texts()])

    monkeypatch.setattr(Figure, "savefig", look)
    for size in (0.5, 18.0):
        boundary.draw([point([told(made_up(V_f=0.71), [0.0, size])], ONSET)], "nowhere.png", None, "ems")  # type: ignore[arg-type]
    assert not any("does not hold" in text for text in labels[0]) and any("does not hold" in text for text in labels[1])


def row(made_up: Marcher, V_f: float, mach: float, size: float) -> Row:
    result = summary.march_data(told(made_up(V_f=V_f, growth=0.1 * (V_f - 0.6)), [0.0, size]))
    overrides = {"flutter.V_f": V_f, "flow.mach": mach}
    holds = bool(result["slosh_holds"])
    return Row(f"{V_f}{mach}", 0, overrides, "done", holds, result, "x.nc", "", "", "", 1, "w", 1.0, 1.0)


def crosses(made_up: Marcher, monkeypatch: pytest.MonkeyPatch, grid: bool) -> int:
    """Crosses in the picture of a sweep of four points of which one lies outside the model."""
    table = results.flat(
        [row(made_up, V, M, 30.0 if (V, M) == (0.7, 0.8) else 0.3) for V in (0.5, 0.7) for M in (0.7, 0.8)],
        "point",
        ["flutter.V_f", "flow.mach"],
    )
    seen: list[list[int]] = []

    def look(self: Figure, *_: object, **__: object) -> None:
        seen.append([len(line.get_xdata()) for axis in self.axes for line in axis.lines if line.get_marker() == "x"])

    monkeypatch.setattr(Figure, "savefig", look)
    pictures_sweep.draw(table, "point", ["flutter.V_f", "flow.mach"], grid)
    return sum(seen[0])


def test_the_map_of_a_sweep_and_its_panels_mark_it(made_up: Marcher, monkeypatch: pytest.MonkeyPatch) -> None:
    assert crosses(made_up, monkeypatch, True) == 1
    assert crosses(made_up, monkeypatch, False) == 2  # in each of the two panels


def test_the_table_of_a_sweep_says_it(made_up: Marcher) -> None:
    text = results.as_csv(results.flat([row(made_up, 0.7, 0.8, 30.0)], "point", ["flutter.V_f"]), "point", ["flutter.V_f"])
    (line,) = csv.DictReader(io.StringIO(text.decode()))
    assert (line["verdict"], line["motion_verdict"], line["slosh_holds"]) == ("undetermined", "flutter", "False")
    assert float(line["slosh_validity"]) == 30.0
