"""Builds a wheel of compiled code: `ecume_compiled`, which ecume reads before the user's cache.

    python packaging/compiled/build.py FOLDER [TEMPLATE ...]     all templates and examples unless some are named

Each scene is run for one step and one frame. The compiled code that it used goes into the package, without the parts
that are contained in other compiled code. The wheel serves one minor version of Python, one version of Numba and one
instruction set: elsewhere the keys of the files differ, and everything is compiled as if it were not there.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import sysconfig
import tempfile
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

import ecume
from ecume import _cache
from ecume.simulation import moments, simulate

SERVED = "whole-"
"""How the names of files begin that a run reads when nothing has to be compiled."""
EXAMPLES = Path(__file__).parents[2] / "examples"
PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "ecume-compiled"
version = "{version}"
description = "Compiled code of ecume, so that the first run need not wait for the compiler"
license = "BSD-3-Clause"
requires-python = "=={python}.*"
dependencies = ["ecume=={ecume}", "numba=={numba}"]
[tool.hatch.build.targets.wheel]
packages = ["ecume_compiled"]
[tool.hatch.build.targets.wheel.hooks.custom]
path = "tag.py"
"""
TAG = """
from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Tag(BuildHookInterface):
    def initialize(self, version, build_data):
        build_data["pure_python"] = False
        build_data["tag"] = "{tag}"
"""


def scenes(names: list[str]) -> list[Path]:
    """The files of the templates with these names; of all templates and examples if none is named."""
    folder = Path(str(files("ecume") / "templates"))
    if names:
        return [folder / f"{name}.toml" for name in names]
    return sorted(folder.glob("*.toml")) + sorted(EXAMPLES.glob("*.toml"))


def use(scene_file: Path) -> None:
    """Run a scene for one step, and make its first frame."""
    scene = ecume.load_scene(scene_file)
    next(iter(simulate(scene)))
    next(moment for moment in moments(scene) if moment.step > 0)


def fill(package: Path, names: list[str]) -> int:
    """Write the package of the code that scenes use; how many files it has."""
    for scene_file in scenes(names):
        use(scene_file)
    served = sorted({name for name in _cache.used if name.startswith(SERVED)})
    checksums = {}
    package.mkdir()
    for name in served:
        whole = (_cache.root() / name).read_bytes()
        (package / name).write_bytes(whole)
        checksums[name] = hashlib.sha256(whole).hexdigest()
    (package / _cache.MANIFEST).write_text(json.dumps({"files": checksums}, indent=0, sort_keys=True), encoding="utf-8")
    (package / "__init__.py").write_text('"""Compiled code of ecume; nothing here is imported."""\n', encoding="utf-8")
    return len(served)


def instruction_set() -> str:
    """The instruction set that code is compiled for, as a part of a version: letters and digits."""
    from numba.core.registry import cpu_target

    name = cpu_target.target_context.codegen().magic_tuple()[1]
    return "".join(letter for letter in name if letter.isalnum())


def main() -> None:
    """Build the wheel."""
    target, names = Path(sys.argv[1]).absolute(), sys.argv[2:]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        count = fill(folder / "ecume_compiled", names)
        python = f"{sys.version_info.major}.{sys.version_info.minor}"
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        ours, numba = version("ecume"), version("numba")
        text = PROJECT.format(version=f"{ours}+{instruction_set()}", python=python, ecume=ours, numba=numba)
        (folder / "pyproject.toml").write_text(text, encoding="utf-8")
        tag = f"cp{sys.version_info.major}{sys.version_info.minor}-none-{platform}"
        (folder / "tag.py").write_text(TAG.format(tag=tag), encoding="utf-8")
        built = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(target)]
        environment = {"SOURCE_DATE_EPOCH": "315532800", **os.environ}
        subprocess.run(built, cwd=folder, check=True, env=environment)
    print(f"{count} files of compiled code")


if __name__ == "__main__":
    main()
