"""What stands beside the physics in each FMU: the reference result, the pages, the icon, and the README they come from."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
import zipfile
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from aeroslosh.fmus.build import archive as build_archive
from aeroslosh.fmus.build import readme
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.hosts import reference

Fmu = Callable[[str], Path]
Host = Callable[..., Any]
COMPONENTS = sorted(build_archive.components())


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_fmu_reproduces_its_reference_result(fmu: Fmu, host: Host, component: str) -> None:
    differences = host("reference", str(fmu(component)))
    assert len(differences) >= 3
    for name, found, allowed in differences:
        assert found <= allowed, name


@pytest.mark.parametrize("component", COMPONENTS)
def test_a_reference_experiment_moves_every_output_it_compares(fmu: Fmu, component: str) -> None:
    """A comparison of nothing with nothing would always fit."""
    known = reference.read(fmu(component))
    for name in known.experiment["outputs"]:
        assert np.ptp(known.outputs[name]) > 0.0, name
        assert 0.0 < known.experiment["outputs"][name] <= 1e-5, name
    for name, column in known.inputs.items():
        assert name == "time" or (column[0] == 0.0 and np.ptp(column) > 0.0), name


def test_another_result_does_not_fit(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    """The same FMU with another number in its experiment."""
    changed = tmp_path / "structure.fmu"
    with zipfile.ZipFile(fmu("structure")) as source, zipfile.ZipFile(changed, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name.endswith("experiment.json"):
                experiment = json.loads(data)
                experiment["start_values"]["mass"] = 57.73001
                data = json.dumps(experiment).encode()
            target.writestr(name, data)
    assert all(found > allowed for name, found, allowed in host("reference", str(changed)) if name != "energy")


def test_an_fmu_without_reference_is_a_clear_error(fmu: Fmu, tmp_path: Path) -> None:
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(bare, "w") as archive:
        archive.writestr("modelDescription.xml", "<x/>")
    with pytest.raises(AeroSloshError, match=r"carries no reference result.*[\s\S]*make fmus"):
        reference.read(bare)


@pytest.mark.parametrize("component", COMPONENTS)
def test_readme_is_up_to_date_and_complete(component: str) -> None:
    folder = build_archive.ROOT / component
    text = (folder / "README.md").read_text(encoding="utf-8")
    assert text == readme.current(folder), "python -m aeroslosh.fmus.build.readme"
    headings = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert {"Variables", "Limits and validity", "Reference result"} <= set(headings)
    assert "<!-- variables -->" in text
    assert "<!-- reference -->" in text


def test_the_generated_parts_follow_what_they_are_made_from(tmp_path: Path) -> None:
    folder = tmp_path / "reference"
    shutil.copytree(build_archive.ROOT / "structure" / "reference", folder)
    rows = list(csv.reader(io.StringIO((folder / "output.csv").read_text(encoding="utf-8"))))
    rows[1][1] = "12.5"
    (folder / "output.csv").write_text("\n".join(",".join(row) for row in rows), encoding="utf-8")
    table = readme.reference_table(folder)
    assert "| 0 | 1.250000e+01 |" in table
    assert readme.filled("a\n<!-- reference -->\n\n<!-- /reference -->\nb", {"reference": table}).count("1.250000e+01") == 1


class Page(HTMLParser):
    """Collects what a page shows and points to; notes elements that are left open."""

    def __init__(self) -> None:
        super().__init__()
        self.text, self.links, self.open = "", [], []  # type: ignore[var-annotated]

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        found = dict(attributes)
        self.links += [found[key] for key in ("href", "src") if key in found]
        if tag not in ("meta", "img", "br", "hr"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.parametrize("component", COMPONENTS)
def test_index_page_and_icon(fmu: Fmu, component: str) -> None:
    with zipfile.ZipFile(fmu(component)) as archive:
        names = set(archive.namelist())
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
        page = Page()
        page.feed(archive.read("documentation/index.html").decode())
        icon = archive.read("model.png")
    assert page.open == []
    for variable in description.iter("ScalarVariable"):
        assert str(variable.get("name")) in page.text
        assert str(variable.get("description")) in " ".join(page.text.split())
    for heading in ("Equations", "Inputs", "Outputs", "Parameters", "Limits and validity", "Reference result", "This file"):
        assert heading in page.text
    assert str(description.get("guid")) in page.text
    inside = {link for link in page.links if not link.startswith(("http", "#"))}
    assert {"../model.png", "reference/picture.svg"} == inside
    assert {"documentation/reference/picture.svg", "documentation/README.md", "resources/requirements.txt"} <= names
    assert icon[:8] == b"\x89PNG\r\n\x1a\n"


@pytest.mark.parametrize("component", COMPONENTS)
def test_documentation_is_no_part_of_the_content_hash(fmu: Fmu, component: str) -> None:
    with zipfile.ZipFile(fmu(component)) as archive:
        carried = [name for name in archive.namelist() if name.startswith("resources/")]
    assert not [name for name in carried if "/reference/" in name or name.endswith(("icon.png", ".md"))]


@pytest.mark.parametrize("component", COMPONENTS)
def test_every_real_with_a_unit_has_a_type(fmu: Fmu, component: str) -> None:
    with zipfile.ZipFile(fmu(component)) as archive:
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
    types = {simple.get("name"): simple.find("Real") for simple in description.iter("SimpleType")}
    for variable in description.iter("ScalarVariable"):
        real = variable.find("Real")
        if real is None:
            continue
        assert real.get("unit"), variable.get("name")
        if real.get("unit") not in ("1", "%"):
            declared = types[real.get("declaredType")]
            assert declared is not None
            assert (declared.get("unit"), declared.get("quantity")) == (real.get("unit"), real.get("quantity"))
