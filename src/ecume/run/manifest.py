"""The manifest of a run: the programs, the machine and the sessions that made it."""

from __future__ import annotations

import datetime
import functools
import hashlib
import importlib.metadata
import os
import platform
import socket
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecume._plain_files import opened
from ecume._version import __version__
from ecume.run.directory import RunDirectory, identity_of, manifest_of, write
from ecume.trajectories.records import clean, storing
from ecume.trajectories.segments import segment_files

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

PROGRAMS = ("numpy", "numba", "llvmlite", "scipy", "pydantic")
FORMAT = 3
"""The format of runs: since format 2, records and lines of numbers have checksums; since 3 these include the identity
of the run, and samples have checksums, too.
"""
SETTINGS = ("OPENBLAS_CORETYPE", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "GLIBC_TUNABLES")
"""Environment variables that make libraries compute as on another processor."""


def now() -> str:
    """The present time in UTC."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")


def circumstances() -> dict[str, Any]:
    """The versions, and the properties of the machine, that can change bits of a result."""
    return {
        "ecume": __version__,
        "python": platform.python_version(),
        **{name: _version(name) for name in PROGRAMS},
        "platform": clean(" ".join((platform.system(), platform.machine(), *platform.libc_ver())).strip()),
        "processor": clean(_processor()),
        "vector instructions": _vector_instructions(),
        **{name: clean(os.environ[name]) for name in SETTINGS if name in os.environ},
    }


def first_manifest(scene: Scene, source: bytes, plain: str) -> dict[str, Any]:
    """The manifest of a run that has not started; `source` is its scene file, and `plain` its resolved scene."""
    return {
        "format": FORMAT,
        **circumstances(),
        "model": scene.model,
        "seed": getattr(scene, "seed", None),
        "source_sha256": hashlib.sha256(source).hexdigest(),
        "scene_sha256": hashlib.sha256(plain.encode()).hexdigest(),
        **flow_file(scene),
        "cores": os.cpu_count(),
        "sessions": [],
    }


def flow_file(scene: Scene) -> dict[str, str]:
    """The digest of the file with the velocities of the liquid, if the scene names one."""
    field = getattr(getattr(scene, "flow", None), "field", None)
    return {} if field is None else {FLOW_FILE: flow_digest(field.file)}


def flow_digest(name: str) -> str:
    """The digest of a file, or a run, with the velocities of the liquid."""
    total = hashlib.sha256()
    for each in _flow_files(Path(name)):
        with storing(each), each.open("rb") as file:
            hashlib.file_digest(file, lambda: total)
    return total.hexdigest()


def _flow_files(path: Path) -> Sequence[Path]:
    """The files that determine the velocities: for a run the file that marks its end, or else its present frames."""
    if not path.is_dir():
        return [path]
    done, frames = path / "DONE.json", path / "traj"
    return [done] if done.exists() else segment_files(frames if frames.is_dir() else path)


FLOW_FILE = "flow_sha256"


def changed(former: Mapping[str, Any]) -> list[str]:
    """The versions and the processor that differ from those in a manifest or in one of its sessions."""
    today = circumstances()
    names = [name for name in today if name in former] + [
        name for name in SETTINGS if (name in former) != (name in today)
    ]
    return [f"{name} {former.get(name)} -> {today.get(name)}" for name in names if former.get(name) != today.get(name)]


def open_session(home: RunDirectory, threads: int, step: int, frames: int) -> None:
    """Record that a process starts to work on the run, with this number of frames on disk."""
    manifest = manifest_of(home)
    session = {
        "pid": os.getpid(),
        "host": clean(socket.gethostname()),
        "threads": threads,
        "began": now(),
        "from_step": step,
        "first_frame": frames,
        "circumstances": circumstances(),
    }
    manifest["sessions"] = [*manifest.get("sessions", []), session]
    write(home, home.manifest, manifest)


def circumstances_of_frame(home: RunDirectory, frame: int) -> dict[str, Any]:
    """The versions and the processor with which a frame on disk was computed.

    Each session records the first frame that it wrote. A frame was written by the last session whose first frame is not
    after it. The present session has not written the frames that it finds on disk.
    """
    manifest = manifest_of(home)
    for session in reversed(manifest.get("sessions", [])[:-1]):
        if "circumstances" not in session:
            break
        if session["first_frame"] <= frame:
            return dict(session["circumstances"])
    return manifest


def record(home: RunDirectory, **facts: Any) -> None:
    """Record facts about the present session: the `first_frame` that it writes, and the frames that it `replaced`."""
    manifest = manifest_of(home)
    manifest["sessions"][-1] |= facts
    write(home, home.manifest, manifest)


def close_session(home: RunDirectory, outcome: str, step: int, seconds: float) -> None:
    """Record the outcome of the session."""
    manifest = manifest_of(home)
    ending = {"ended": now(), "to_step": step, "seconds": round(seconds, 3), "outcome": outcome}
    manifest["sessions"][-1] |= ending
    write(home, home.manifest, manifest)


def digests(home: RunDirectory) -> dict[str, str]:
    """The SHA-256 of each file that will not change again."""
    from concurrent.futures import ThreadPoolExecutor  # slow to import, and not needed by `ecume info`

    folders = (home.trajectory, home.checkpoints)
    files = [
        home.scene,
        home.resolved,
        home.constants,
        home.scalars,
        home.samples,
        home.sums,
        *((home.watch,) if identity_of(home) else ()),
        *(path for folder in folders for path in folder.glob("*")),
    ]
    files = [path for path in sorted(files) if path.is_file()]
    # A disk is faster than the computation of digests by one processor.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(functools.partial(digest, home), files)
        return {path.relative_to(home.path).as_posix(): one for path, one in zip(files, found, strict=True)}


def digest(home: RunDirectory, path: Path) -> str:
    """The SHA-256 of a file of a run."""
    with storing(path), opened(path, "r", home.path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _version(program: str) -> str | None:
    try:
        return importlib.metadata.version(program)
    except importlib.metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    """The name, family and model of the processor; on Linux they are read from files that the platform module ignores.

    Virtual machines use one name for processors of several generations, so that the name alone is not sufficient.
    """
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    first = {name.strip(): value.strip() for name, _, value in (line.partition(":") for line in reversed(lines))}
    if "model name" not in first:
        return platform.processor()
    return f"{first['model name']} (family {first.get('cpu family')}, model {first.get('model')})"


def _vector_instructions() -> str:
    """The optional instruction sets that NumPy found on this processor and may use."""
    import numpy as np

    configuration: Any = np.show_config(mode="dicts")
    return " ".join(configuration.get("SIMD Extensions", {}).get("found", []))


RUN, ECUME = "#run", "#ecume"
