"""A dam break without sound waves, compared with ecume's weakly compressible one and the DFSPH of SPlisHSPlasH.

    sh benchmarks/peers/install.sh FOLDER
    python benchmarks/incompressible.py [FOLDER] [--deep 20 40] [--rounds 3]

Side by side, on one thread, in processor time. The error is the mean distance of the front from that of another code's
run with 400 particles in the column's height, up to t = 2.25 sqrt(H/g), over H. Supports differ: four spacings in
ecume, two in SPlisHSPlasH, which has a third of the neighbors and computes in single precision.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume_validation.dam_break import published

HERE = Path(__file__).parent / "peers"
LONGEST = 900.0
ONE = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def commands(folder: Path | None, deep: int) -> dict[str, list[str]]:
    """What to run, by name."""
    mine = {f"ecume, {name}": [sys.executable, "dam.py", name, str(deep)] for name in ("tait", "incompressible")}
    python = folder / "splishsplash" / "bin" / "python" if folder else None
    if python is None or not python.exists():
        print("SPlisHSPlasH: not installed (sh benchmarks/peers/install.sh FOLDER)")
        return mine
    return {**mine, "SPlisHSPlasH, DFSPH": [str(python), "dam_in_splishsplash.py", str(deep)]}


def result_of(command: list[str]) -> dict[str, Any]:
    """The result of a process. Raises RuntimeError if it has none."""
    run = subprocess.run(
        command, cwd=HERE, env={**os.environ, **ONE}, capture_output=True, text=True, timeout=LONGEST, check=False
    )
    for line in run.stdout.splitlines():
        if line.startswith("RESULT "):
            found: dict[str, Any] = json.loads(line.removeprefix("RESULT "))
            return found
    raise RuntimeError(f"{' '.join(command)} ended with {run.returncode}: {run.stderr[-300:]}")


def error_of(front: dict[str, float]) -> float:
    """The mean distance from the published front."""
    when, where = published("front", "wcsph-400")
    computed = np.interp(when, [0.0, *map(float, front)], [2.0, *front.values()])
    return float(np.abs(computed - where).mean())


def main() -> int:
    """Measure in turns, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("folder", type=Path, nargs="?", help="where peers/install.sh put SPlisHSPlasH")
    parser.add_argument(
        "--deep", type=int, nargs="+", default=sized([20, 40], [8]), help="particles in the column's height"
    )
    parser.add_argument("--rounds", type=int, default=sized(3, 1))
    asked = parser.parse_args()
    print(f"{machine()}\n\n| run | H / spacing | processor time, s | of the runs | steps | iterations | error |")
    print("|---|---|---|---|---|---|---|")
    for deep in asked.deep:
        every = commands(asked.folder and asked.folder.absolute(), deep)
        rounds = [{name: result_of(command) for name, command in every.items()} for _ in range(asked.rounds)]
        for name in every:
            several, last = [each[name]["processor"] for each in rounds], rounds[-1][name]
            print(
                f"| {name} | {deep} | {statistics.median(several):.3g} | {min(several):.3g}-{max(several):.3g} "
                f"| {last['steps']:.0f} | {last.get('iterations', 0.0):.1f} | {error_of(last['front']):.3f} |",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
