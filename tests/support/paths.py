"""Where things lie, for every test."""

from __future__ import annotations

from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent
CASES = ROOT / "cases"
DATA = TESTS / "data"
DIST = ROOT / "dist" / "fmus"
DOUBLES = TESTS / "support" / "doubles"
COMPONENTS = TESTS / "support" / "components"
