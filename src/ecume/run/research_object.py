"""A run as a research object: `ro-crate-metadata.json`, RO-Crate 1.1 (https://w3id.org/ro/crate/1.1), in JSON-LD.

The run's directory becomes the crate. The metadata list its files with their sizes and SHA-256 digests, the scene,
the program with its version and libraries, the times at which the run was computed, and, if they are given, the
authors and the license.
"""

from __future__ import annotations

import datetime
import hashlib
import mimetypes
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, cast
from urllib.parse import quote

from ecume.errors import BadInput
from ecume.run.directory import RunDirectory, existing, manifest_of, owner_of
from ecume.run.lock import held
from ecume.trajectories.records import scene_at, sealed, storing, write_whole

if TYPE_CHECKING:
    pass
from ecume.run.manifest import ECUME, PROGRAMS, RUN

CONTEXT = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "https://schema.org/sha256"}]
PROFILE = "https://w3id.org/ro/crate/1.1"
SPDX = "https://spdx.org/licenses/"
ORCID = re.compile(r"\(?(?:https://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])\)?")
TYPES = {
    ".toml": "application/toml",
    ".jsonl": "application/jsonl",
    ".gsd": "application/x-gsd",
    ".npz": "application/x-npz",
    ".vtkhdf": "application/x-hdf5",
    ".xyz": "chemical/x-xyz",
    ".webp": "image/webp",
}
"""Media types that the operating system may not know."""
ABOUT = {
    "scene.toml": "The scene: the description of the simulation",
    "resolved.json": "The scene with all default values",
    "constants.npz": "Constants that the model derived from the scene",
    "manifest.json": "Versions, machine and sessions of the run",
    "scalars.jsonl": "Numbers of each frame",
    "samples.csv": "Numbers sampled between frames",
    "samples-checksums.jsonl": "Checksums of the samples",
    "watch.json": "Invariants, and whether they held",
    "log.jsonl": "Events of the run",
    "DONE.json": "Completion of the run, with digests",
    "FAILED.json": "Failure of the run, with digests",
}
STATUS = "http://schema.org/{}ActionStatus"
Entity = dict[str, object]


class Attribution(NamedTuple):
    """The people and the license of a crate."""

    authors: Sequence[str] = ()
    """Names, each with an ORCID if there is one: `Ada Lovelace (0000-0002-1825-0097)`."""
    license: str = ""
    """An SPDX identifier, such as `CC-BY-4.0`, or an address."""


UNKNOWN = Attribution()


def write_crate(directory: str | os.PathLike[str], attribution: Attribution = UNKNOWN) -> Path:
    """Write the metadata of a run into its directory, which then is a crate. Raises RunExists while the run is being
    computed, since its files still change.
    """
    home = existing(directory)
    with held(home):
        write_whole(home.crate, sealed(metadata(home, attribution), owner_of(home, home.crate)), home.path)
    return home.crate


def metadata(home: RunDirectory, attribution: Attribution = UNKNOWN) -> Entity:
    """The JSON-LD document of a run."""
    files = [_file(home, path) for path in crate_files(home)]
    people = [_person(author, number) for number, author in enumerate(attribution.authors)]
    root = _root(home, [file["@id"] for file in files], attribution, people)
    descriptor = {
        "@id": home.crate.name,
        "@type": "CreativeWork",
        "about": _reference("./"),
        "conformsTo": _reference(PROFILE),
    }
    further = [_action(home, files), *_programs(home), *people, *_license(attribution.license)]
    return {"@context": CONTEXT, "@graph": [descriptor, root, *files, *further]}


def crate_files(home: RunDirectory) -> list[Path]:
    """The files of a run that are part of a crate: all except locks, states and incomplete files."""
    hidden = {home.lock, home.status, home.crate}
    found = [path for path in home.path.rglob("*") if path.is_file() and not path.is_symlink()]
    kept = [path for path in found if path not in hidden and home.checkpoints not in path.parents]
    return sorted(path for path in kept if not path.name.endswith((".part", ".damaged")))


