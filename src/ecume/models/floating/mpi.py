"""Floats on many MPI ranks: each rank has the neighbor lists of a part of the floats and sums the forces of their
pairs.

Every rank holds the whole state. The stretches that threads share (see `forces.pair_forces`) are distributed in
consecutive runs, and with them the rows of the lists. All ranks receive the pairs that may touch, and the windows of
forces of the other ranks, which they add up in order, as in one process. Kicks, drag, noise, contacts and walls are
the same compiled code on the same numbers, so that all ranks compute the same bits, which are those of a run without
MPI. This is the replicated-data method [plimpton1995, sec. 3]: the replicated work and the messages limit it.
"""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import projected_gauss_seidel
from ecume.engine.contact.contacts import Bodies, Candidates, Contacts
from ecume.engine.contact.projected_gauss_seidel import Goal
from ecume.engine.mpi_exchange import Share
from ecume.engine.neighbors import (
    STRETCHES,
    THREADS_FROM,
    NeighborLists,
    count_neighbors,
    make_room,
    place_windows,
    sort_positions,
    write_neighbors,
)
from ecume.errors import BadInput
from ecume.models.floating.contacts import collisions, contact_models
from ecume.models.floating.forces import interactions
from ecume.models.floating.forces.interactions import sort_parts
from ecume.models.floating.forces.pair_forces import (
    Sorted,
    add_from_slots,
    add_wall_forces,
    add_windows,
    pairs_of,
    sort_floats,
    sum_in_parallel,
    sum_stretches,
)
from ecume.models.floating.options import Option
from ecume.models.floating.parameters import Parameters, Parts, Scratch
from ecume.models.floating.record import workspace
from ecume.models.floating.setup.scene_parameters import faults_with
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.time_integration import integration
from ecume.models.floating.time_integration.integration import EveryRow, find_pairs, renew_lists, sort_pairs
from ecume.units import Array

FEW_CONTACTS = 2000
"""Fewer contacts are solved by every rank: messages would take longer."""


ENGINE = Option(
    slot="engine", path="--engine", name="--engine mpi",
    needs={
        "reciprocal": "each pair is summed once, by one rank",
        "shared": "each rank has the neighbors of a part of the floats only",
        "shared films": "each rank has the neighbors of a part of the floats only",
        "shared contacts": "ranks solve islands of contacts without friction",
    },
)  # fmt: skip


def require_spreadable(parameters: Parameters) -> None:
    """Raise BadInput for floats that cannot be distributed over ranks."""
    if faults := faults_with(ENGINE, parameters):
        raise BadInput("; ".join(fault.message for fault in faults))


class SharedPairs(NamedTuple):
    """`Superposed` floats, whose pairs are summed by all ranks."""

    law: Any
    share: Share


class SharedImpulses(NamedTuple):
    """`Impulses` that all ranks compute together."""

    overlapping: bool
    share: Share


class SharedRows(NamedTuple):
    """Neighbor lists, of which each rank has a part of the rows."""

    share: Share


def sum_shared(share: Share, law: Any, rows: Any, floats: Any, pair: Array, force: Array) -> None:
    """Compute the pair forces on all slots: the windows of some stretches on each rank, or all for few floats."""
    if force.shape[1] < THREADS_FROM:
        sum_in_parallel(law, rows, floats, pair, force)
        return
    edge, place, all_of = rows[5], rows[6], share.parts(STRETCHES)
    own = slice(all_of[share.rank], all_of[share.rank + 1] + 1)
    windows = np.zeros((2, place[STRETCHES]))
    sum_stretches(law, edge[own], place[own], rows, floats, pair, windows[0], windows[1])
    for along in windows:
        share.gather(along, place[all_of])
    add_windows(edge, place, windows, force)


def renew_shared(
    part: SharedRows, parts: Parts, scratch: Scratch, parameters: Parameters, reference: Array, workspace: Workspace
) -> bool:
    """Make lists and candidates at the reference positions; each rank makes and stores its part of the rows.
    False when there is no room. See `integration.renew_lists`.
    """
    share, lists, candidates = part.share, workspace.lists, workspace.candidates
    rows, count, rank = lists.rows, len(reference), share.rank
    if count < THREADS_FROM:
        return bool(renew_lists(EveryRow(), parts, scratch, parameters, reference, workspace))
    slots, all_of = share.parts(count), share.parts(STRETCHES)
    count_neighbors(lists, reference, parameters.reach, (slots[rank], slots[rank + 1]))
    share.gather(rows.first[1:], slots)
    share.gather(rows.later, slots)
    if not make_room(lists):
        return False
    write_neighbors(lists, parameters.reach, (all_of[rank], all_of[rank + 1]))
    share.gather(rows.place[1:], all_of)
    place_windows(rows.place)
    if not share_pairs(share, parameters, lists, candidates):
        lists.valid[0] = 0
        return False
    sort_parts(parts.interactions, scratch.interactions, parameters, lists)
    return True


def share_pairs(share: Share, parameters: Parameters, lists: NeighborLists, candidates: Candidates) -> bool:
    """Send the pairs that may touch, from the rows of each rank, to all ranks. False when there is no room."""
    edge, room = lists.rows.edge[share.parts(STRETCHES)], len(candidates.partner)
    own = edge[share.rank], edge[share.rank + 1]
    found = find_pairs(lists, own, parameters.floats.radius, parameters.skin, room)
    counts = np.zeros(share.ranks, np.int64)
    counts[share.rank] = len(found[0])
    share.gather(counts, np.arange(share.ranks + 1))
    bounds = np.concatenate([[0], np.cumsum(counts)])
    if bounds[-1] > room:
        return False
    pairs = np.empty((2, bounds[-1]), np.int64)
    for every, mine in zip(pairs, found, strict=True):
        every[bounds[share.rank] : bounds[share.rank + 1]] = mine
        share.gather(every, bounds)
    sort_pairs(candidates, *pairs)
    return True


