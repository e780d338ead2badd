"""One run on many ranks: the first controls it like any run, and sends commands to the others.

Rank 0 has the run directory, its frames, checkpoints and signals. The others hold a copy of the state, and follow:
each command makes a workspace or advances by a number of steps, on all ranks together. Only this module depends on
MPI; it is an extra, and imported when a run uses it.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import importlib
import signal
import sys
import traceback
import zlib
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume._extras import install
from ecume.errors import BadInput, EcumeError
from ecume.run.stop_requests import SIGNALS

if TYPE_CHECKING:
    from ecume.engine.mpi_exchange import Share
    from ecume.models.model import Model

MARCH, WORKSPACE, END = range(3)
"""Commands to the other ranks."""
SPREAD = ("floating", "sph")
"""Models that are."""


def world() -> Any:
    """The communicator of all ranks. Raises BadInput where the extra is missing."""
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        raise BadInput(f"--engine mpi needs more packages: {install('mpi')} ({error})") from None
    return MPI.COMM_WORLD


def share_of(ranks: Any) -> Share:
    """The part of the rank that asks."""
    from mpi4py import MPI

    from ecume.engine.mpi_exchange import Share

    kinds = {"d": MPI.DOUBLE, "f": MPI.FLOAT, "l": MPI.INT64_T, "q": MPI.INT64_T}

    def gather(row: Any, bounds: Any) -> None:
        ranks.Allgatherv(MPI.IN_PLACE, [row, np.diff(bounds), bounds[:-1], kinds[row.dtype.char]])

    return Share(ranks.rank, ranks.size, gather)


def spread_of(name: str) -> Any:
    """The distribution of a model over ranks. Raises BadInput for a model without one."""
    if name not in SPREAD:
        raise BadInput(f"--engine mpi: goes with the models {' and '.join(map(repr, SPREAD))}, and not with {name!r}")
    return importlib.import_module(f"ecume.models.{name}.mpi")


class Crew:
    """The data of the common integration on a rank: the same on all of them."""

    def __init__(self, ranks: Any) -> None:
        self.ranks, self.share = ranks, share_of(ranks)

    def workspace(self, name: str, parameters: Any, state: Any, room: float) -> Any:
        """See `ecume.models.model.Model.workspace`."""
        return spread_of(name).workspace_shared(self.share, parameters, state, room)

    def advance(self, name: str, parameters: Any, state: Any, workspace: Any, steps: int) -> int:
        """See `ecume.models.model.Model.advance`; all ranks together."""
        status: int = spread_of(name).integrate_shared(self.share, parameters, state, workspace, steps)
        bits = zlib.crc32(state.velocity.tobytes(), zlib.crc32(state.position.tobytes()))
        if len(set(self.ranks.allgather((status, bits)))) > 1:
            raise EcumeError(
                f"before step {int(state.step[0])} the ranks computed different bits, so their machines are not of one "
                "kind; take machines of one kind, and go on with ecume resume"
            )
        return status


class Lead(Crew):
    """The first rank: it sends each common command to the others first."""

    def engine(self, model: Model) -> Model:
        """The model that all ranks integrate together. Raises BadInput for a model without MPI."""
        spread = spread_of(model.name)

        def observe(parameters: Any, state: Any, workspace: Any) -> Any:
            return model.observe(parameters, state, spread.complete(self.share, parameters, state, workspace))

        return dataclasses.replace(
            model,
            workspace=functools.partial(self.workspace, model.name),
            advance=functools.partial(self.advance, model.name),
            observe=observe,
        )

    def workspace(self, name: str, parameters: Any, state: Any, room: float) -> Any:
        """See `Crew.workspace`."""
        spread_of(name).require_spreadable(parameters)
        with self._together(WORKSPACE, name, parameters, state, room):
            return super().workspace(name, parameters, state, room)

    def advance(self, name: str, parameters: Any, state: Any, workspace: Any, steps: int) -> int:
        """See `Crew.advance`."""
        with self._together(MARCH, steps):
            return super().advance(name, parameters, state, workspace, steps)

    def end(self) -> None:
        """Let the others go."""
        self.ranks.bcast((END,))

    @contextlib.contextmanager
    def _together(self, *order: Any) -> Iterator[None]:
        self.ranks.bcast(order)
        try:
            yield
        except EcumeError:  # all have the same one
            raise
        except BaseException as error:  # out of step with the others, who wait for what will not come
            if not isinstance(error, KeyboardInterrupt):
                traceback.print_exception(error)
            self.ranks.Abort(1)
            raise


@contextlib.contextmanager
def leading(ranks: Any) -> Iterator[Callable[[Model], Model]]:
    """The function that makes a model integrate on all ranks; in the end the other ranks are released."""
    lead = Lead(ranks)
    try:
        yield lead.engine
    finally:
        lead.end()


def follow(ranks: Any) -> None:
    """Do what the first rank says, until it is over."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)  # who drives the run hears them
    try:
        _follow(ranks)
    except BaseException as error:
        traceback.print_exception(error)
        sys.stderr.flush()
        ranks.Abort(1)


def _follow(ranks: Any) -> None:
    crew = Crew(ranks)
    integrate: Callable[[int], int] | None = None
    while True:
        order, *what = ranks.bcast(None)
        if order == END:
            return
        if order == WORKSPACE:
            name, parameters, state, room = what
            made = crew.workspace(name, parameters, state, room)
            integrate = functools.partial(crew.advance, name, parameters, state, made)
        elif integrate is not None:
            with contextlib.suppress(EcumeError):  # the first rank has the same one, and reports it
                integrate(what[0])
