"""Folders of compiled code that are empty, cut, read-only, open to others, used by many at once, or of older text."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import ecume

from .states import digest_of
from .trials import SCENES, Outcome, Trial

PACKAGE = Path(ecume.__file__).parent
LAW = """
from ecume import _jit
from ecume.laws import friction

_jit.admit(friction)

@_jit.compiled
def exchanged(speed):
    return friction.impulse(speed, 2.0, 2.0, 0.5)

print(exchanged(4.0), sum(exchanged.stats.cache_hits.values()))
"""
RIGHT, EDITED = "6.0", "10.0"
FIRST_STEPS = SCENES["tracers"][0].format(duration="20 ms")


def caches(scale: float, folder: Path) -> Outcome:
    """The right answer, whatever became of the folder; code that is good is used, and an edited law is."""
    (folder / "law.py").write_text(LAW)
    kept = folder / "kept"
    output = {"empty": _answer(folder, kept) == [RIGHT, "0"], "kept": _answer(folder, kept) == [RIGHT, "1"]}
    for name, (spoil, hits) in SPOILED.items():
        place = folder / name
        shutil.copytree(kept, place)
        spoil(place)
        output[name] = _answer(folder, place) == [RIGHT, hits]
    output["nowhere"] = _answer(folder, folder / "law.py" / "below") == [RIGHT, "0"]
    output["four at once"] = _at_once(folder)
    output["edited"] = _edited(folder, kept)
    if scale >= 0.5:
        output["integrator cut"] = _march(folder)
    wrong = [name for name, right in output.items() if not right]
    return Outcome(len(output), len(output) - len(wrong), f"not {', '.join(wrong)}" if wrong else ", ".join(output))


def _begun(folder: Path, place: Path, package: Path = PACKAGE) -> subprocess.Popen[str]:
    """A process that asks a law, with its compiled code in a place."""
    environment = {**os.environ, "ECUME_CACHE_DIR": str(place), "PYTHONPATH": str(package.parent)}
    words, quiet = [sys.executable, str(folder / "law.py")], subprocess.DEVNULL
    return subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stderr=quiet, text=True)


def _answer(folder: Path, place: Path, package: Path = PACKAGE) -> Sequence[str]:
    return _begun(folder, place, package).communicate()[0].split()


def _at_once(folder: Path) -> bool:
    started = [_begun(folder, folder / "shared") for _ in range(4)]
    return all(one.communicate()[0].split()[:1] == [RIGHT] for one in started)


def _edited(folder: Path, place: Path) -> bool:
    """A law that is edited after its code was kept."""
    package = folder / "edited" / "ecume"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    law = package / "laws" / "friction.py"
    law.write_text(law.read_text().replace("(1.0 + restitution)", "(2.0 + restitution)"))
    return _answer(folder, place, package) == [EDITED, "0"]


def _march(folder: Path) -> bool:
    """All code of a integrator cut in half: the bits of one whose code is whole."""
    file = folder / "scene.toml"
    file.write_text(FIRST_STEPS)
    right = digest_of(file, 1, ECUME_CACHE_DIR=str(folder / "march"))
    _cut(folder / "march")
    return digest_of(file, 1, ECUME_CACHE_DIR=str(folder / "march")) == right


def _cut(place: Path) -> None:
    for path in place.rglob("*.code"):
        os.truncate(path, path.stat().st_size // 2)


def _empty(place: Path) -> None:
    for path in place.rglob("*.code"):
        os.truncate(path, 0)


def _lock(place: Path) -> None:
    for path in (place, *place.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)


def _open(place: Path) -> None:
    (place / "compiled").chmod(0o777)


SPOILED: dict[str, tuple[Callable[[Path], None], str]] = {
    "cut": (_cut, "0"),
    "emptied": (_empty, "0"),
    "read-only": (_lock, "1" if hasattr(os, "getuid") and os.getuid() == 0 else "0"),  # root writes all the same
    "open to others": (_open, "0"),
}
"""What is done to a folder, and how often what is left of it is used."""

TRIALS = (Trial("R18 caches", "compiled code cut, read-only, missing, open to others", caches),)