def complete(share: Share, parameters: Parameters, state: State, workspace: Workspace) -> Workspace:
    """Return the workspace with the list rows of all ranks, for sums that one rank computes alone."""
    lists, all_of = workspace.lists, share.parts(STRETCHES)
    place = lists.rows.place.copy()
    sort_positions(lists, state.reference)
    for low, high in ((0, all_of[share.rank]), (all_of[share.rank + 1], STRETCHES)):
        write_neighbors(lists, parameters.reach, (low, high))
    lists.rows.place[:] = place
    sort_positions(lists, state.position)
    return workspace


def workspace_shared(share: Share, parameters: Parameters, state: State, room: float) -> Workspace:
    """See `ecume.models.model.Model.workspace`; every rank allocates all of it."""
    return workspace(parameters, state, room)


def shared_forces(
    part: SharedPairs, own: Sorted, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces on all floats: see `forces.superposed_forces`."""
    sum_shared(part.share, part.law, pairs_of(lists.rows), (own.charge, own.radius), own.pair, own.force)
    add_from_slots(lists.cells.order, own.force, force)
    add_wall_forces(parameters, position, force)


def sort_shared(part: SharedPairs, own: Sorted, parameters: Parameters, lists: NeighborLists) -> None:
    """Copy charges and radii into the order of the slots: see `forces.sort_floats`. Every rank has all of them."""
    sort_floats((), own, parameters, lists)


def solve_shared(
    part: SharedImpulses, own: Any, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Goal
) -> int:
    """Impulses of contacts: see `collisions.solve_smooth`. Each rank solves some of the islands."""
    share, mobility = part.share, bodies.mobility
    if contacts.total[0] < FEW_CONTACTS:
        return collisions.solve_smooth((), (), bodies, contacts, velocity, goal)
    touching.set_effective_masses(contacts, mobility)
    if projected_gauss_seidel.begin(contacts, velocity, mobility, goal):
        return 1
    islands = projected_gauss_seidel.islands_of(contacts, mobility)
    some = projected_gauss_seidel.contacts_of_rows(contacts, islands.rows)
    all_of = np.searchsorted(islands.first, share.parts(len(islands.rows)))
    own = islands.first[all_of[share.rank] : all_of[share.rank + 1] + 1]
    sweeps = np.zeros(share.ranks, np.int64)
    sweeps[share.rank] = projected_gauss_seidel.solve_islands(some, own, velocity, mobility, goal)
    share.gather(sweeps, np.arange(share.ranks + 1))
    share.gather(some.impulse, islands.first[all_of])
    share_velocities(share, some, islands.first[all_of], velocity)
    projected_gauss_seidel.scatter_impulses(contacts, islands.rows, some)
    return int(sweeps.max())


def push_shared(part: SharedImpulses, own: Any, bodies: Bodies, contacts: Contacts, midstep_velocity: Array) -> None:
    """Apply the impulses of collisions: see `collisions.push_smooth`. Every rank has all of them."""
    collisions.push_smooth((), (), bodies, contacts, midstep_velocity)


def share_velocities(share: Share, some: Contacts, bounds: Integers, velocity: Array) -> None:
    """Send the velocities of the bodies whose contacts each rank solved to all ranks. A body with contacts on two ranks
    is immovable.
    """
    owner = np.full(len(velocity), share.ranks)
    for rank in range(share.ranks):
        part = slice(bounds[rank], bounds[rank + 1])
        owner[some.first[part]], owner[some.second[part]] = rank, rank
    each = [np.flatnonzero(owner == rank) for rank in range(share.ranks)]
    bodies, ends = np.concatenate(each), np.cumsum([0, *map(len, each)])
    for axis in range(2):
        along = velocity[bodies, axis]
        share.gather(along, ends)
        velocity[bodies, axis] = along


interactions.BY_CONSTANTS[SharedPairs] = dataclasses.replace(
    interactions.INTERACTIONS["superposition"],
    constants=SharedPairs, add_forces=shared_forces, sort=sort_shared, compiled=False,
)  # fmt: skip

contact_models.BY_CONSTANTS[SharedImpulses] = dataclasses.replace(
    contact_models.CONTACTS["impulse"],
    constants=SharedImpulses,
    before_drift=collisions.collide_by_passes,
    after_drift=collisions.separate_by_passes,
    at_end=collisions.constrain_velocities_by_passes,
)

collisions.SOLVERS[SharedImpulses] = collisions.SMOOTH._replace(stop=solve_shared, push=push_shared, solve=solve_shared)

integration.LISTS[SharedRows] = renew_shared


def integrate_shared(share: Share, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """See `ecume.models.model.Model.advance`: the same steps, with parts that ranks share out."""
    parts = parameters.parts
    base, *others = parts.interactions
    touching = parts.contacts
    if isinstance(touching, collisions.Impulses):
        touching = SharedImpulses(touching.overlapping, share)
    shared = parts._replace(
        interactions=(SharedPairs(base.law, share), *others), contacts=touching, lists=SharedRows(share)
    )
    return integration.advance_with(shared, parameters, state, workspace, steps)
