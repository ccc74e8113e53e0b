"""Every command and snippet of the tutorials, the how-to pages, README and docs/python.md runs as it stands, in an empty folder,
and prints what the page shows. Slow ones: tests/validation/test_slow_snippets.py."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from support import pages, warm_command
from support.snippets import UnmarkedBlock, blocks, missing, same

# blocks that nobody runs, and those that only `make validate` does; a new one is entered here
SKIPPED = {"README.md": 1}
SLOW = {
    "README.md": 1,
    "docs/python.md": 1,
    "docs/tutorials/1-first-flutter-point.md": 1,
    "docs/tutorials/4-train-my-surrogate.md": 2,
    "docs/tutorials/5-laptop-to-cluster.md": 3,
    "docs/howto/add-baffles.md": 1,
    "docs/howto/find-limit-cycles.md": 1,
    "docs/howto/start-a-program-on-fmus.md": 1,
    "docs/howto/use-a-coordinate-file.md": 1,
}


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the command, its imports done once."""
    with warm_command.served(tmp_path_factory.mktemp("warm")) as programs:
        yield programs


@pytest.mark.parametrize("page", pages.RUN)
def test_a_page_runs_and_prints_what_it_shows(page: str, fmu: Callable[[str], Path], warm: Path, tmp_path: Path) -> None:
    pages.run(page, tmp_path, fmu, warm)


def test_blocks_that_are_not_run_are_counted() -> None:
    found = {page: blocks(pages.ROOT / page, page) for page in pages.RUN}
    assert {p: n for p, b in found.items() if (n := Counter(x.kind for x in b)["skip"])} == SKIPPED
    assert {p: n for p, b in found.items() if (n := sum(x.slow for x in b))} == SLOW
    assert sum(x.kind in ("sh", "python") and not x.slow for b in found.values() for x in b) > 30


@pytest.mark.parametrize(
    "text",
    [
        "```\nls\n```\n",
        "```bash\nls\n```\n",
        "```text\nwhat nobody printed\n```\n",
        "```toml\na = 1\n```\n",
        "<!-- ci: skip -->\n```sh\nls\n```\n",
        "```sh\nls\n```\n```text\na\n```\n```text\nb\n```\n",
        "<!-- ci: skip, one mark is for one block -->\n```sh\nls\n```\n\n```\nls\n```\n",
    ],
)
def test_a_new_block_without_a_mark_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "page.md").write_text(text)
    with pytest.raises(UnmarkedBlock, match="page"):
        blocks(tmp_path / "page.md", "page")


def test_a_page_fails_where_a_command_fails_or_prints_something_else(
    fmu: Callable[[str], Path], warm: Path, tmp_path: Path
) -> None:
    for n, (text, said) in enumerate(
        [
            ("```sh\nfalse\necho on\n```\n", "ended badly"),
            ("```sh\nfalse | cat\n```\n", "ended badly"),
            ("```python\n1 / 0\n```\n", "ZeroDivisionError"),
            ("```sh\necho V_f 0.61\n```\n```text\nV_f 0.63\n```\n", "does not print"),
            ("<!-- ci: file a.toml -->\n```toml\nx = 1\n```\n```sh\ncat a.toml\n```\n```text\nx = 2\n```\n", "does not print"),
        ]
    ):
        page = tmp_path / f"{n}.md"
        page.write_text(text)
        with pytest.raises(AssertionError, match=said):
            pages.run(str(page), tmp_path / f"f{n}", fmu, warm)


def test_python_blocks_share_their_names_and_see_files_of_commands(
    fmu: Callable[[str], Path], warm: Path, tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "```python\na = 2\n```\n```sh\necho 3 > b\n```\n"
        "```python\nprint('sum', a + int(open('b').read()))\n```\n```text\nsum 5\n```\n"
        "```sh\nls dist/fmus\n```\n```text\naero.fmu\nslosh_vof.fmu\n```\n"
    )
    pages.run(str(page), tmp_path / "f", fmu, warm)


@pytest.mark.parametrize(
    ("wanted", "line", "equal"),
    [
        ("growth rate 0.0017 ± 0.0005", "  growth rate  0.00168 ± 0.00053  ", True),
        ("growth rate 0.0017", "growth rate 0.0019", False),
        ("growth rate 0.0017", "growth rate -0.0017", False),
        ("3 marches", "4 marches", False),
        ("cost … 525 steps (…)", "  cost   3.1 s wall, 525 steps (structure 0.06 s)", True),
        ("cost … 525 steps", "cost 524 steps", False),
        ("1e-05", "2e-05", True),
        ("1e-05", "3e-05", False),
        ("FLUTTER", "DAMPED", False),
        ("V_f 0.612:", "V_f 0.612:", True),
        ("−0.5", "-0.5", True),
    ],
)
def test_lines_are_the_same_within_the_digits_shown(wanted: str, line: str, equal: bool) -> None:
    assert same(wanted, line) is equal


def test_lines_are_shown_in_their_order() -> None:
    assert missing("a\nc\n", "a\nb\nc\n") is None
    assert missing("c\na\n", "a\nb\nc\n") == "a"
