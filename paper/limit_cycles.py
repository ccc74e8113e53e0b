"""Limit-cycle amplitude over V_f at one Mach number, between onset and recovery of flutter.

`python -m paper.limit_cycles [mach] [V_f …]` marches each point for 40 free cycles from 3 degrees and prints a Markdown table.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CYCLES = 40


def main() -> None:
    """March and print."""
    mach = sys.argv[1] if len(sys.argv) > 1 else "0.875"
    speeds = sys.argv[2:] or ["0.6", "0.8", "1.0", "1.2", "1.42", "1.6", "1.8"]
    print("| V_f | verdict | pitch amplitude | ω/ω_α | s CPU |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for V_f in speeds:
            command = [sys.executable, "-m", "aeroslosh", "point", "cases/isogai_a.toml", "--mach", mach, "--vf", V_f]
            command += ["--set", f"flutter.free_cycles={CYCLES}", "--set", "flutter.forced_amplitude_deg=3"]
            command += ["--set", "flutter.max_alpha_deg=20", "--json", "--quiet", "--no-pictures", "--out", f"{folder}/{V_f}"]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
            if done.returncode not in (0, 4):
                raise SystemExit(done.stderr)
            result = json.loads(done.stdout)
            amplitude = result["limit_cycle_amplitude_deg"]
            size = "" if amplitude is None else f"{amplitude:.2f}°"
            cost = result["cost"]["cpu_seconds"]
            print(f"| {V_f} | {result['verdict']} | {size} | {result['frequency']:.3f} | {cost:.0f} |", flush=True)


if __name__ == "__main__":
    main()
