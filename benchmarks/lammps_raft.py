"""The same raft of a thousand floats in LAMMPS and in ecume, one core each, side by side.

    python benchmarks/lammps_raft.py

LAMMPS gets what its users would write: a tabulated pair force made from our law, Hookean contacts stiff enough to keep
overlaps below a thousandth of a radius, viscous drag, and the time step which that stiffness asks for. Needs the extra
`bench`.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import k0, k1
from timed_runs import TimedRun, heavy_spheres, lammps_library, machine

from ecume._jit import use_threads
from ecume._quick import parser_of, sized

COUNT = sized(1000, 50)
POINTS = 10_000
SPACING = 2.02e-3
"""Between neighbors of the lattice (m): a raft about to close."""
STEPS = sized(200, 2)
OVERLAP = 1e-3
"""What LAMMPS's contacts may overlap by, over a radius."""
ROUNDS = sized(3, 1)


def table_of(run: TimedRun, path: Path) -> None:
    """Our pair law as LAMMPS reads it: r, energy, force."""
    strength, length, cutoff = run.parameters.pair[:3]
    charge = run.parameters.floats.charge[0]
    r = np.linspace(1.5e-3, cutoff, POINTS)
    scale = strength * charge**2
    rows = zip(r, -scale * k0(r / length), -scale / length * k1(r / length), strict=True)
    lines = [f"{k} {x:.12e} {energy:.12e} {force:.12e}" for k, (x, energy, force) in enumerate(rows, 1)]
    path.write_text(f"RAFT\nN {POINTS} R 1.5e-3 {cutoff:.12e}\n\n" + "\n".join(lines) + "\n")


def contact_stiffness(run: TimedRun) -> float:
    """N/m: what keeps the overlap of a pair in the middle of the raft below its bound."""
    strength, length = run.parameters.pair[:2]
    floats = run.parameters.floats
    pull = strength * floats.charge[0] ** 2 / length * k1(2.0 * floats.radius[0] / length)
    # A raft presses on its middle with many neighbors' pulls; six is what the first ring alone gives.
    return float(6.0 * pull / (OVERLAP * floats.radius[0]))


def lammps_of(lammps: Any, run: TimedRun, folder: Path, contacts: bool) -> tuple[Any, float]:
    """LAMMPS with the same floats at the same places, and its time step (s)."""
    floats, position = run.parameters.floats, run.state.position
    stiffness, mass = contact_stiffness(run), float(floats.mass[0])
    step = 0.05 * math.pi * math.sqrt(0.5 * mass / stiffness) if contacts else run.parameters.time_step
    table_of(run, folder / "raft.table")
    half, cutoff = 2.0 * float(np.abs(position).max()), float(run.parameters.cutoff)
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    for line in (
        "units si", "dimension 2", "atom_style sphere", "boundary f f p", "newton on", "comm_modify vel yes",
        f"region all block {-half} {half} {-half} {half} -0.01 0.01", "create_box 1 all",
    ):  # fmt: skip
        engine.command(line)
    places = np.column_stack([position, np.zeros(len(position))])
    engine.create_atoms(len(position), None, np.ones(len(position), dtype=np.int32), places.ravel())
    table = f"pair_coeff * * table {folder / 'raft.table'} RAFT {cutoff * (1.0 - 1e-9)}"
    damping = 2.0 * math.sqrt(stiffness / mass)
    density = 3.0 * mass / (4.0 * math.pi * floats.radius[0] ** 3)
    for line in (
        f"set group all diameter {2.0 * floats.radius[0]} density {density}",
        f"pair_style hybrid/overlay table linear {POINTS} gran/hooke {stiffness} 0.0 {damping} 0.0 0.0 0"
        if contacts
        else f"pair_style hybrid/overlay table linear {POINTS}",
        table,
        *(["pair_coeff * * gran/hooke"] if contacts else []),
        f"neighbor {run.parameters.skin} bin", "neigh_modify every 1 delay 0 check yes",
        f"fix drag all viscous {mass / floats.relaxation_time[0]}", "fix flat all enforce2d",
        # Without contacts the raft would fall into itself: its floats stay where they are.
        *(["fix move all nve"] if contacts else []),
        f"timestep {step}", "thermo 1000000", "run 0",
    ):  # fmt: skip
        engine.command(line)
    return engine, step


def timed(action: Any) -> float:
    """Wall seconds."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def lattice() -> TimedRun:
    """A raft about to close."""
    return TimedRun(heavy_spheres(f'count = {COUNT}\nplacement = "lattice"\nspacing = {SPACING}\n'))


def main() -> int:
    """Print both ratios."""
    parser_of(__doc__).parse_args()
    if (lammps := lammps_library()) is None:
        return 0
    use_threads(1)
    print(machine(), "\n")
    with tempfile.TemporaryDirectory() as name:
        run = lattice()
        run.go(1)
        lattice().go(5)  # compiled now
        ours_force = run.workspace.force.copy()
        bare, _ = lammps_of(lammps, run, Path(name), contacts=False)
        ids = np.argsort(np.array(bare.numpy.extract_atom("id"))[:COUNT])
        theirs = np.array(bare.numpy.extract_atom("f"))[:COUNT][ids][:, :2]
        difference = np.max(np.abs(theirs - ours_force)) / np.max(np.abs(ours_force))
        print(f"forces at one place differ by {difference:.1e} of the largest (the table's linear interpolation)")
        full, their_step = lammps_of(lammps, run, Path(name), contacts=True)
        ratios = [compare(run, bare, full, their_step) for _ in range(ROUNDS)]
    steps, rafts = np.median(np.array(ratios), axis=0)
    print(f"median: steps a second, pair forces alone in LAMMPS, whole steps in ecume: ecume/LAMMPS = {steps:.2f}")
    print(f"median: simulated seconds a second, the same raft with contacts: ecume/LAMMPS = {rafts:.1f}")
    return 0


def compare(run: TimedRun, bare: Any, full: Any, their_step: float) -> tuple[float, float]:
    """One round: both ratios."""
    our_step = run.parameters.time_step
    ours = timed(lambda: run.go(STEPS)) / STEPS
    forces = timed(lambda: bare.command(f"run {STEPS} post no")) / STEPS
    whole = timed(lambda: full.command(f"run {STEPS} post no")) / STEPS
    print(
        f"ecume {ours * 1e3:.2f} ms a step of {our_step * 1e3:.3g} ms; LAMMPS {forces * 1e3:.2f} ms a step without "
        f"contacts, {whole * 1e3:.2f} ms a step of {their_step * 1e3:.3g} ms with them"
    )
    return forces / ours, (our_step / ours) / (their_step / whole)


if __name__ == "__main__":
    sys.exit(main())
