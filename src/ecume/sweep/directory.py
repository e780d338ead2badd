"""The directory of a sweep, and the status of the sweep as read from its files.

It contains `sweep.toml`, the file of the sweep; `points.json`; and a folder for each point. The name of this folder is
a digest of the simulation in it: after a change of the sweep file, finished points are found again, and only missing
points are run.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ecume._plain_files import content_of, require_plain
from ecume.errors import BadInput, Fault, SceneError, StorageError, beside_ecume
from ecume.models.model import LOCAL
from ecume.run.directory import RunDirectory
from ecume.run.lock import is_held
from ecume.run.manifest import FLOW_FILE, flow_digest
from ecume.run.until import UNTIL
from ecume.scenes.faults import echo, read_path, value_at
from ecume.scenes.load import OVERRIDDEN, load_scene
from ecume.scenes.schema import Scene, from_plain, scene_hash, to_plain
from ecume.scenes.tables import beside, require_there
from ecume.scenes.templates import folder as templates_folder
from ecume.sweep.spec import (
    SIZE,
    Asked,
    Point,
    SweepSpec,
    load_sweep,
    points_of,
    require_arguments,
    require_settings,
    varied,
)
from ecume.trajectories.records import (
    CRC,
    anything,
    as_json,
    key,
    listed,
    manifest_at,
    named,
    plain_of,
    sealed,
    storing,
    table,
    unsealed,
    whole,
    write_whole,
)

KEY_LENGTH = 16
POINTS_FOLDER = "points"
MOST_BYTES = 2**30
"""The largest size of a file of a sweep, which may contain a scene with tables."""
MADE_AGAIN = "delete it, and sweep again: that makes it again"
POINTS = listed(table({"settings": named(anything), "repeat": whole, "folder": key, "values": named(anything)}))
"""The content of `points.json`."""


class Job(NamedTuple):
    """A point and its folder."""

    point: Point
    folder: Path
    values: dict[str, Any]
    """the varied values as in the scene: numbers in SI"""

    @property
    def result(self) -> Path:
        """The file with the numbers that a process returned; it exists when the point is done."""
        return self.folder / "result.json"

    @property
    def run(self) -> Path:
        """The run directory of a scene."""
        return self.folder / "run"

    @property
    def failure(self) -> Path:
        """The file with the reason of a failure."""
        return self.folder / "failed.json"

    @property
    def asked(self) -> Path:
        """The file with the plan of the point."""
        return self.folder / "point.json"

    @property
    def state(self) -> str:
        """The state of the point: `done`, `failed` or `missing`."""
        if self.result.exists() or (self.run / "DONE.json").exists():
            return "done"
        return "failed" if self.failure.exists() else "missing"

    @property
    def why(self) -> str:
        """The reason of a failure, in one line."""
        if self.state != "failed":
            return ""
        return str(json_at(self.failure, dict).get("why", ""))


class Sweeping(NamedTuple):
    """A sweep on disk."""

    path: Path
    spec: SweepSpec
    jobs: list[Job]

    @property
    def keys(self) -> list[str]:
        """The keys that vary."""
        return varied(self.spec)


def written(plain: Mapping[str, Any], path: Path) -> str:
    """The text of a file of a sweep, with a checksum.

    The checksum of a file of a point includes the name of the file and that of the point, so that it does not match in
    the folder of another point.
    """
    return sealed(plain, _owner(path))


def _owner(path: Path) -> str:
    of_point = path.parent.parent.name == POINTS_FOLDER
    return f"{path.parent.name} {path.name}" if of_point else path.name


def _refuse_foreign(directory: Path) -> None:
    """Raise BadInput if a file has a reserved name although the directory contains no sweep."""
    path = directory / "points.json"
    if path.exists() and not (directory / POINTS_FOLDER).is_dir():
        raise BadInput(f"{path}: exists, and was not written by a sweep; choose another folder with -o")


Check = Callable[[Sequence[str], Mapping[str, Any]], None]
"""A function of measures and the plan of a point that raises BadInput if they do not fit."""


def unchecked(measures: Sequence[str], plan: Mapping[str, Any]) -> None:
    """Accept any measures, without a test."""


def write_points(asked: Asked, directory: Path, check: Check = unchecked) -> Sweeping:
    """Write the scene of each point, after all scenes have been read and checked."""
    spec = asked.spec
    if spec.process:
        require_arguments(spec.process, [*spec.fixed, *varied(spec)])
    plans = [(point, _checked_plan(asked, point)) for point in points_of(spec)]
    digest = functools.cache(flow_digest)  # many points refer to the same file
    plans = [(point, plan | _flow_file(plan, digest)) for point, plan in plans]
    keys = varied(spec)
    jobs = [Job(point, directory / POINTS_FOLDER / _digest(plan), _values(point, plan, keys)) for point, plan in plans]
    _refuse_foreign(directory)
    if any(job.state != "done" for job in jobs):
        check(spec.measures, plans[0][1])
    with storing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        require_plain(directory)
        for job, (_, plan) in zip(jobs, plans, strict=True):
            job.folder.mkdir(parents=True, exist_ok=True)
            text = written(dict(sorted(plan.items())), job.asked).encode()
            if not job.asked.exists() or content_of(job.asked, MOST_BYTES, job.folder) != text:
                write_whole(job.asked, text, directory)
        write_whole(directory / "sweep.toml", asked.text, directory)
        points = {"sweep_sha256": _sha256(asked.text), "points": [_plain(job) for job in jobs]}
        write_whole(directory / "points.json", written(points, directory / "points.json"), directory)
    return Sweeping(directory, spec, jobs)


def open_or_create(
    file: Path, directory: Path, laws: Sequence[dict[str, Any]] = (), check: Check = unchecked
) -> Sweeping:
    """The existing or new sweep of a file. Raises BadInput if an existing sweep has other user laws.

    A sweep that is given by its directory contains all of its points, but not the scene file. `laws` are the entries of
    user laws.
    """
    asked = load_sweep(file)._replace(laws=tuple(laws))
    if asked.spec.scene and is_sweep(directory) and file.resolve().parent == directory.resolve():
        found = existing_sweep(directory)
        require_laws(found, laws)
        require_flow_files(found)
        if any(job.state != "done" for job in found.jobs):
            check(found.spec.measures, json_at(found.jobs[0].asked, dict))
        return found
    return write_points(asked, directory, check)


def require_laws(sweeping: Sweeping, laws: Sequence[dict[str, Any]]) -> None:
    """Raise BadInput unless the sweep was started with these user laws."""
    begun = json_at(sweeping.jobs[0].asked, dict).get("extra_laws", [])
    if begun != list(laws):
        required = " ".join(f"--laws FILE.py:{law['name']}" for law in begun)
        same = [law["name"] for law in begun] == [law["name"] for law in laws]
        changed = "the text of its laws has changed; restore it, or sweep into another directory"
        way = changed if same else f"expected {required}" if begun else "expected no --laws, as when it was begun"
        raise BadInput(f"{sweeping.path}: {way}")


def require_flow_files(sweeping: Sweeping) -> None:
    """Raise BadInput if the file with velocities for a missing point has changed since the start of the sweep."""
    digest = functools.cache(flow_digest)
    for job in distinct(sweeping.jobs):
        if job.state != "done":
            plan = json_at(job.asked, dict)
            if FLOW_FILE in plan and _flow_file(plan, digest)[FLOW_FILE] != plan[FLOW_FILE]:
                name = _flow_field(plan)["file"]
                raise BadInput(f"{sweeping.path}: {name} has changed since the sweep was begun; sweep its file again")


def _flow_field(plan: Mapping[str, Any]) -> dict[str, Any]:
    """The table `flow.field` of the scene in a plan; empty without one."""
    return ((plan.get("scene") or {}).get("flow") or {}).get("field") or {}


def _flow_file(plan: Mapping[str, Any], digest: Callable[[str], str]) -> dict[str, str]:
    """The digest of the file with velocities in a scene. All other files are part of the scene itself."""
    field = _flow_field(plan)
    return {FLOW_FILE: digest(field["file"])} if field else {}


def existing_sweep(directory: Path) -> Sweeping:
    """A sweep that was started. Raises BadInput if it does not exist."""
    path = directory / "points.json"
    if not path.is_file():
        raise BadInput(f"{directory}: got no sweep; expected a directory from `ecume sweep`")
    with storing(directory):
        require_plain(directory)
    found = json_at(path, (dict, list))
    rows: Any = found.get("points") if isinstance(found, dict) else found  # earlier versions wrote a list
    try:
        POINTS(rows, "points")
    except ValueError as error:
        raise StorageError(f"{path}: damaged: {error}; {MADE_AGAIN}") from error
    asked = load_sweep(directory / "sweep.toml")
    if isinstance(found, dict) and found.get("sweep_sha256") != _sha256(asked.text):
        raise StorageError(
            f"{directory / 'sweep.toml'}: damaged: not what {path.name} was made of; sweep its file again"
        )
    jobs = [
        Job(Point(one["settings"], one["repeat"]), directory / POINTS_FOLDER / one["folder"], one["values"])
        for one in rows
    ]
    return Sweeping(directory, asked.spec, jobs)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def json_at(path: Path, kind: type | tuple[type, ...]) -> Any:
    """The contents of a file of a sweep. Raises StorageError if it is damaged."""
    with storing(path):
        text = content_of(path, MOST_BYTES, path.parent)
    try:
        found = plain_of(text)
        if isinstance(found, dict) and CRC in found:  # files of earlier versions have no checksum
            found = unsealed(found, text, _owner(path))
    except ValueError as error:
        raise StorageError(f"{path}: damaged: {error}; {MADE_AGAIN}") from error
    if not isinstance(found, kind):
        raise StorageError(f"{path}: damaged; {MADE_AGAIN}")
    return found


def require_own_run(job: Job) -> None:
    """Raise StorageError if the run of a point belongs to another scene."""
    expected = json_at(job.asked, dict).get("scene_sha256")
    if expected is not None and manifest_at(job.run).get("scene_sha256") != expected:
        raise StorageError(f"{job.run}: is the run of another scene than that of its point; {MADE_AGAIN}")


def distinct(jobs: Sequence[Job]) -> list[Job]:
    """The points without repetition, since points with equal plans have a common folder."""
    return list({job.folder: job for job in jobs}.values())


def is_sweep(directory: Path) -> bool:
    """Whether a directory contains a sweep."""
    return (directory / "points.json").is_file()


def _checked_plan(asked: Asked, point: Point) -> dict[str, Any]:
    """The plan of a point. Raises SceneError for faults of the sweep's file, or of the scene's file with its lines."""
    try:
        return _plan(asked, point)
    except SceneError as error:
        at = ", ".join(f"{key} = {echo(point.settings[key])}" for key in varied(asked.spec) if key in point.settings)
        rows = (_as_asked(fault, error.source) for fault in error.faults)
        raise SceneError([Fault("", f"at {at}: {one}" if at else one) for one in rows], asked.name) from None


def _as_asked(fault: Fault, source: str) -> str:
    """The fault of a generated scene as a fault of the sweep."""
    if fault.line is not None:
        return f"{source}: {fault}"
    words = re.sub(r"^--set '[^']*': ", "", str(fault).removesuffix(OVERRIDDEN))
    return words + ("; whole = true in a span rounds" if words.endswith("expected a whole number") else "")


def _plan(asked: Asked, point: Point) -> dict[str, Any]:
    """The scene or the process that is simulated at a point."""
    spec = asked.spec
    if spec.process:
        require_settings(spec.process, point.settings)
        return {"process": spec.process, "settings": point.settings}
    changes = [f"{key}={_toml(value)}" for key, value in point.settings.items() if key != SIZE]
    source = _source(asked)
    seed = [f"seed={load_scene(source, changes).seed + point.repeat}"] if point.repeat else []
    scene = enlarged(load_scene(source, [*changes, *seed]), point.settings.get(SIZE, 1))
    plain = to_plain(scene)
    plan: dict[str, Any] = {"scene": plain, "hash": scene_hash(scene), "scene_sha256": _sha256(as_json(plain))}
    if asked.laws:
        plan["extra_laws"] = list(asked.laws)
    if spec.until:
        plan[UNTIL] = spec.until
    return plan if spec.engine == LOCAL else plan | _in_lammps(scene, spec)


def enlarged(scene: Scene, factor: int) -> Scene:
    """The scene with `factor` times as many particles of each species, in a periodic cell enlarged by the same factor.
    Raises BadInput if this is not defined.
    """
    if factor == 1:
        return scene
    plain = to_plain(scene)
    cell, particles = plain.get("cell"), plain.get("particles", [])
    if not cell or plain.get("walls"):
        raise BadInput("sizes: they are those of a periodic cell on all sides; expected a scene with [cell], no walls")
    if plain.get("rows"):
        raise BadInput("sizes: they are factors of counts; expected no [[rows]], whose floats are listed")
    if not all(one.get("count") and not one.get("positions") and not one.get("radii") for one in particles):
        raise BadInput("sizes: they are factors of counts; expected count, and no lists of positions or radii")
    for one in particles:
        one["count"] *= factor
    if not any(key.endswith("_fraction") and cell[key] for key in cell):
        cell["size"] = [float(factor) ** (1.0 / len(cell["size"])) * side for side in cell["size"]]
    return from_plain(plain)


def _in_lammps(scene: Scene, spec: SweepSpec) -> dict[str, Any]:
    """The additional entries in the plan of a run in LAMMPS. Raises BadInput for scenes that LAMMPS cannot simulate."""
    with beside_ecume():
        from ecume_lammps.engine import require_runnable
    require_runnable(scene)
    return {"engine": spec.engine, "ranks": spec.ranks}


def _source(asked: Asked) -> Path:
    """The scene's file. Raises BadInput if it does not exist."""
    if asked.spec.template:
        return Path(str(templates_folder() / f"{asked.spec.template}.toml"))
    try:
        path = beside(asked.folder, asked.spec.scene)
        require_there(path, asked.folder)
    except ValueError as error:
        raise BadInput(f"scene: {asked.spec.scene} {error}") from error
    return path


