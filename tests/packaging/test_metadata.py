"""The metadata of the distributions agree: of the package, its conda recipe, its citation and its Zenodo record."""

import email
import json
import os
import re
import subprocess
import sys
import time
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml
from packaging.metadata import Metadata

from ecume.errors import BESIDE

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BESIDE_US = {name: ROOT / folder for name, (_, folder) in BESIDE.items()}
RECIPE = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
ZENODO = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
ON_CONDA = {"matplotlib": "matplotlib-base"}
"""Packages with another name on conda-forge."""


def filled(text: str) -> str:
    """A text of the recipe with the values of its context."""
    return re.sub(r"\$\{\{ (\w+) \}\}", lambda found: RECIPE["context"][found[1]], text)


def test_the_recipe_needs_what_the_package_needs():
    needed = [re.fullmatch(r"([\w-]+)(.*)", one).groups() for one in PROJECT["dependencies"]]
    expected = [
        f"python {PROJECT['requires-python']}",
        *(f"{ON_CONDA.get(name, name)} {least}" for name, least in needed),
    ]
    assert [filled(one) for one in RECIPE["requirements"]["run"]] == expected


def test_the_recipe_builds_as_the_package_does():
    build = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    host = RECIPE["requirements"]["host"]
    assert {one.replace(">=", " >=") for one in build} == set(host) - {"python ${{ python_min }}.*", "pip"}
    scripts = [f"{name} = {place}" for name, place in PROJECT["scripts"].items()]
    assert RECIPE["build"]["python"]["entry_points"] == scripts


def test_the_recipe_has_all_sections_that_conda_forge_requires():
    assert set(RECIPE) == {"context", "package", "source", "build", "requirements", "tests", "about"}
    assert RECIPE["build"]["noarch"] == "python"
    assert (ROOT / RECIPE["about"]["license_file"]).is_file()
    assert RECIPE["about"]["license"] == PROJECT["license"]
    assert RECIPE["about"]["summary"] == PROJECT["description"]


@pytest.mark.parametrize("version", [RECIPE["context"]["version"], CITATION["version"], ZENODO["version"]])
def test_all_have_the_version_of_the_package(version):
    assert version == PROJECT["version"]


def test_zenodo_and_the_citation_agree():
    assert ZENODO["title"] == CITATION["title"]
    assert ZENODO["description"] == CITATION["abstract"]
    assert ZENODO["license"] == CITATION["license"] == PROJECT["license"]
    assert ZENODO["keywords"] == CITATION["keywords"] == PROJECT["keywords"]
    assert [one["name"] for one in ZENODO["creators"]] == [one["name"] for one in CITATION["authors"]]
    assert ZENODO["upload_type"] == CITATION["type"] == "software"


@pytest.mark.parametrize("name", BESIDE_US)
def test_a_package_beside_ecume_is_a_distribution_for_the_same_version(name):
    project = tomllib.loads((BESIDE_US[name] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["name"] == name.replace("_", "-")
    assert project["version"] == PROJECT["version"]
    assert project["dependencies"] == [f"ecume=={PROJECT['version']}"]
    assert {project[key] == PROJECT[key] for key in ("license", "requires-python", "authors")} == {True}


@pytest.mark.long
def test_each_source_file_is_in_one_wheel(tmp_path):
    contents = []
    for folder in (ROOT, *BESIDE_US.values()):
        place = tmp_path / folder.name
        command = [sys.executable, "-m", "hatchling", "build", "-d", str(place), "-t", "wheel"]
        subprocess.run(command, cwd=folder, check=True)
        (wheel,) = place.iterdir()
        with zipfile.ZipFile(wheel) as archive:
            contents.append({name for name in archive.namelist() if ".dist-info/" not in name})
    tracked = subprocess.run(["git", "ls-files", "src"], cwd=ROOT, capture_output=True, text=True, check=True)
    sources = {name.removeprefix("src/") for name in tracked.stdout.split()}
    packed = set().union(*contents)
    assert sum(map(len, contents)) == len(packed)
    assert {name for name in packed if not name.startswith("ecume/benchmarks/")} == {
        name for name in sources if name.startswith(("ecume/", *(f"{other}/" for other in BESIDE_US)))
    }
    for name, content in zip(BESIDE_US, contents[1:], strict=True):
        assert all(path.startswith(f"{name}/") for path in content)


@pytest.mark.long
def test_two_wheels_of_one_commit_are_equal_and_have_valid_metadata(tmp_path):
    wheels = []
    for folder in (tmp_path / "one", tmp_path / "two"):
        command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder), "-t", "wheel"]
        subprocess.run(command, cwd=ROOT, env=os.environ | {"SOURCE_DATE_EPOCH": "1700000000"}, check=True)
        wheels += folder.iterdir()
        time.sleep(2.0)  # the resolution of times in a ZIP file
    assert wheels[0].read_bytes() == wheels[1].read_bytes()
    with zipfile.ZipFile(wheels[0]) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith("/METADATA"))
        written = archive.read(name)
    assert Metadata.from_email(written, validate=True).license_expression == "BSD-3-Clause"
    assert email.message_from_bytes(written)["Description-Content-Type"] == "text/markdown"
