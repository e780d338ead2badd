"""Runs as research objects: the structure that RO-Crate 1.1 requires, and what it says about a run."""

from __future__ import annotations

import datetime
import hashlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import toy
from typer.testing import CliRunner

import ecume
from ecume.cli import app
from ecume.errors import BadInput
from ecume.run import RunDirectory, run
from ecume.run.lock import held
from ecume.run.research_object import Attribution, write_crate

Scenes = Callable[..., toy.ToyScene]
AUTHORS = ["Ada Lovelace (0000-0002-1825-0097)", "Mary Somerville"]


@pytest.fixture
def home(tmp_path: Path, scene: Scenes) -> RunDirectory:
    asked = scene(duration=0.05, title="Beads", output={"samples": {"every": 0.01}})
    run(asked, tmp_path / "run", options=ecume.run.RunOptions(source=b"# beads\n"))
    (tmp_path / "run" / "results").mkdir()
    (tmp_path / "run" / "results" / "a figure.png").write_bytes(b"picture")
    return RunDirectory(tmp_path / "run")


def entities(path: Path) -> dict[str, Any]:
    document = json.loads(path.read_text())
    assert "https://w3id.org/ro/crate/1.1/context" in document["@context"]
    found = {entity["@id"]: entity for entity in document["@graph"]}
    assert len(found) == len(document["@graph"])
    return found


def references(value: Any) -> Iterator[str]:
    """The addresses that an entity refers to."""
    if isinstance(value, dict) and set(value) == {"@id"}:
        yield value["@id"]
    elif isinstance(value, (list, dict)):
        for each in value.values() if isinstance(value, dict) else value:
            yield from references(each)


def test_the_structure_is_that_of_a_crate(home: RunDirectory) -> None:
    found = entities(write_crate(home.path, Attribution(AUTHORS, "CC-BY-4.0")))
    descriptor, root = found["ro-crate-metadata.json"], found["./"]
    assert descriptor["@type"] == "CreativeWork"
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert descriptor["about"] == {"@id": "./"}
    assert root["@type"] == "Dataset"
    assert root["name"] == "Beads"
    assert root["description"].startswith("Simulation of 0.05 s with the model toy")
    datetime.datetime.fromisoformat(root["datePublished"])
    assert all("@type" in entity for entity in found.values())
    linked = {link for entity in found.values() for link in references(list(entity.values()))}
    outside = {link for link in linked - found.keys() if not link.startswith("http")}
    assert outside == set()


def test_every_file_is_listed_with_its_digest(home: RunDirectory) -> None:
    found = entities(write_crate(home.path))
    parts = [part["@id"] for part in found["./"]["hasPart"]]
    expected = {"scene.toml", "resolved.json", "manifest.json", "scalars.jsonl", "samples.csv", "traj/0000.gsd"}
    assert expected | {"DONE.json", "results/a%20figure.png"} <= set(parts)
    assert not [part for part in parts if part.startswith(("ckpt", "lock", "status", "ro-crate"))]
    for part in parts:
        content = (home.path / part.replace("%20", " ")).read_bytes()
        assert found[part]["@type"] == "File"
        assert found[part]["sha256"] == hashlib.sha256(content).hexdigest()
        assert found[part]["contentSize"] == str(len(content))
    assert found["results/a%20figure.png"]["encodingFormat"] == "image/png"


def test_the_computation_names_program_scene_and_time(home: RunDirectory) -> None:
    found = entities(write_crate(home.path))
    action = found["#run"]
    assert action["@type"] == "CreateAction"
    assert action["actionStatus"]["@id"].endswith("CompletedActionStatus")
    assert found[action["instrument"]["@id"]]["version"] == ecume.__version__
    assert {"@id": "scene.toml"} in action["object"]
    assert {"@id": "traj/0000.gsd"} in action["result"]
    assert datetime.datetime.fromisoformat(action["startTime"]) <= datetime.datetime.fromisoformat(action["endTime"])
    assert "#numpy" in found


def test_authors_and_license_are_entities(home: RunDirectory) -> None:
    found = entities(write_crate(home.path, Attribution(AUTHORS, "CC-BY-4.0")))
    ada, mary = found["./"]["author"]
    assert ada["@id"] == "https://orcid.org/0000-0002-1825-0097"
    assert found[ada["@id"]] == {**ada, "@type": "Person", "name": "Ada Lovelace"}
    assert found[mary["@id"]]["name"] == "Mary Somerville"
    assert found["./"]["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0"}
    assert found["https://spdx.org/licenses/CC-BY-4.0"]["name"] == "CC-BY-4.0"
    plain = entities(write_crate(home.path))
    assert not {"author", "license"} & plain["./"].keys()


@pytest.mark.parametrize(
    "given", [Attribution(["(0000-0002-1825-0097)"]), Attribution([" "]), Attribution(license="all rights reserved")]
)
def test_wrong_attributions_are_refused(home: RunDirectory, given: Attribution) -> None:
    with pytest.raises(BadInput, match=r"author: got|license: got"):
        write_crate(home.path, given)
    assert not home.crate.exists()


def test_a_run_in_progress_is_refused(home: RunDirectory) -> None:
    with held(home), pytest.raises(BadInput, match="is being written by"):
        write_crate(home.path)


def test_metadata_of_a_replaced_run_are_removed(home: RunDirectory, scene: Scenes) -> None:
    write_crate(home.path)
    run(scene(duration=0.02), home.path, force=True)
    assert not home.crate.exists()


def test_the_command_takes_authors_and_a_license(home: RunDirectory) -> None:
    command = ["export", str(home.path), "--to", "ro-crate", "--author", AUTHORS[0], "--license", "CC0-1.0"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0
    assert done.stdout.strip() == f"wrote {home.crate}"
    assert entities(home.crate)["./"]["license"]["@id"].endswith("/CC0-1.0")


@pytest.mark.parametrize("options", [["--to", "csv", "--author", "X"], ["--to", "ro-crate", "-o", "x.json"]])
def test_options_that_do_not_fit_are_refused(home: RunDirectory, options: list[str]) -> None:
    done = CliRunner().invoke(app, ["export", str(home.path), *options])
    assert done.exit_code == BadInput.exit_code
    assert "--to ro-crate" in done.stderr or "omit -o" in done.stderr
    assert not home.crate.exists()
