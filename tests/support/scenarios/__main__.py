"""A small host: `python -m support.scenarios <scenario> <json arguments>` runs FMUs through FMPy and prints JSON.

Each scenario has a process of its own, so that a crash is seen as a crash, and ends with `os._exit`
(pythonfmu 0.7 releases its interpreter state twice at process exit).
"""

from __future__ import annotations

import json
import os
import sys

from . import kit, slosh, vof, wing

MODULES = (kit, wing, slosh, vof)

if __name__ == "__main__":
    (scenario,) = (vars(module)[sys.argv[1]] for module in MODULES if sys.argv[1] in vars(module))
    answer = scenario(*json.loads(sys.argv[2]))
    print("\n" + json.dumps(answer), flush=True)
    os._exit(0)