def _root(home: RunDirectory, parts: Sequence[object], attribution: Attribution, people: Sequence[Entity]) -> Entity:
    manifest = manifest_of(home)
    scene = scene_at(home.path, manifest)
    title = str(scene.get("title") or home.path.resolve().name)
    model, version = manifest.get("model", ""), manifest.get("ecume", "")
    described = f"Simulation of {scene.get('duration'):g} s with the model {model} of ecume {version}"
    root: Entity = {
        "@id": "./",
        "@type": "Dataset",
        "name": title,
        "description": described,
        "datePublished": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "hasPart": [_reference(part) for part in parts],
        "mentions": _reference(RUN),
        "version": str(manifest.get("scene_sha256", "")),
    }
    if people:
        root["author"] = [_reference(person["@id"]) for person in people]
    if attribution.license:
        root["license"] = _reference(_license_address(attribution.license))
    return root


def _file(home: RunDirectory, path: Path) -> Entity:
    """A file with its size and its digest."""
    name = quote(path.relative_to(home.path).as_posix())
    with storing(path), path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    entity: Entity = {
        "@id": name,
        "@type": "File",
        "name": path.name,
        "contentSize": str(path.stat().st_size),
        "encodingFormat": TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream",
        "sha256": digest,
    }
    about = "Frames of the run, in the format of HOOMD-blue" if path.suffix == ".gsd" else ABOUT.get(name)
    return {**entity, "description": about} if about else entity


def _action(home: RunDirectory, files: Sequence[Entity]) -> Entity:
    """The description of the computation: program, scene, times, and outcome."""
    sessions = manifest_of(home).get("sessions", [])
    state = "Completed" if home.done.exists() else "Failed" if home.failed.exists() else "Active"
    inputs = ("scene.toml", "resolved.json")
    action: Entity = {
        "@id": RUN,
        "@type": "CreateAction",
        "name": "Simulation",
        "instrument": _reference(ECUME),
        "actionStatus": _reference(STATUS.format(state)),
        "object": [_reference(file["@id"]) for file in files if file["@id"] in inputs],
        "result": [_reference(file["@id"]) for file in files if str(file["@id"]).startswith(("traj/", "sca", "sam"))],
    }
    if sessions:
        action["startTime"] = sessions[0].get("began", "")
    if sessions and "ended" in sessions[-1]:
        action["endTime"] = sessions[-1]["ended"]
    return action


def _programs(home: RunDirectory) -> list[Entity]:
    """The version of ecume that began the run, and those of its libraries."""
    manifest = manifest_of(home)
    names = [name for name in ("python", *PROGRAMS) if manifest.get(name)]
    libraries = [_program(f"#{name}", name, manifest[name]) for name in names]
    needs = [_reference(library["@id"]) for library in libraries]
    return [{**_program(ECUME, "ecume", manifest.get("ecume", "")), "softwareRequirements": needs}, *libraries]


def _program(address: str, name: str, version: object) -> Entity:
    return {"@id": address, "@type": "SoftwareApplication", "name": name, "version": str(version)}


def _person(author: str, number: int) -> Entity:
    """An author; the address is the ORCID if one is given.

    >>> _person("Ada Lovelace (0000-0002-1825-0097)", 0)["@id"]
    'https://orcid.org/0000-0002-1825-0097'
    """
    found = ORCID.search(author)
    name = ORCID.sub("", author).strip(" ,;")
    if not name:
        raise BadInput(f"author: got {author!r}; expected a name, with an ORCID if there is one")
    return {"@id": f"https://orcid.org/{found[1]}" if found else f"#author-{number}", "@type": "Person", "name": name}


def _license(name: str) -> list[Entity]:
    return [{"@id": _license_address(name), "@type": "CreativeWork", "name": name}] if name else []


def _license_address(name: str) -> str:
    """The address of a license; SPDX identifiers are in the list of SPDX."""
    if name.startswith(("https://", "http://")):
        return name
    if not re.fullmatch(r"[A-Za-z0-9.+-]+", name):
        raise BadInput(f"license: got {name!r}; expected an SPDX identifier such as CC-BY-4.0, or an address")
    return f"{SPDX}{name}"


def _reference(address: object) -> Entity:
    return {"@id": cast(str, address)}
