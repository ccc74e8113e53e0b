"""`import aeroslosh` and `aeroslosh --help` load next to nothing."""

from __future__ import annotations

import subprocess
import sys

import aeroslosh as ae
from support.processes import supported

HEAVY = "numpy scipy xarray pandas matplotlib fmpy numba torch"
CODE = """
import sys
{what}
print(*[name for name in {heavy!r}.split() if name in sys.modules])
"""


def loaded(what: str) -> list[str]:
    code = CODE.format(what=what, heavy=HEAVY)
    done = subprocess.run([sys.executable, "-c", code], env=supported(), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1].split()


def test_importing_loads_nothing_heavy() -> None:
    assert loaded("import aeroslosh; dir(aeroslosh); aeroslosh.__version__; aeroslosh.AeroSloshError") == []


def test_help_loads_nothing_heavy() -> None:
    assert loaded("from aeroslosh.master import cli\ntry: cli.run(['--help'])\nexcept SystemExit: pass") == []


def test_a_case_loads_no_pictures() -> None:
    assert not {"matplotlib", "xarray", "pandas", "numba"} & set(loaded("import aeroslosh; aeroslosh.Case.isogai_a()"))


def test_every_public_name_is_there_and_documented() -> None:
    for name in ae.__all__:
        thing = getattr(ae, name)
        assert name.startswith("__") or (thing.__doc__ or "").strip(), name