def _plain(job: Job) -> dict[str, Any]:
    """A point as in `points.json`."""
    point = job.point
    return {"settings": point.settings, "repeat": point.repeat, "folder": job.folder.name, "values": job.values}


def _values(point: Point, plan: dict[str, Any], keys: list[str]) -> dict[str, Any]:
    """The values of the varied keys at a point."""
    if "process" in plan:
        return {key: plan["settings"].get(key) for key in keys}
    return {key: point.settings[SIZE] if key == SIZE else value_at(plan["scene"], read_path(key), None) for key in keys}


def _toml(value: Any) -> str:
    """A value as TOML text for an override, in one line.

    >>> _toml([{"count": 5, "radius": "2 mm"}])
    '[{"count" = 5, "radius" = "2 mm"}]'
    """
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        raise BadInput(f"{value} is not a valid value of a scene")
    return json.dumps(value)


def _digest(plan: dict[str, Any]) -> str:
    """The digest of a plan. The number of ranks is ignored, since it changes only last digits."""
    further = [plan[key] for key in ("engine", "extra_laws", FLOW_FILE, UNTIL) if key in plan]
    if "hash" in plan and not further:
        return str(plan["hash"])[:KEY_LENGTH]
    words = (one if isinstance(one, str) else _json(one) for one in further)
    text = " ".join([plan["hash"], *words]) if "hash" in plan else _json(plan)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH]


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, indent=1)


