"""The end of a sweep: its table and picture, what is printed, and the exit code."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import os
from typing import Any

from ..base.errors import ExitCode
from ..case import fuel_tank
from ..sweeps import envelope
from ..sweeps import results as sweep_results
from ..sweeps.plan import Plan
from ..sweeps.progress import duration
from ..sweeps.sweep import Store

SHOWN = 5  # causes of failures in the summary


def conclude(options: argparse.Namespace, plan: Plan, store: Store, wall: float, told: dict[str, Any]) -> int:
    """Write sweep.csv and sweep.png, print the summary; `wall` seconds were spent, `told` of the case (`common.tell`) goes into
    the JSON. Raises AeroSloshError on a full disk."""
    rows = store.ledger.rows()
    table = sweep_results.flat(rows, plan.kind, plan.names)
    files = ["sweep.csv"]
    store.write("sweep.csv", sweep_results.as_csv(table, plan.kind, plan.names))
    if not options.no_pictures:
        from ..pictures import sweep as pictures_sweep  # matplotlib takes half a second to import

        picture = pictures_sweep.draw(table, plan.kind, plan.names, plan.mode == "grid")
        if picture is not None:
            store.write("sweep.png", picture)
            files.append("sweep.png")
    found = envelope.points(rows, plan.names) if envelope.wanted(plan.kind, plan.names) else []
    if found:
        files += _envelope(options, plan, store, found)
    failed = [row for row in rows if row.status == "failed"]
    undetermined = [row for row in rows if row.status == "done" and not row.determined]
    broken = [line for line in table if line["slosh_holds"] is False]
    data: dict[str, Any] = {
        "points": len(rows),
        "done": len(rows) - len(failed),
        "failed": len(failed),
        "undetermined": len(undetermined),
        "slosh_does_not_hold": len({line["id"] for line in broken}),
        "wall_seconds": wall,
        "cpu_seconds": sum(row.cpu_seconds for row in rows),
        "folder": str(store.folder),
    } | told
    if envelope.wanted(plan.kind, plan.names):
        data["matched"] = found
    if options.json:
        print(json.dumps(data | {"rows": [dataclasses.asdict(row) for row in rows]}, allow_nan=False))
    else:
        print(f"{data['done']} of {len(rows)} points done, {len(failed)} failed, {len(undetermined)} without a verdict")
        for row in failed[:SHOWN]:
            said = ", ".join(f"{name} {value}" for name, value in row.overrides.items())
            print(f"  failed: {said}: {row.cause}")
        if len(failed) > SHOWN:
            print(f"  … {len(failed) - SHOWN} more in sweep.csv")
        if broken:
            worst = max((line["slosh_validity"] or math.inf for line in broken), default=math.inf)
            print(
                f"  {data['slosh_does_not_hold']} points: {fuel_tank.broken(worst)} (slosh_validity, crosses in the picture)\n"
                '  remedy       smaller motions (flutter.forced_amplitude_deg) or slosh.model = "vof"'
            )
        if envelope.wanted(plan.kind, plan.names):
            print("\n".join(envelope.lines(found, rows)))
        print(f"  cost         {duration(wall)} wall, {duration(data['cpu_seconds'])} CPU of all points")
        print(f"  sweep folder {os.path.relpath(store.folder)} ({', '.join(files)})")
    if failed:
        return ExitCode.COMPONENT
    return ExitCode.UNDETERMINED if undetermined else ExitCode.OK


def _envelope(options: argparse.Namespace, plan: Plan, store: Store, found: list[dict[str, Any]]) -> list[str]:
    """Table and picture of the altitudes and speeds at which the wing flutters; returns the files' names."""
    store.write("envelope.csv", envelope.as_csv(found, plan.names))
    if options.no_pictures:
        return ["envelope.csv"]
    from ..pictures import envelope as picture  # matplotlib takes half a second to import

    others = [n for n in plan.names if n not in (envelope.ALTITUDE, envelope.MACH)]
    altitudes = [p.overrides[envelope.ALTITUDE] for p in plan.points]
    slosh = " and ".join(dict.fromkeys(p.case.slosh.model for p in plan.points))
    store.write("envelope.png", picture.draw(found, others, slosh, min(altitudes), max(altitudes)))
    return ["envelope.csv", "envelope.png"]
