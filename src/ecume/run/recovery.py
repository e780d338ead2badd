"""Recovery of a damaged run: its whole frames, and the files beside them that can be written again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ecume.errors import EcumeError, StorageError
from ecume.run.constants import is_sound
from ecume.run.directory import RunDirectory, as_json, json_of, write_json
from ecume.trajectories.durable_files import storing, write_whole
from ecume.trajectories.repair import Repaired
from ecume.trajectories.repair import repair as repair_trajectory


def plain_scene(home: RunDirectory) -> dict[str, Any]:
    """The scene as it was at the start of the run. Raises StorageError if it is damaged: otherwise another scene would
    be continued unnoticed.
    """
    with storing(home.resolved):
        text = home.resolved.read_bytes()
    if not _is_the_first(home, text):
        way_out = f"`ecume repair {home.path}` makes it again from scene.toml"
        raise StorageError(f"{home.resolved}: damaged: it is not what the run began with; {way_out}")
    return json_of(home.resolved)


def mended(home: RunDirectory) -> Repaired:
    """Whole frames stay, each damaged one is named; what is damaged beside them is made again or set aside."""
    beside = [*_resolved(home), *_constants(home), *_repeated_files(home)]
    frames = repair_trajectory(home.trajectory)
    return frames._replace(faults=(*beside, *frames.faults))


def _is_the_first(home: RunDirectory, text: bytes) -> bool:
    """Whether a run began with this; the manifest has its digest, if anything."""
    return json_of(home.manifest).get("scene_sha256") in (None, hashlib.sha256(text).hexdigest())


def _resolved(home: RunDirectory) -> Iterator[str]:
    """Restore `resolved.json` from the scene file; yields what was done."""
    if home.resolved.is_file() and _is_the_first(home, home.resolved.read_bytes()):
        return
    text = _from_the_scene(home)
    if not _is_the_first(home, text):
        yield f"{home.resolved}: damaged, and scene.toml does not tell it again; put it back from a copy to go on"
        return
    write_whole(home.resolved, text)
    yield f"{home.resolved}: was damaged; made again from scene.toml"


def _constants(home: RunDirectory) -> Iterator[str]:
    """Set aside a damaged `constants.npz`, which is derived again on resume; yields what was done."""
    if is_sound(home):
        return
    if home.constants.exists():
        _set_aside(home.constants)
    manifest = json_of(home.manifest)
    write_json(home.manifest, {name: value for name, value in manifest.items() if name != "constants_sha256"})
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
    for path in (home.status, home.watch, home.done, home.failed):
        try:
            if path.is_file():
                json_of(path)
        except StorageError as error:
            _set_aside(path)
            yield f"{error}; set aside"


def _set_aside(path: Path) -> None:
    with storing(path):
        path.replace(path.with_name(f"{path.name}.damaged"))
