"""Recovery of a damaged run: its whole frames, and the files beside them that can be written again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

from ecume.errors import EcumeError, StorageError
from ecume.run.checkpoints import set_aside
from ecume.run.constants import is_sound
from ecume.run.directory import RunDirectory, manifest_of, read, write
from ecume.run.verification import require_source
from ecume.trajectories.durable_files import write_whole
from ecume.trajectories.records import DONE, FAILED, STATUS, WATCH, as_json, resolved_at, scene_at
from ecume.trajectories.repair import Repaired
from ecume.trajectories.repair import repair as repair_trajectory


def mended(home: RunDirectory) -> Repaired:
    """Whole frames stay, each damaged one is named; what is damaged beside them is made again or set aside."""
    beside = [*_resolved(home), *_scene_file(home), *_constants(home), *_repeated_files(home)]
    frames = repair_trajectory(home.trajectory)
    return frames._replace(faults=(*beside, *frames.faults))


def _resolved(home: RunDirectory) -> Iterator[str]:
    """Restore `resolved.json` from the scene file; yields what was done."""
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
    """Write a damaged scene file again from the resolved scene; yields what was done."""
    from ecume.scenes.schema import from_plain
    from ecume.scenes.writing import to_toml

    try:
        require_source(home)
        return
    except StorageError:
        manifest = manifest_of(home)
    try:
        content = to_toml(from_plain(scene_at(home.path, manifest))).encode()
    except EcumeError:  # damaged, too; that is named
        return
    if home.scene.exists():
        set_aside(home, home.scene)
    write_whole(home.scene, content, home.path)
    write(home, home.manifest, {**manifest, "source_sha256": hashlib.sha256(content).hexdigest()})
    yield f"{home.scene}: was damaged; written again from resolved.json, without its comments"


def _constants(home: RunDirectory) -> Iterator[str]:
    """Set aside a damaged `constants.npz`, which is derived again on resume; yields what was done."""
    if is_sound(home):
        return
    if home.constants.exists():
        set_aside(home, home.constants)
    manifest = manifest_of(home)
    write(home, home.manifest, {name: value for name, value in manifest.items() if name != "constants_sha256"})
    yield f"{home.constants}: damaged or missing; set aside, and the constants are derived again on resume"


def _from_the_scene(home: RunDirectory) -> bytes:
    """The resolved scene as the scene's file gives it today; empty where that cannot be read."""
    from ecume.scenes.load import load_scene
    from ecume.scenes.schema import to_plain

    try:
        return as_json(to_plain(load_scene(home.scene))).encode()
    except EcumeError:
        return b""


def _repeated_files(home: RunDirectory) -> Iterator[str]:
    """Set aside damaged files that the run writes again when it is resumed; yields what was done."""
    for path, check in ((home.status, STATUS), (home.watch, WATCH), (home.done, DONE), (home.failed, FAILED)):
        try:
            if path.exists():
                read(home, path, check)
        except StorageError as error:
            set_aside(home, path)
            yield f"{error}; set aside"
