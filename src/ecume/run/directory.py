"""The directory of a run: the paths of its files, and whether it belongs to ecume."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ecume._plain_files import content_of, require_plain
from ecume.errors import BadInput, RunExists, StorageError
from ecume.trajectories import samples
from ecume.trajectories.records import MOST_BYTES, Check, manifest_at, record_at, storing, write_record

MOST_NAMED = 5
"""The number of runs that a message lists if the user named none."""


@dataclass(frozen=True)
class RunDirectory:
    """The paths of the files of a run."""

    path: Path

    @property
    def scene(self) -> Path:
        """The scene file of the user, byte for byte."""
        return self.path / "scene.toml"

    @property
    def resolved(self) -> Path:
        """The scene with all defaults filled in."""
        return self.path / "resolved.json"

    @property
    def constants(self) -> Path:
        """The constants that the model derived from the scene when the run began: charges, tables, time step."""
        return self.path / "constants.npz"

    @property
    def manifest(self) -> Path:
        """The versions, the machine and the sessions of the run."""
        return self.path / "manifest.json"

    @property
    def lock(self) -> Path:
        """The lock, held by the process that writes."""
        return self.path / "lock"

    @property
    def checkpoints(self) -> Path:
        """The newest two states."""
        return self.path / "ckpt"

    @property
    def trajectory(self) -> Path:
        """The folder of the frames."""
        return self.path / "traj"

    @property
    def scalars(self) -> Path:
        """The numbers of each frame, one line per frame."""
        return self.path / "scalars.jsonl"

    @property
    def samples(self) -> Path:
        """The numbers sampled between frames, a line per block; only if the scene has samples."""
        return self.path / samples.FILE

    @property
    def sums(self) -> Path:
        """The checksums of the samples: for each frame, that of the table up to there."""
        return self.path / samples.SUMS

    @property
    def crate(self) -> Path:
        """The metadata of the run as a research object; only if they were exported."""
        return self.path / "ro-crate-metadata.json"

    @property
    def log(self) -> Path:
        """The log: a line for each event."""
        return self.path / "log.jsonl"

    @property
    def status(self) -> Path:
        """The progress of the run."""
        return self.path / "status.json"

    @property
    def watch(self) -> Path:
        """The invariants of the run, and whether they hold so far."""
        return self.path / "watch.json"

    @property
    def done(self) -> Path:
        """The marker of a run that was completed."""
        return self.path / "DONE.json"

    @property
    def failed(self) -> Path:
        """The marker of a run whose physics failed."""
        return self.path / "FAILED.json"

    def parts(self) -> list[Path]:
        """All files of a run except the lock, in the order in which they are removed: the manifest last."""
        contents = [self.trajectory, self.checkpoints, self.scalars, self.samples, self.log, self.status, self.watch]
        contents.append(self.sums)
        return [*contents, self.crate, self.done, self.failed, self.scene, self.resolved, self.constants, self.manifest]


def existing(path: str | os.PathLike[str]) -> RunDirectory:
    """The directory of a run that was started. Raises BadInput if it does not exist, and StorageError if it contains
    anything but plain files and folders.
    """
    home = RunDirectory(Path(path))
    if home.path.is_dir():
        with storing(home.path):
            require_plain(home.path)
    if not home.manifest.is_file():
        where = "the current directory holds no run" if home.path == Path() else f"{path}: contains no run"
        raise BadInput(f"{where}; {_way_out(home)}")
    return home


def _way_out(home: RunDirectory) -> str:
    """A hint for a path that does not contain a run."""
    if not home.path.is_dir():
        scene = home.path.suffix == ".toml" and home.path.is_file()
        return (
            "that is a scene; expected the directory of its run" if scene else "expected a directory from `ecume run`"
        )
    if is_run_directory(home):
        if any(home.trajectory.glob("*")):
            return "its manifest.json is gone: put it back from a copy; ecume.open_trajectory still reads its frames"
        return "it was killed before it began: run it again with --force"
    found = [path.parent for pattern in ("*", "runs/*") for path in home.path.glob(f"{pattern}/manifest.json")]
    if not found:
        return "name the directory of one, as in runs/bowl"
    return f"there is {', '.join(map(str, sorted(found)[:MOST_NAMED]))}{', ...' if len(found) > MOST_NAMED else ''}"


def is_run_directory(home: RunDirectory) -> bool:
    """Whether `ecume run` created this directory: it contains a manifest, or only files that are written before it,
    including a lock.
    """
    if home.manifest.is_file():
        with storing(home.manifest):
            return b'"ecume"' in content_of(home.manifest, MOST_BYTES, home.path)
    found = {entry.name.removesuffix(".part") for entry in home.path.iterdir()}
    return _is_locked_once(home) and found <= {part.name for part in (*home.parts(), home.lock)}


def _is_locked_once(home: RunDirectory) -> bool:
    """Whether the lock in a directory is ecume's: it contains the number of a process, or is empty because the process
    ended before.
    """
    try:
        return content_of(home.lock, MOST_BYTES, home.path)[:6] in (b"", b'{"pid"')
    except PermissionError:  # on Windows, while another process has the file open
        return True
    except OSError:
        return False


def refuse_existing(home: RunDirectory, *, force: bool) -> None:
    """Raise RunExists if anything exists where a new run would be written."""
    path = home.path
    if not path.exists() or _is_vacant(home):
        return
    if not path.is_dir() or not is_run_directory(home):
        raise RunExists(f"{path}: exists and is not a run directory; choose another name")
    with storing(path):
        require_plain(path)
    if not force:
        hint = f"continue it (`ecume resume {path}`), choose another name, or replace it with --force"
        raise RunExists(f"{path}: holds a run already; {hint}")


def _is_vacant(home: RunDirectory) -> bool:
    """Whether the directory does not exist, or is empty except for a lock of ecume."""
    found = {entry.name for entry in home.path.iterdir()} if home.path.is_dir() else {"a file"}
    return not found or (found == {home.lock.name} and _is_locked_once(home))


def clear(home: RunDirectory) -> None:
    """Remove the files of a run from its directory, and no others."""
    for part in [path.with_name(f"{path.name}.part") for path in home.parts()] + home.parts():
        with storing(part):
            if part.is_dir() and not part.is_symlink():
                shutil.rmtree(part)
            else:
                part.unlink(missing_ok=True)


def sweep(home: RunDirectory) -> None:
    """Remove incomplete files of a process that was killed."""
    for folder in (home.checkpoints, home.trajectory):
        for part in folder.glob("*.part"):
            with storing(part):
                part.unlink()


def manifest_of(home: RunDirectory) -> dict[str, Any]:
    """The manifest of a run. Raises StorageError if it is damaged."""
    return manifest_at(home.path)


def has_checksums(home: RunDirectory) -> bool:
    """Whether the records of this run have checksums: those of earlier versions have none."""
    try:
        return "format" in manifest_of(home)
    except StorageError:  # damaged, or not written yet
        return home.manifest.exists()


def identity_of(home: RunDirectory) -> str:
    """The identity of the run, which is part of the checksums of its files; empty for runs of earlier versions, and if
    it is unknown.
    """
    try:
        return str(manifest_of(home).get("run", ""))
    except StorageError:  # damaged, which is reported when the file is read, or not written yet
        return ""


def owner_of(home: RunDirectory, path: Path) -> str:
    """The owner of the checksums in a file: see `sealed`."""
    run = identity_of(home)
    return f"{run} {path.name}" if run else ""


def read(home: RunDirectory, path: Path, check: Check) -> dict[str, Any]:
    """The content of a record of a run. Raises StorageError if it is damaged, or not of this kind."""
    return record_at(path, check, home.path, checked=has_checksums(home), owner=owner_of(home, path))


def write(home: RunDirectory, path: Path, plain: dict[str, Any], *, settled: bool = True) -> None:
    """Replace one of the records of a run."""
    owner = "" if path == home.manifest else owner_of(home, path)
    write_record(path, plain, home.path, owner=owner, settled=settled)
