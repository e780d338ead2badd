"""One run on many ranks: the first drives it, as any run is driven, and tells the others what to do.

Rank 0 has the run directory, its frames, checkpoints and signals. The others hold a copy of the state, and follow:
each is told to make a workspace, or to march by so many steps, and all do so together. What MPI is, is known here
only; it is an extra, and imported when a run asks for it.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import signal
import sys
import traceback
import zlib
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.errors import BadInput, EcumeError
from ecume.run.stopping import SIGNALS

if TYPE_CHECKING:
    from ecume.models.floating.spread import Share
    from ecume.models.model import Model

MARCH, WORKSPACE, END = range(3)
"""What followers are told."""


def world() -> Any:
    """All ranks. Raises BadInput where the extra is missing."""
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        raise BadInput(f"--engine mpi needs an extra, pip install 'ecume[mpi]' ({error})") from None
    return MPI.COMM_WORLD


def share_of(ranks: Any) -> Share:
    """The part of the rank that asks."""
    from ecume.models.floating.spread import Share

    def gather(row: Any, bounds: Any) -> None:
        from mpi4py import MPI

        kind = MPI.DOUBLE if row.dtype.kind == "f" else MPI.INT64_T
        ranks.Allgatherv(MPI.IN_PLACE, [row, np.diff(bounds), bounds[:-1], kind])

    return Share(ranks.rank, ranks.size, gather)


class Crew:
    """What a rank has of the common march: the same on all of them."""

    def __init__(self, ranks: Any) -> None:
        self.ranks, self.share = ranks, share_of(ranks)

    def workspace(self, parameters: Any, state: Any, room: float) -> Any:
        """See `ecume.models.model.Model.workspace`."""
        from ecume.models.floating.record import workspace

        return workspace(parameters, state, room)

    def advance(self, parameters: Any, state: Any, workspace: Any, steps: int) -> int:
        """See `ecume.models.model.Model.advance`; all ranks together."""
        from ecume.models.floating.spread import march_shared

        status = march_shared(self.share, parameters, state, workspace, steps)
        bits = zlib.crc32(state.velocity.tobytes(), zlib.crc32(state.position.tobytes()))
        if len(set(self.ranks.allgather((status, bits)))) > 1:
            raise EcumeError(
                f"before step {int(state.step[0])} the ranks came to different bits, so their machines are not of one "
                "kind; take machines of one kind, and go on with ecume resume"
            )
        return status


class Lead(Crew):
    """The first rank: each thing that all do together is told to the others first."""

    def engine(self, model: Model) -> Model:
        """The model whose march is done by all ranks. Raises BadInput for one that is not spread."""
        if model.name != "floating":
            raise BadInput(f"--engine mpi: goes with the model 'floating', and not with {model.name!r}")

        def observe(parameters: Any, state: Any, workspace: Any) -> Any:
            """See `Model.observe`: energies take all rows."""
            from ecume.models.floating.spread import complete_lists

            complete_lists(self.share, parameters, state, workspace)
            return model.observe(parameters, state, workspace)

        return dataclasses.replace(model, workspace=self.workspace, advance=self.advance, observe=observe)

    def workspace(self, parameters: Any, state: Any, room: float) -> Any:
        """See `Crew.workspace`."""
        from ecume.models.floating.spread import require_spreadable

        require_spreadable(parameters)
        with self._together(WORKSPACE, parameters, state, room):
            return super().workspace(parameters, state, room)

    def advance(self, parameters: Any, state: Any, workspace: Any, steps: int) -> int:
        """See `Crew.advance`."""
        with self._together(MARCH, steps):
            return super().advance(parameters, state, workspace, steps)

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
    """What makes of a model one whose march is done by all ranks; in the end they are told that it is over."""
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
    march: Callable[[int], int] | None = None
    while True:
        order, *what = ranks.bcast(None)
        if order == END:
            return
        if order == WORKSPACE:
            parameters, state, room = what
            march = functools.partial(crew.advance, parameters, state, crew.workspace(parameters, state, room))
        elif march is not None:
            with contextlib.suppress(EcumeError):  # the first rank has the same one, and tells it
                march(what[0])
