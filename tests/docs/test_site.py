"""What the site is made of, without Sphinx: links that lead somewhere, a reference that has every key, name, variable and code.

The site itself is built by tests/validation/test_slow_snippets.py and `make docs`: Sphinx is no part of the test environment."""

from __future__ import annotations

import dataclasses
import importlib.util
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from fmpy import read_model_description

import aeroslosh
from aeroslosh.master.base.errors import ExitCode
from aeroslosh.master.case.case import TABLES
from aeroslosh.master.commands import HELP
from aeroslosh.master.cosim import system_file
from aeroslosh.master.training.case import TABLES as TRAINING
from support.pages import FMUS, ROOT

SITE = ROOT / "docs" / "site"


def script(name: str) -> ModuleType:
    """A script of docs/site."""
    sys.path.insert(0, str(SITE))
    try:
        spec = importlib.util.spec_from_file_location(f"site_{name}", SITE / f"{name}.py")
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(SITE))
    return module


stage = script("stage")


def slugs(text: str) -> set[str]:
    """Anchors of a page's headings, as GitHub and MyST make them."""
    plain = stage.FENCE.sub("", text)
    heads = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", h) for h in re.findall(r"^#+ (.+)$", plain, re.MULTILINE)]
    return {re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in heads}


@pytest.mark.parametrize("page", stage.pages(), ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    assert [target for target in stage.links(page) if not target.is_file()] == []
    text = re.sub(r"`[^`\n]*`", "", stage.FENCE.sub("", page.read_text(encoding="utf-8")))
    for target, anchor in re.findall(r"\]\(([^)\s#]*)#([^)\s]+)\)", text):
        if "://" not in target:
            other = page.parent / target if target else page
            assert anchor in slugs(other.read_text(encoding="utf-8")), f"{target}#{anchor}"


def test_the_readme_is_one_page_and_names_what_there_is() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 90 and len(text) < 8000
    table = text.partition("| command | does |")[2].partition("\n\n")[0]
    named = {word for row in table.splitlines()[2:] for word in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert named <= set(HELP) and len(named) > 12
    assert {"docs/tutorials/1-first-flutter-point.md", "docs/cases.md"} <= set(re.findall(r"\]\(([^)#]+)", text))
    assert all(f"| `{name}` |" in text for name in FMUS)


def test_every_page_of_the_documentation_has_a_shelf() -> None:
    """New pages beside today's are taken up by themselves; the shelves name no page that is not there."""
    shelved = set()
    for shelf in ("tutorials", "howto", "reference", "explanation", "index"):
        for line in re.findall(r"^[\w./*-]+$", (SITE / f"{shelf}.md").read_text(), re.MULTILINE):
            found = [*ROOT.glob(f"{line}.md"), *SITE.glob(f"{line}.md")]
            assert found or line.startswith("reference/"), line
            shelved |= {p.resolve() for p in found}
    assert {p.resolve() for p in stage.pages()} - shelved == set()


def test_the_reference_has_every_key_with_its_default() -> None:
    pages = script("case_pages").pages()
    for name, kind in TABLES.items():
        section = pages["case-keys"].partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        for field in dataclasses.fields(kind):
            row = next(line for line in section.splitlines() if line.lstrip("|* ").startswith(f"`{field.name}`"))
            assert row.count(" | ") == 4
            default = getattr(kind(), field.name)
            told = row.split(" | ")[1]
            assert (
                told.startswith("must be given")
                or default is None
                or isinstance(default, list | dict | str | bool)
                or f"{default}" in told
            )
            assert field.metadata["unit"] in ("1", row.split(" | ")[3])
    for kind in (*TRAINING.values(), system_file.Part, system_file.Wiring, system_file.Run):
        where = "case-keys" if kind in TABLES.values() else "file-keys"
        assert all(f"`{f.name}`" in pages[where] for f in dataclasses.fields(kind))
    must = re.findall(r"^\| \*\*`(\w+)`\*\*", pages["case-keys"], re.MULTILINE)
    assert {"elastic_axis", "mass_ratio", "airfoil", "tank_length"} <= set(must) and "gravity" not in must


def test_the_reference_has_every_name_command_code_and_variable(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    pages = script("code_pages").pages()
    assert set(re.findall(r"^## (\w+)$", pages["python-names"], re.MULTILINE)) == {
        n for n in aeroslosh.__all__ if not n.startswith("_")
    }
    assert "### Case.replace" in pages["python-names"] and "Raises AeroSloshError" in pages["python-names"]
    assert re.findall(r"^## (\w+)$", pages["commands"], re.MULTILINE) == list(HELP) and "--checkpoint" in pages["commands"]
    assert [int(c) for c in re.findall(r"^\| (\d+) \|", pages["exit-codes"], re.MULTILINE)] == [int(c) for c in ExitCode]
    for name in FMUS:
        (tmp_path / f"{name}.fmu").symlink_to(fmu(name))
    told = script("fmu_pages").pages(tmp_path)["fmu-variables"]
    for name in FMUS:
        section = told.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        variables = read_model_description(fmu(name), validate=False).modelVariables
        assert (
            len(variables) > 20
            and [v.name for v in variables if v.causality != "independent" and f"| `{v.name}` |" not in section] == []
        )
    with pytest.raises(FileNotFoundError, match="make fmus"):
        script("fmu_pages").pages(tmp_path / "none")


def test_the_staged_sources_hold_what_their_links_lead_to(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    (tmp_path / "fmus").mkdir()
    (tmp_path / "fmus" / "structure.fmu").symlink_to(fmu("structure"))
    stage.stage(tmp_path / "out", tmp_path / "fmus")
    for page in (tmp_path / "out").rglob("*.md"):
        assert [target for target in stage.links(page) if not target.exists()] == [], page
    assert (tmp_path / "out" / "conf.py").is_file() and (tmp_path / "out" / "reference" / "case-keys.md").is_file()
