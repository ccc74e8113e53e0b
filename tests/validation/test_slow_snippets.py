"""Pages with snippets that are too slow for CI, run whole, and the site built from them: tests/docs has the quick part."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest

from support import pages
from support.processes import supported
from support.snippets import blocks

pytestmark = pytest.mark.validation


@pytest.mark.parametrize("page", [p for p in pages.RUN if any(b.slow for b in blocks(pages.ROOT / p, p))])
def test_a_page_runs_whole(page: str, fmu: Callable[[str], Path], tmp_path: Path) -> None:
    pages.run(page, tmp_path, fmu, slow=True)


class Addresses(HTMLParser):
    """What a page loads (src, stylesheets) and what its links lead to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.leads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "link" and given.get("rel") in ("stylesheet", "icon", "preload"):
            self.loads.append(given.get("href") or "")
        self.loads.append(given.get("src") or "")
        if tag == "a":
            self.leads.append(given.get("href") or "")


def test_the_site_builds_without_a_warning_and_loads_nothing_from_elsewhere(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    pytest.importorskip("furo", reason="no Sphinx: make docs installs it (requirements-docs.lock)")
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    for name in pages.FMUS:
        (fmus / f"{name}.fmu").symlink_to(fmu(name))
    staged, site = tmp_path / "source", tmp_path / "site"
    for words in (
        [str(pages.ROOT / "docs" / "site" / "stage.py"), str(staged), "--fmus", str(fmus)],
        ["-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", str(staged), str(site)],
    ):
        done = subprocess.run([sys.executable, *words], cwd=pages.ROOT, env=supported(), capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    found = {path: Addresses(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    assert len(found) > 40
    for path, addresses in found.items():
        for address in addresses.loads:
            assert "//" not in address, f"{path} loads {address}"
        for address in addresses.leads:
            target = address.partition("#")[0]
            if target and "://" not in target:
                assert (path.parent / target).exists(), f"{path} links to {address}"
