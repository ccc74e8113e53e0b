"""Where the package lies."""

from __future__ import annotations

from pathlib import Path

# not resolved: in a checkout `aeroslosh/master` is a link, and what it points to has another parent
PLACE = Path(__file__).absolute().parents[3]
"""The folder that holds the package `aeroslosh`: a checkout or site-packages. A child process needs it on PYTHONPATH."""
