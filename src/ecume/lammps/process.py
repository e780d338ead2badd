"""A running LAMMPS that receives its commands one after the other.

Commands go through its standard input, so that no script lies on a disk where it could be changed. After each group of
them LAMMPS prints a mark. Particles are written to a binary dump in a private folder, by the first rank, one rank after
the other, so that no rank needs memory for all of them.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from ecume.errors import BadInput, Diverged, EcumeError
from ecume.lammps.binary_dump import read_dump
from ecume.lammps.host import SCENE
from ecume.lammps.program import Program
from ecume.units import Array

DUMP = "particles.bin"
PATIENCE = 5.0
"""s, until a process that does not end by itself is killed."""

BLOWN_UP = ("lost atoms", "table inner cutoff", "non-numeric", "out of range atoms", "not a number", "nan")
"""Errors of LAMMPS, in lower case, about positions and forces; others are about its commands."""

MOST_LINES = 200
"""Lines of output that are kept for messages."""


class Lammps:
    """An open LAMMPS."""

    def __init__(self, program: Program, ranks: int, files: Mapping[str, str]) -> None:
        """Start LAMMPS in a private folder with these files; a scene among them is one whose forces it calls."""
        self._folder = tempfile.TemporaryDirectory(prefix="ecume-lammps-", ignore_cleanup_errors=True)
        self._count, self._lines = 0, [""]
        self.version = ""
        for name, text in files.items():
            (Path(self._folder.name) / name).write_text(text, encoding="utf-8")
        # A separate session: Ctrl-C reaches ecume only, which then fetches the state for a checkpoint.
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
        """Execute commands. Raises Diverged or EcumeError with the error of LAMMPS."""
        self._count += 1
        mark = f"ecume: done {self._count}"
        assert self._process.stdin is not None  # noqa: S101  # it is a pipe
        with contextlib.suppress(BrokenPipeError):  # the output of LAMMPS states why it ended
            self._process.stdin.write(f'{commands.rstrip()}\nprint "{mark}"\n')
            self._process.stdin.flush()
        self._await(mark)

    def particles(self, columns: Sequence[str], group: str = "all") -> Array:
        """These quantities of the particles of a group, in the order of their numbers from 1 on, one row each."""
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
        """End it; all of its ranks."""
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
        """The error with which LAMMPS ended."""
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
