"""A crowd on many ranks, which threads stand in for: the same bits as on one."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from ecume.engine.contact import projected_gauss_seidel
from ecume.engine.mpi_exchange import Share
from ecume.errors import BadInput
from ecume.models.floating import FLOATING, mpi
from ecume.models.floating.mpi import complete, integrate_shared, require_spreadable
from ecume.models.model import DONE
from ecume.run.ranks import SPREAD, spread_of
from ecume.scenes.load import load_scene

BOWL = """
model = "floating"
duration = "1 s"
frame_every = "20 ms"
seed = 5
[liquid]
density = 1000.0
viscosity = "1 mPa*s"
surface_tension = "72.8 mN/m"
[[particles]]
count = 20
radius = "1 mm"
density = 1200.0
contact_angle = "90 deg"
[dish]
radius = "1.2 cm"
contact_angle = "60 deg"
"""
STEPS = 40


class Meeting:
    """Where the ranks of a test meet."""

    def __init__(self, ranks: int) -> None:
        self.ranks, self.barrier = ranks, threading.Barrier(ranks, timeout=60.0)
        self.there: list[Any] = [None] * ranks

    def all_of(self, rank: int, mine: Any) -> list[Any]:
        """What everyone brought."""
        self.there[rank] = mine
        self.barrier.wait()
        brought = list(self.there)
        self.barrier.wait()
        return brought

    def share(self, rank: int) -> Share:
        """The part of one of them."""

        def gather(row: Any, bounds: Any) -> None:
            parts = self.all_of(rank, row[bounds[rank] : bounds[rank + 1]].copy())
            row[:] = np.concatenate(parts)

        return Share(rank, self.ranks, gather)


def on_ranks(ranks: int, work: Callable[[Share], Any]) -> list[Any]:
    """What each of them comes to."""
    meeting = Meeting(ranks)
    with ThreadPoolExecutor(ranks) as pool:
        return list(pool.map(lambda rank: work(meeting.share(rank)), range(ranks)))


def begun(*changes: str) -> tuple[Any, Any]:
    """Parameters and state of the bowl."""
    scene = load_scene(BOWL, list(changes))
    parameters = FLOATING.parameters(scene)
    return parameters, FLOATING.start(scene, parameters)


@pytest.fixture(autouse=True)
def _small_crowds_are_shared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mpi, "THREADS_FROM", 1)
    if os.environ.get("NUMBA_DISABLE_JIT") == "1":  # what is compiled keeps its constants
        monkeypatch.setattr(mpi, "FEW_CONTACTS", 1)
        monkeypatch.setattr(projected_gauss_seidel, "LEAST_FOR_ISLANDS", 1)


def copied(state: Any) -> Any:
    return state._replace(**{name: getattr(state, name).copy() for name in state._fields})


GRID = ("interaction.summation=grid", "interaction.accuracy=1e-2")
# With the JIT each part of the march is compiled by itself, which takes a minute: one case is enough there.
PLAIN_ONLY = pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") != "1", reason="tried as plain Python")


@pytest.mark.parametrize(
    ("ranks", "changes"),
    [
        (2, ()),
        pytest.param(3, (), marks=PLAIN_ONLY),
        *(pytest.param(each, GRID, marks=PLAIN_ONLY) for each in (2, 3)),
        *(pytest.param(2, (f"integration.integrator={each}",), marks=PLAIN_ONLY) for each in ("rk4", "stormer-verlet")),
    ],
)
def test_an_integration_on_ranks_is_that_of_one(ranks: int, changes: tuple[str, ...]) -> None:
    parameters, state = begun(*changes)
    start = copied(state)
    alone = FLOATING.workspace(parameters, state, 1.0)
    FLOATING.advance(parameters, state, alone, 0)
    force = alone.force.copy()
    assert FLOATING.advance(parameters, state, alone, STEPS) == DONE
    assert (state.reference != start.reference).any(), "the lists were never made anew"
    assert state.touches[0] > 0, "nobody touched"

    def integrate_here(share: Share) -> Any:
        own = copied(start)
        scratch = FLOATING.workspace(parameters, own, 1.0)
        integrate_shared(share, parameters, own, scratch, 0)
        first = scratch.force.copy()
        assert integrate_shared(share, parameters, own, scratch, STEPS) == DONE
        complete(share, parameters, own, scratch)
        assert np.array_equal(scratch.candidates.first, alone.candidates.first)
        return own, first, FLOATING.observe(parameters, own, scratch).numbers

    (one, _, seen), *_ = on_ranks(1, integrate_here)
    assert seen["pair_energy"] == pytest.approx(FLOATING.observe(parameters, state, alone).numbers["pair_energy"])
    for own, first, numbers in on_ranks(ranks, integrate_here):
        assert numbers == seen
        # A crowd this small is one stretch in one process: its sums have another order, in the last bits.
        assert np.abs(first - force).max() <= 1e-12 * np.abs(force).max()
        assert np.abs(own.position - state.position).max() < 1e-9 * parameters.floats.radius.min()
        for name in state._fields:
            assert np.array_equal(getattr(own, name), getattr(one, name)), name


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("interaction.method=multipole", "neighbors of a part of the floats only"),
        ("contacts.friction=0.2", "islands of contacts without friction"),
    ],
)
def test_what_is_not_spread_is_refused(change: str, message: str) -> None:
    parameters, _ = begun("particles[0].count=3", change)
    with pytest.raises(BadInput, match=message):
        require_spreadable(parameters)


@pytest.mark.parametrize("name", SPREAD)
def test_ranks_find_the_distribution_of_each_model(name):
    functions = ("require_spreadable", "workspace_shared", "integrate_shared", "complete")
    assert all(callable(getattr(spread_of(name), function)) for function in functions)
