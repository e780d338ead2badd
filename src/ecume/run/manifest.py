"""With which programs and on which machine a run was made."""

from __future__ import annotations

import datetime
import hashlib
import importlib.metadata
import os
import platform
import socket
from pathlib import Path
from typing import Any

import ecume
from ecume.run.directory import RunDirectory, json_of, write_json
from ecume.trajectories.durable import storing

PROGRAMS = ("numpy", "numba", "llvmlite", "scipy", "pydantic")


def now() -> str:
    """The wall clock, in the world's time."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")


def circumstances() -> dict[str, Any]:
    """What can change a bit of a result: versions, and the machine."""
    return {
        "ecume": ecume.__version__,
        "python": platform.python_version(),
        **{name: _version(name) for name in PROGRAMS},
        "platform": platform.platform(),
        "processor": _processor(),
    }


def first_manifest(scene: Any, plain: str) -> dict[str, Any]:
    """What is known of a run before it begins."""
    return {
        **circumstances(),
        "model": scene.model,
        "seed": getattr(scene, "seed", None),
        "scene_sha256": hashlib.sha256(plain.encode()).hexdigest(),
        "cores": os.cpu_count(),
        "sessions": [],
    }


def changed(manifest: dict[str, Any]) -> list[str]:
    """What is not as it was when the run began."""
    today = [(name, manifest.get(name), value) for name, value in circumstances().items()]
    return [f"{name} {before} is now {value}" for name, before, value in today if before != value]


def open_session(home: RunDirectory, threads: int, step: int) -> None:
    """Note that a process begins to work on the run."""
    manifest = json_of(home.manifest)
    session = {"pid": os.getpid(), "host": socket.gethostname(), "threads": threads, "began": now(), "from_step": step}
    manifest["sessions"] = [*manifest.get("sessions", []), session]
    write_json(home.manifest, manifest)


def close_session(home: RunDirectory, outcome: str, step: int, seconds: float) -> None:
    """Note how the work ended."""
    manifest = json_of(home.manifest)
    ending = {"ended": now(), "to_step": step, "seconds": round(seconds, 3), "outcome": outcome}
    manifest["sessions"][-1] |= ending
    write_json(home.manifest, manifest)


def digests(home: RunDirectory) -> dict[str, str]:
    """The SHA-256 of each file that will not change any more."""
    folders = (home.trajectory, home.checkpoints)
    files = [home.scene, home.resolved, home.scalars, *(path for folder in folders for path in folder.glob("*"))]
    return {path.relative_to(home.path).as_posix(): _digest(path) for path in sorted(files) if path.is_file()}


def _digest(path: Path) -> str:
    with storing(path), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _version(program: str) -> str | None:
    try:
        return importlib.metadata.version(program)
    except importlib.metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    """The model of the processor; Linux keeps it where the platform module does not look."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
