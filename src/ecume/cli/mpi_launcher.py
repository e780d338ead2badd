"""The start of MPI ranks, unless a launcher has started them already."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume._extras import install
from ecume.errors import BadInput

if TYPE_CHECKING:
    from ecume.models.model import Model

ENGINES = ("local", "mpi")
LAUNCHED = ("PMI_SIZE", "PMIX_RANK", "OMPI_COMM_WORLD_SIZE")
"""Environment variables that launchers, ecume's and those of clusters, set for their ranks."""
QUIET = {"MPIR_CVAR_CH4_NETMOD": "ucx", "UCX_TLS": "self,posix,sysv"}
"""Ranks of one machine speak through its memory, and listen on no network."""

Engine = Annotated[
    str,
    typer.Option(
        "--engine", metavar="local|mpi", help="Integrate in this process, or on several MPI ranks (extra `mpi`)."
    ),
]
Ranks = Annotated[
    int | None,
    typer.Option(
        "--ranks",
        min=1,
        max=256,
        metavar="N",
        help="Number of MPI ranks on this machine; default: 2. The result does not depend on it.",
        show_default=False,
    ),
]


@contextlib.contextmanager
def integrating(engine: str, ranks: int | None) -> Iterator[Callable[[Model], Model] | None]:
    """The function that integrates a model with the selected engine.

    Does not return in a process that only starts ranks, nor in a rank beside the first.
    """
    if engine not in ENGINES:
        raise BadInput(f"--engine: got {engine!r}; expected one of {', '.join(ENGINES)}")
    if engine == "local":
        if ranks is not None:
            raise BadInput("--ranks goes with --engine mpi")
        yield None
        return
    if not any(name in os.environ for name in LAUNCHED):
        raise typer.Exit(launched(2 if ranks is None else ranks))
    from ecume.run.ranks import follow, leading, world

    ranks_of_run = world()
    if ranks_of_run.rank > 0:
        follow(ranks_of_run)
        raise typer.Exit
    if ranks not in (None, ranks_of_run.size):
        warnings.warn(f"--ranks {ranks}: the launcher started {ranks_of_run.size}", stacklevel=1)
    with leading(ranks_of_run) as led:
        yield led


def launched(ranks: int) -> int:
    """Do this process's command over with so many ranks; the exit code of the first."""
    command = [str(launcher()), "-n", str(ranks), sys.executable, "-m", "ecume", *sys.argv[1:]]
    threads = str(max(1, (os.cpu_count() or 1) // ranks))
    environment = {"NUMBA_NUM_THREADS": threads, **os.environ, **QUIET}
    # A session of their own: Ctrl-C reaches them through us, once, and the launcher not at all.
    started = subprocess.Popen(command, env=environment, start_new_session=True)  # noqa: S603  # a command of ecume
    with started, handing_on(started):
        return started.wait()


def launcher() -> Path:
    """The program that starts ranks on this machine, and opens no port for it. Raises BadInput where it is missing."""
    found = Path(sys.executable).parent / "mpiexec.gforker"
    if importlib.util.find_spec("mpi4py") is None or not found.exists():
        raise BadInput(f"--engine mpi needs more packages: {install('mpi')}")
    return found


@contextlib.contextmanager
def handing_on(started: subprocess.Popen[bytes]) -> Iterator[None]:
    """Signals go to the ranks, of which the first hears them."""
    import psutil

    from ecume.run.stop_requests import handled

    def hand_on(number: int, _: Any) -> None:
        with contextlib.suppress(psutil.NoSuchProcess):
            for rank in psutil.Process(started.pid).children():
                rank.send_signal(number)

    with handled(hand_on):
        yield
