"""One crowd on many ranks: each sums the pair forces of its own part of the pairs, and does all else as if alone.

Everyone holds the whole state and the whole lists. The stretches that threads share (see `pulling`) are shared out in
unbroken runs; the windows that others filled are gathered, and all windows are added up in order, as in one process.
Kicks, drag, chance, contacts and walls are the same compiled code on the same numbers, so that everyone comes to the
same bits, which are those of a run without ranks. It is the replicated-data way [plimpton1995, sec. 3]: its limit is
what everyone does, not the messages.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import plainly
from ecume.engine.cells import Integers
from ecume.engine.neighbors import STRETCHES, THREADS_FROM, NeighborLists
from ecume.errors import BadInput
from ecume.models.floating import forces, grid
from ecume.models.floating.forces import Sorted, forces_with
from ecume.models.floating.parameters import ONE_SIDED, RARE, SCHEMES, Parameters
from ecume.models.floating.pulling import add_windows
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.stepping import march_in_parts
from ecume.models.floating.summing import Split
from ecume.units import Array

Pull = Callable[..., None]


class Share(NamedTuple):
    """Which of the ranks this is, and how it speaks with the others."""

    rank: int
    ranks: int
    gather: Callable[[Array, Integers], None]
    """gather(row, bounds): fill in the others' parts of a row; part k reaches from bounds[k] up to bounds[k + 1]"""


def require_spreadable(parameters: Parameters) -> None:
    """Raise BadInput for what is not spread over ranks."""
    if parameters.many != () and not isinstance(parameters.many, Split):
        raise BadInput("--engine mpi: goes with superposed menisci of smooth round floats, without dipoles or films")
    if parameters.rough != () or parameters.springs != ():
        raise BadInput("--engine mpi: goes without friction between floats, and with contacts that are no springs")
    if parameters.pair_law == ONE_SIDED or parameters.scheme in RARE:
        rare = ", ".join(repr(SCHEMES[each]) for each in RARE)
        raise BadInput(f"--engine mpi: goes with symmetric pair laws, and with integrators other than {rare}")


def pull_shared(share: Share, alone: Pull, together: Pull, rows: Any, floats: Any, pair: Array, force: Array) -> None:
    """Pair forces on all slots; `together` fills the windows of some stretches, `alone` does all of a small crowd."""
    if force.shape[1] < THREADS_FROM:
        alone(rows, floats, pair, force)
        return
    edge, place = rows[5], rows[6]
    mine = np.arange(share.ranks + 1) * STRETCHES // share.ranks
    own = slice(mine[share.rank], mine[share.rank + 1] + 1)
    windows = np.zeros((2, place[STRETCHES]))
    together(edge[own], place[own], rows, floats, pair, windows[0], windows[1])
    for along in windows:
        share.gather(along, place[mine])
    add_windows(edge, place, windows, force)


def shared_forces(
    pull_all: Pull,
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    scratch: tuple[Sorted, Array],
) -> None:
    """The forces on all floats."""
    plainly(forces_with)(pull_all, parameters, position, lists, scratch)


def march_shared(share: Share, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """March: see `ecume.models.model.Model.advance`."""
    law: Any = grid if isinstance(parameters.many, Split) else forces
    alone = grid.pull_short if law is grid else forces.pull
    evaluate = functools.partial(shared_forces, functools.partial(pull_shared, share, alone, law._pull_in_threads))
    if law is grid:
        return grid.march_split_with(evaluate, parameters, state, workspace, steps)
    return march_in_parts(evaluate, parameters, state, workspace, steps)