RECENT = 50
"""The number of last points from which the rate is computed."""
SILENT = 10.0
"""Workers count as inactive if no point ends within SILENT (seconds) plus SILENT times the usual interval."""


class Standing(NamedTuple):
    """The number of points in each state."""

    done: int
    failed: list[tuple[Path, str]]
    """folders and reasons"""
    running: int
    """runs that a process has locked; processes such as `t1` are not counted, since they lock nothing"""
    missing: int
    remaining: float | None
    """s, until all are done; None if unknown"""


def standing(directory: Path) -> Standing:
    """The status of a sweep. Raises BadInput if it does not exist."""
    jobs = distinct(existing_sweep(directory).jobs)
    states = [job.state for job in jobs]
    failed = [(job.folder, job.why) for job, state in zip(jobs, states, strict=True) if state == "failed"]
    waiting = [job for job, state in zip(jobs, states, strict=True) if state == "missing"]
    running = sum(is_held(RunDirectory(job.run)) for job in waiting)
    ended = sorted(_ended(job) for job, state in zip(jobs, states, strict=True) if state == "done")
    return Standing(len(ended), failed, running, len(waiting) - running, remaining(ended, len(waiting), time.time()))


def _ended(job: Job) -> float:
    """The time at which a point was completed."""
    marker = job.result if job.result.exists() else RunDirectory(job.run).done
    return marker.stat().st_mtime


def remaining(ended: Sequence[float], waiting: int, now: float) -> float | None:
    """The time (s) that the waiting points take at the rate of the last ones; None if it is
    unknown.

    >>> remaining([0.0, 10.0, 20.0], waiting=6, now=24.0)
    72.0
    """
    recent = ended[-RECENT:]
    if not waiting or len(recent) < 2:
        return None
    usual = (recent[-1] - recent[0]) / (len(recent) - 1)
    if now - recent[-1] > SILENT * (1.0 + usual):
        return None
    return waiting * (now - recent[0]) / (len(recent) - 1)
