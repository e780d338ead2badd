"""A million tracers in a steady gyre on a grid, in ecume and parcels: the same scheme, step and grid, one core.

    python benchmarks/parcels_tracers.py [PYTHON] [--count 1000000] [--steps 40] [--rounds 3]

PYTHON is an interpreter with parcels (`pip install parcels` in an environment of its own); without it ecume alone is
measured. Both integrate the fourth-order method of Runge and Kutta with a step of 10 ms on 129 x 65 nodes; ecume with
its stream function, which has no divergence, and linearly as parcels does. Times are processor times of one thread per
particle and step, in turns; frames are included for ecume. The peak of memory is that of the process; that of ten
million tracers is measured by `--count 10000000 --steps 2 --rounds 1`.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from ecume._quick import parser_of, sized

HERE = Path(__file__).parent / "peers"
NODES, STEP = (129, 65), 0.01
ONE = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
INSIDE = """
import json, resource, sys, time
import numpy as np
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

plain = json.load(open(sys.argv[1]))
count, steps = int(sys.argv[2]), int(sys.argv[3])
plain["particles"] = [{"radius": 1e-6, "density": 1000.0, "count": count}]
plain |= {"duration": (steps + 1) * 0.01, "frame_every": (steps + 1) * 0.01}
small = {**plain, "particles": [{**plain["particles"][0], "count": 10}], "duration": 0.02, "frame_every": 0.02}
list(simulate(from_plain(small)))  # compiles
frames = simulate(from_plain(plain))
next(frames)
begun = time.process_time()
last = next(frames)
taken = time.process_time() - begun
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0
print(json.dumps({"seconds": taken / count / (steps + 1), "peak": peak, "inside": last.numbers["particles_inside"]}))
"""


def scene(folder: Path, interpolation: str) -> Path:
    """The scene of the gyre, and its grid."""
    x, y = np.linspace(0.0, 2.0, NODES[0]), np.linspace(0.0, 1.0, NODES[1])
    across, up = np.meshgrid(x, y, indexing="ij")
    u, v = -np.sin(np.pi * across) * np.cos(np.pi * up), np.cos(np.pi * across) * np.sin(np.pi * up)
    np.savez(folder / "gyre.npz", x=x, y=y, u=u, v=v)
    plain = {
        "model": "tracers", "gravity": 0.0, "tank": {"high": [2.0, 1.0]},
        "flow": {"field": {"file": str(folder / "gyre.npz"), "interpolation": interpolation}},
        "integration": {"integrator": "overdamped", "time_step": STEP},
    }  # fmt: skip
    path = folder / f"{interpolation}.json"
    path.write_text(json.dumps(plain), encoding="utf-8")
    return path


def measured(words: list[str]) -> dict[str, float]:
    """What a process prints in its last line."""
    done = subprocess.run(words, env=ONE, capture_output=True, text=True, check=True)  # a program given
    found: dict[str, float] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def main() -> None:
    """Measure in turns, and print medians and ratios."""
    parser = parser_of(__doc__)
    parser.add_argument("python", nargs="?", default="")
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    count, steps, rounds = (
        sized(each, least) for each, least in ((given.count, 1000), (given.steps, 2), (given.rounds, 1))
    )
    times: dict[str, list[dict[str, float]]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        programs = {
            f"ecume, {way}": [sys.executable, "-c", INSIDE, str(scene(folder, way)), str(count), str(steps)]
            for way in ("divergence-free", "linear")
        }
        if given.python:
            programs["parcels"] = [given.python, str(HERE / "in_parcels.py"), str(count), str(steps)]
        for _ in range(rounds):
            for program, words in programs.items():
                times.setdefault(program, []).append(measured(words))
    print(f"{count} particles, {steps} steps")
    usual = statistics.median(each["seconds"] for each in times["ecume, divergence-free"])
    for program, found in times.items():
        taken = statistics.median(each["seconds"] for each in found)
        peak = max(each["peak"] for each in found) / 1e9
        print(f"{program:24s} {1e6 * taken:8.4f} us per particle and step, {taken / usual:6.2f} x, peak {peak:.2f} GB")


if __name__ == "__main__":
    main()
