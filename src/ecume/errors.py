"""The classes of errors, each with its exit code. Messages give the place, the value, what is expected, and the cure.

EcumeError
├── BadInput            exit 2   a scene, a table or an argument cannot be used
│   ├── SceneError               all faults of a scene at once, each with its path
│   ├── FloaterSinks             no equilibrium: the body is too heavy for the surface
│   └── RunExists                a run directory is in the way
├── Diverged            exit 3   the physics left the range where it means anything
├── StorageError        exit 4   disk full, unreadable or damaged files
└── Stopped             exit 75  stopped on request, with a checkpoint

`install` is the remedy if a package of an extra is missing, `beside_ecume` if a separate package of ecume is missing.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple


class EcumeError(Exception):
    """The base of all errors that ecume reports; `exit_code` is the exit code of the command line."""

    exit_code = 1


class BadInput(EcumeError, ValueError):
    """A request that cannot be fulfilled."""

    exit_code = 2


class Fault(NamedTuple):
    """One fault of a scene: its path (`particles[0].radius`), the message with the remedy, and its position in the
    file.
    """

    path: str
    message: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = f"line {self.line}, column {self.column}: " if self.line is not None else ""
        return f"{place}{self.path}: {self.message}" if self.path else f"{place}{self.message}"


class SceneError(BadInput):
    """The faults of a scene, all at once."""

    def __init__(self, faults: Sequence[Fault], source: str = "scene") -> None:
        self.faults = tuple(faults)
        self.source = source
        super().__init__("\n".join(f"{source}: {fault}" for fault in self.faults))


class FloaterSinks(BadInput):
    """The surface cannot support this body: its density ratio is above the sinking limit."""


class RunExists(BadInput):
    """A run directory is in the way, or is used by another process."""


class Diverged(EcumeError):
    """The state left the range of validity; the message contains the time, the particle and the remedy."""

    exit_code = 3


class StorageError(EcumeError):
    """Files that cannot be written, or cannot be read."""

    exit_code = 4


class Stopped(EcumeError):
    """Stopped on request; a checkpoint was written."""

    exit_code = 75


def nearest(word: str, known: Sequence[str]) -> str:
    """Advice on an unknown word: the most similar known word, or all known words.

    >>> nearest("watr", ["water", "ethanol"]), nearest("x", ["water", "ethanol"])
    ('did you mean water?', 'known: water, ethanol')
    >>> nearest("cold milk", ["milk", "olive oil"])
    'did you mean milk?'
    >>> nearest("top_force", ["top", "top_force_x"])
    'did you mean top_force_x?'
    """
    given = word.lower()
    parts = [name for name in known if name in re.findall(r"[^\W_]+", given)]
    near = difflib.get_close_matches(given, known, n=3, cutoff=0.7) or parts
    near = near or difflib.get_close_matches(given, known, n=3, cutoff=0.5)
    if near:
        swapped = [name for name in near if sorted(name) == sorted(given)]
        return f"did you mean {(swapped or near)[0]}?"
    return f"known: {', '.join(known)}" if known else "expected nothing here"


OF_AN_EXTRA = re.compile(r"^(?P<package>[^;]+);.*\bextra == ['\"](?P<extra>[a-z]+)['\"]")


def install(extra: str) -> str:
    """The command that installs the packages of an extra: `pip install 'pandas>=2.2'`."""
    from importlib.metadata import PackageNotFoundError, requires  # not needed by `ecume --help`

    try:
        found = [OF_AN_EXTRA.match(line) for line in requires("ecume") or ()]
    except PackageNotFoundError:  # used from a source folder, without an installation
        found = []
    packages = [match["package"].strip() for match in found if match and match["extra"] == extra]
    return f"pip install {' '.join(map(repr, packages))}" if packages else f"pip install '.[{extra}]' in the sources"


BESIDE = {
    "ecume_lammps": ("decks and runs in LAMMPS", "packaging/lammps"),
    "ecume_validation": ("the cases of `ecume validate`", "packaging/validation"),
}
"""Our packages that are installed separately: their content, and their folder in the sources."""


@contextmanager
def beside_ecume() -> Iterator[None]:
    """A context for importing the separate packages of ecume. Raises BadInput if they are not installed."""
    try:
        yield
    except ModuleNotFoundError as missing:
        package = (missing.name or "").partition(".")[0]
        if package not in BESIDE:
            raise
        content, folder = BESIDE[package]
        raise BadInput(
            f"the package with {content} is not installed; install it in the folder of the sources: "
            f"pip install ./{folder}"
        ) from None
