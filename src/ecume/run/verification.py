"""Verification of a run, which compares every file with checksums and reports faults; and repair.

A completed run is compared with the digests in `DONE.json`. Of any other run, records, lines, checkpoints and frames
are compared with their own checksums. `deep` computes all frames again and compares bits.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume.errors import BadInput, EcumeError, StorageError
from ecume.models.model import LOCAL, Engine
from ecume.run import checkpoints, constants, lock
from ecume.run.checkpoints import set_aside
from ecume.run.comparison import difference
from ecume.run.constants import is_sound
from ecume.run.directory import (
    RunDirectory,
    existing,
    has_checksums,
    identity_of,
    manifest_of,
    owner_of,
    read,
    write,
)
from ecume.run.manifest import FLOW_FILE, changed, digest, digests, flow_file
from ecume.run.scalars import lines_of, split
from ecume.run.selection import selection_of
from ecume.run.user_code import Law, UserCode, require_same
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.records import (
    DONE,
    FAILED,
    STATUS,
    WATCH,
    anything,
    as_json,
    line_of,
    record_at,
    resolved_at,
    scene_at,
    storing,
    table,
    write_whole,
)
from ecume.trajectories.samples import rows_of
from ecume.trajectories.segments import Repaired, set_foreign_aside
from ecume.trajectories.segments import check as check_trajectory
from ecume.trajectories.segments import repair as repair_trajectory

if TYPE_CHECKING:
    from ecume.models.actions import Action


def repaired(home: RunDirectory) -> Repaired:
    """The result of a repair: complete frames remain, each damaged one is listed; other damaged files are restored or
    renamed.
    """
    beside = [*_resolved(home), *_scene_file(home), *_constants_file(home), *_repeated_files(home)]
    beside += set_foreign_aside(home.trajectory, identity_of(home))
    frames = repair_trajectory(home.trajectory)
    return frames._replace(faults=(*beside, *frames.faults))


def _resolved(home: RunDirectory) -> Iterator[str]:
    """Restore `resolved.json` from the scene file. Yields a description of each repair."""
    manifest = manifest_of(home)
    try:
        resolved_at(home.path, manifest)
    except StorageError:
        text = _from_the_scene(home)
        if manifest.get("scene_sha256") not in (None, hashlib.sha256(text).hexdigest()):
            yield f"{home.resolved}: damaged, and scene.toml does not give it again; put it back from a copy to resume"
            return
        write_whole(home.resolved, text, home.path)
        yield f"{home.resolved}: was damaged; made again from scene.toml"


def _scene_file(home: RunDirectory) -> Iterator[str]:
    """Restore a damaged scene file from the resolved scene. Yields a description of each repair."""
    from ecume.scenes.schema import from_plain
    from ecume.scenes.writing import to_toml

    try:
        require_source(home)
        return
    except StorageError:
        manifest = manifest_of(home)
    try:
        content = to_toml(from_plain(scene_at(home.path, manifest))).encode()
    except EcumeError:  # it is damaged as well, and is reported separately
        return
    if home.scene.exists():
        set_aside(home, home.scene)
    write_whole(home.scene, content, home.path)
    write(home, home.manifest, {**manifest, "source_sha256": hashlib.sha256(content).hexdigest()})
    yield f"{home.scene}: was damaged; written again from resolved.json, without its comments"


def _constants_file(home: RunDirectory) -> Iterator[str]:
    """Rename a damaged `constants.npz`, which is derived again on resume. Yields a description of each repair."""
    if is_sound(home):
        return
    if home.constants.exists():
        set_aside(home, home.constants)
    manifest = manifest_of(home)
    write(home, home.manifest, {name: value for name, value in manifest.items() if name != "constants_sha256"})
    yield f"{home.constants}: damaged or missing; set aside, and the constants are derived again on resume"


def _from_the_scene(home: RunDirectory) -> bytes:
    """The resolved scene derived from the scene file; empty if that cannot be read."""
    from ecume.scenes.load import load_scene
    from ecume.scenes.schema import to_plain

    try:
        return as_json(to_plain(load_scene(home.scene))).encode()
    except EcumeError:
        return b""


def _repeated_files(home: RunDirectory) -> Iterator[str]:
    """Rename damaged files that a resumed run writes again. Yields a description of each repair."""
    for path, check in ((home.status, STATUS), (home.watch, WATCH), (home.done, DONE), (home.failed, FAILED)):
        try:
            if path.exists():
                read(home, path, check)
        except StorageError as error:
            set_aside(home, path)
            yield f"{error}; set aside"


class Verification(NamedTuple):
    """The result of verifying a run."""

    directory: Path
    frames: int
    """The number of frames on disk."""
    size: int
    """The number of bytes that were read."""
    recomputed: int | None
    """The number of frames computed again, with `deep`."""
    faults: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def sound(self) -> bool:
        """Whether no file is damaged."""
        return not self.faults


def verify(
    directory: str | os.PathLike[str],
    *,
    deep: bool = False,
    extra_laws: Sequence[Law] = (),
    actions: Sequence[Action] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Verification:
    """Check all digests and checksums of a run, without writing anything.

    `deep` also computes all frames again from the beginning and compares them bit for bit; a run with user laws or
    actions then requires the same `extra_laws` and `actions`. The arguments of `progress` are the number of compared
    frames and the total. Raises RunExists while a process writes the run.
    """
    home = existing(directory)
    lock.require_free(home)
    size = sum(path.lstat().st_size for path in home.path.rglob("*") if path.is_file())
    trusted, faults = _compared(home)
    faults += _beside(home)
    frames = check_trajectory(home.trajectory, trusted=trusted, run=identity_of(home))
    faults += [*frames.faults, *_numbers(home, frames.good, frames.frames)]
    recomputed = None
    if deep:
        require_computed(home)
        if (engine := engine_of(home)) != LOCAL:
            raise BadInput(f"{home.path}: computed with --engine {engine}, which does not repeat bits; omit --deep")
    if deep and not faults:
        recomputed, found = _recomputed(home, UserCode(extra_laws, actions), progress)
        faults += found
    remarks = (*frames.remarks, *_remarks(home))
    return Verification(home.path, frames.frames, size, recomputed, tuple(dict.fromkeys(faults)), remarks)


IMPORTED = "imported"
"""The entry of the manifest with the name of the file whose frames a run contains."""


ENGINE = "engine"
"""The entry of the manifest with the name of the engine of a run; absent for that of the model."""


def engine_of(home: RunDirectory) -> str:
    """The name of the engine of a run."""
    return str(manifest_of(home).get(ENGINE, LOCAL))


def require_engine(home: RunDirectory, engine: Engine | None) -> None:
    """Raise BadInput if the engine is not that of the run, since the time steps of its states differ."""
    got, expected = LOCAL if engine is None else engine.name, engine_of(home)
    if got != expected:
        raise BadInput(f"{home.path}: got --engine {got}; expected {expected}, with which the run was started")


def require_computed(home: RunDirectory) -> None:
    """Raise BadInput for a run with imported frames, which cannot be computed again."""
    if name := manifest_of(home).get(IMPORTED):
        raise BadInput(
            f"{home.path}: its frames were imported from {name}, not computed; import the file again with "
            "`ecume import SCENE -o DIR --force`"
        )


def _compared(home: RunDirectory) -> tuple[frozenset[str], list[str]]:
    """The files of frames that are equal to those of the completed run, and the files that are not."""
    record = next((path for path in (home.done, home.failed) if path.exists()), None)
    if record is None:
        return frozenset(), []
    try:
        expected = read(home, record, DONE if record == home.done else FAILED).get("sha256", {})
        found = digests(home)
    except StorageError as error:
        return frozenset(), [str(error)]
    wrong = [f"{home.path / name}: missing; {record.name} has its digest" for name in expected if name not in found]
    wrong += [
        f"{home.path / name}: damaged: its digest is not that in {record.name}"
        for name in found
        if name in expected and found[name] != expected[name]
    ]
    same = (name for name in found if found[name] == expected.get(name))
    return frozenset(Path(name).name for name in same if name.startswith("traj/")), wrong


def _beside(home: RunDirectory) -> list[str]:
    """The faults of all files except frames."""
    checks: list[Callable[[], object]] = [
        lambda: resolved_at(home.path, manifest_of(home)),
        lambda: constants.require_sound_constants(home),
        lambda: require_source(home),
        lambda: lock_of(home),
        lambda: _log(home),
        lambda: _samples(home),
        lambda: _crate(home),
        lambda: _require_all(home),
        *(
            functools.partial(read, home, path, kind)
            for path, kind in ((home.status, STATUS), (home.watch, WATCH), (home.done, DONE), (home.failed, FAILED))
            if path.exists()
        ),
        *(functools.partial(_checkpoint, home, path) for path in checkpoints.newest_first(home)),
    ]
    return [fault for one in checks if (fault := _fault(one))]


def _fault(check: Callable[[], object]) -> str:
    try:
        check()
    except EcumeError as error:
        return str(error)
    return ""


def require_source(home: RunDirectory) -> None:
    """Raise StorageError if the scene file is not that with which the run started."""
    expected = manifest_of(home).get("source_sha256")
    if expected is not None and (not home.scene.exists() or digest(home, home.scene) != expected):
        raise StorageError(
            f"{home.scene}: damaged: it is not what the run began with; put it back from a copy, or `ecume repair "
            f"{home.path}` writes it again from resolved.json"
        )


def require_flow_file(home: RunDirectory, scene: Any) -> None:
    """Raise BadInput if the file with the velocities of the liquid is not that with which the run started."""
    expected = manifest_of(home).get(FLOW_FILE)
    if expected is not None and flow_file(scene).get(FLOW_FILE) != expected:
        raise BadInput(
            f"{home.path}: {scene.flow.field.file} has changed since the run was started; restore it, or run the "
            "scene again"
        )


def lock_of(home: RunDirectory) -> None:
    """Raise StorageError where the lock is damaged."""
    if home.lock.exists():
        with storing(home.lock):
            try:
                lock.read_owner(home)
            except ValueError as error:
                raise StorageError(f"{home.lock}: damaged: {error}; it may be removed") from error


def _samples(home: RunDirectory) -> None:
    """Raise StorageError for samples that differ from the written ones."""
    if home.samples.exists() or home.sums.exists():
        rows_of(home.samples, identity_of(home))


def unchecked(home: RunDirectory) -> int:
    """The number of bytes of samples after the last row with a checksum; 0 if the samples are damaged, which is
    reported as a fault.
    """
    try:
        return home.samples.stat().st_size - len(rows_of(home.samples, identity_of(home)))
    except StorageError:
        return 0


def _crate(home: RunDirectory) -> None:
    """Raise StorageError where the metadata of the run as a research object are damaged."""
    if home.crate.exists():
        # A crate of an earlier version has no checksum, and only these keys.
        record_at(home.crate, table({"@context": anything, "@graph": anything}, rest=_nothing), home.path, checked=None,
                  owner=owner_of(home, home.crate))  # fmt: skip


def _nothing(value: object, path: str) -> None:
    """Raise ValueError for a key that does not exist."""
    raise ValueError(f"{path}: is no key of such a file")


def _require_all(home: RunDirectory) -> None:
    """Raise StorageError if a file is missing: one that exists before the first checkpoint, or a file of a complete
    run.
    """
    if not identity_of(home):
        return
    ended = home.done.exists() or home.failed.exists()
    expected = [home.log, home.watch, home.scalars] * bool(checkpoints.newest_first(home)) + [home.status] * ended
    if missing := [path.name for path in expected if not path.exists()]:
        raise StorageError(f"{home.path}: {', '.join(missing)}: missing; `ecume resume {home.path}` writes it again")


def _log(home: RunDirectory) -> None:
    """Raise StorageError for a line of the log that is damaged."""
    if not home.log.exists():
        return
    checked, owner = has_checksums(home), owner_of(home, home.log)
    for number, content in enumerate(split(home, home.log), start=1):
        try:
            line_of(content, anything, checked=checked, owner=owner)
        except ValueError as error:
            raise StorageError(f"{home.log}: damaged: line {number}: {error}") from error


def _checkpoint(home: RunDirectory, path: Path) -> None:
    try:
        checkpoints.require_sound(home, path)
    except (OSError, ValueError, KeyError) as error:
        raise StorageError(f"{path}: damaged: {error}") from error


def _numbers(home: RunDirectory, good: int, frames: int) -> list[str]:
    """The faults of the table of numbers: damaged checksums, and differences from the numbers in undamaged frames."""
    try:
        rows = list(lines_of(home))
    except StorageError as error:
        return [str(error)]
    if len(rows) > frames:
        return [f"{home.trajectory}: {len(rows) - frames} frames are missing; {home.scalars.name} has their numbers"]
    if identity_of(home) and len(rows) < frames - (not home.done.exists()):  # a process killed between writing the two
        return [f"{home.scalars}: damaged: has {len(rows)} lines; expected {frames}"]
    if good < frames or not rows:
        return []
    try:
        with Trajectory(home.trajectory) as trajectory:
            times, steps = trajectory.times.tolist(), trajectory.steps.tolist()
    except StorageError as error:
        return [str(error)]
    wrong = [k for k, row in enumerate(rows) if row["time"] != times[k] or row["step"] != steps[k]]
    return [f"{home.scalars}: damaged: line {k + 1} is not that of its frame" for k in wrong[:1]]


def _remarks(home: RunDirectory) -> Iterator[str]:
    """Remarks on parts of the run that are not checked."""
    if not has_checksums(home):
        yield f"{home.path}: written by an earlier version, whose records and lines of numbers have no checksums"
    if not identity_of(home):
        yield f"{home.path}: written by an earlier version: its samples, and files of other runs, are not protected"
    if identity_of(home) and home.samples.exists() and (left := unchecked(home)):
        yield f"{home.samples}: {left} bytes follow the last row that has a checksum; they are computed again on resume"
    if aside := sorted(path.name for path in home.path.rglob("*.damaged")):
        yield f"{home.path}: set aside before: {', '.join(aside)}"


def _recomputed(
    home: RunDirectory, code: UserCode, progress: Callable[[int, int], None] | None
) -> tuple[int, list[str]]:
    """The number of frames that were computed again, and the first one that differs."""
    from ecume.models import MODELS
    from ecume.scenes.schema import from_plain
    from ecume.simulation import moments

    require_same(home, code)
    manifest = manifest_of(home)
    scene = from_plain(scene_at(home.path, manifest))
    selection, count = selection_of(scene, MODELS[scene.model]), 0
    with Trajectory(home.trajectory) as trajectory:
        restore = functools.partial(_constants, home)
        if not len(trajectory):
            return 0, []
        for moment in moments(scene, extra_laws=code.laws, actions=code.actions, constants=restore):
            if moment.frame is None:
                continue
            if (found := difference(trajectory[count], selection.of(moment.frame))) is not None:
                why = f" ({'; '.join(changes)})" if (changes := changed(manifest)) else ""
                return count, [f"{home.trajectory}: frame {count}, computed again, differs in {found}{why}"]
            count += 1
            if progress is not None:
                progress(count, len(trajectory))
            if count == len(trajectory):
                break
    return count, []


def _constants(home: RunDirectory, derived: Any) -> Any:
    return constants.restored(home, derived).parameters
