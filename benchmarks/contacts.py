"""The contacts of rafts, solved together: sweeps, residual, and time.

    python benchmarks/contacts.py [MOST_CONTACTS]

A raft on a triangular lattice, closed up to a millionth of a radius, is pressed by its own menisci. The solver makes
all stop from nothing, as in a raft's first step, and then from its last solution, after every pull has
changed by up to a hundredth, as in each step that follows. One thread: a sweep goes from contact to contact.
"""

from __future__ import annotations

import time

import numpy as np
from timed_runs import TimedRun, heavy_spheres, machine

from ecume._jit import use_threads
from ecume._quick import parser_of, sized
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers
from ecume.engine.contact.contacts import DiscMotion
from ecume.engine.contact.impulse_solvers import CONVERGED, Tolerance
from ecume.models.floating.contacts.collisions import TOLERABLE, contact_bodies
from ecume.models.floating.time_integration.integration import forces_at

SPACING = 2.000001e-3
CONTACTS_PER_FLOAT = 2.97
SIZES = sized((1_000, 10_000, 100_000), (100,))
CHANGE = 0.01


def raft(contacts: int) -> TimedRun:
    """A raft with about so many contacts."""
    count = round(contacts / CONTACTS_PER_FLOAT)
    return TimedRun(heavy_spheres(f'count = {count}\nplacement = "lattice"\nspacing = {SPACING}\n'))


def pressed(run: TimedRun) -> np.ndarray:
    """The velocities that menisci give in one kick."""
    parameters, state, work = run.parameters, run.state, run.workspace
    forces_at(parameters, state.position, work)
    return parameters.kick.gain[:, None] * work.force


def solved(run: TimedRun, velocity: np.ndarray) -> tuple[int, float, float]:
    """Sweeps, residual over the fastest approach, and processor time, from the impulses that stand in the contacts."""
    parameters, contacts = run.parameters, run.workspace.contacts
    mobility = parameters.kick.mobility
    touching.normal_velocities(contacts, velocity, contacts.scratch)
    rows = contacts.total[0]
    contacts.bound[:rows] = -np.maximum(contacts.gap[:rows], 0.0) / parameters.time_step
    fastest = float(np.max(contacts.bound[:rows] - contacts.scratch[:rows]))
    goal = Tolerance(CONVERGED * fastest, TOLERABLE * parameters.slop / parameters.time_step)
    began = time.process_time()
    sweeps = impulse_solvers.solve(contacts, DiscMotion(velocity, mobility), goal)
    spent = time.process_time() - began
    return sweeps, impulse_solvers.residual(contacts, DiscMotion(velocity, mobility), np.arange(rows)) / fastest, spent


def measured(size: int) -> None:
    """One raft: from nothing, and from the last solution."""
    run = raft(size)
    work, kick = run.workspace, pressed(run)
    touching.gather(work.contacts, work.candidates, run.state.position, contact_bodies(run.parameters), 1e-6)
    touching.set_effective_masses(work.contacts, run.parameters.kick.mobility)
    work.contacts.impulse[:] = 0.0
    chance = np.random.default_rng(1).uniform(1.0 - CHANGE, 1.0 + CHANGE, (len(kick), 1))
    for start, velocity in (("nothing", kick.copy()), ("the last solution", kick * chance)):
        sweeps, left, spent = solved(run, velocity)
        each = 1e9 * spent / (sweeps * work.contacts.total[0])
        print(
            f"{work.contacts.total[0]:8d} contacts from {start:18s} {sweeps:6d} sweeps, {left:8.1e} left, "
            f"{spent:8.3f} s, {each:5.1f} ns a contact and sweep",
            flush=True,
        )


def main() -> None:
    """All sizes up to the one asked for."""
    parser = parser_of(__doc__)
    parser.add_argument("most", metavar="MOST_CONTACTS", type=int, nargs="?", default=max(SIZES))
    most = parser.parse_args().most
    use_threads(1)
    print(machine(), "\n")
    measured(100)
    for size in (size for size in SIZES if size <= most):
        measured(size)


if __name__ == "__main__":
    main()
