"""Scenes that nobody would write: mutated, generated, mistyped, absurd, hostile."""

from __future__ import annotations

import dataclasses
import random
import re
import resource
import tomllib
import typing
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import BadInput, SceneError
from ecume.models import MODELS
from ecume.scenes.load import load_scene
from ecume.scenes.schema import SCENES, from_plain
from ecume.scenes.templates import folder as templates

from .trials import Outcome, Trial, ended, forked, scene_of, times

ENDS = (b"[", b"{", b'"', b"\\", b"\0", b"\xff", b"=", b"1e999", b"-", b"nan", b"9" * 400, b"[[", b"\n", b"#", b"''''")
VALUES: tuple[Any, ...] = (
    0, -1, 1, 3, 1e-300, 1e300, float("inf"), float("nan"), -0.0, 10**400, "", "1 mm", "2 parsec", "9**9**9 m", "nan",
    True, None, [], [1, 2], [[1, 2], [3, 4]], {}, {"a": 1}, "x" * 10_000, "\0", "\u202e", [float("nan")], "70 deg",
)  # fmt: skip
"""What stands where a scene wants something."""


def texts() -> list[str]:
    """The scenes of all templates."""
    return [path.read_text(encoding="utf-8") for path in sorted(Path(str(templates())).glob("*.toml"))]


def mutated(scale: float, folder: Path) -> Outcome:
    """Bytes of scenes are changed, cut and repeated: a scene, or faults, and nothing else."""
    chance, known = random.Random(8), [text.encode() for text in texts()]
    tried = times(scale, 20_000)
    accepted = reported = 0
    file = folder / "scene.toml"
    for _ in range(tried):
        file.write_bytes(mutant(chance.choice(known), chance))
        try:
            load_scene(file)
            accepted += 1
        except SceneError as error:
            reported += bool(error.faults)
    return Outcome(tried, accepted + reported, f"{accepted} were scenes")


def mutant(content: bytes, chance: random.Random) -> bytes:
    """One to four changes."""
    for _ in range(chance.randint(1, 4)):
        place = chance.randrange(len(content) + 1)
        kind = chance.randrange(5)
        if kind == 0:
            content = content[:place] + chance.choice(ENDS) + content[place:]
        elif kind == 1:
            content = content[:place] + content[place + chance.randint(1, 20) :]
        elif kind == 2:
            content = content[:place] + bytes([chance.randrange(256)]) + content[place + 1 :]
        elif kind == 3:
            content = content[:place]
        else:
            content = content[:place] + content[max(place - 30, 0) : place] * 2 + content[place:]
    return content


def through_the_command(scale: float, folder: Path) -> Outcome:
    """The same through `ecume check`: code 0 or 2, no traceback."""
    chance, known = random.Random(9), [text.encode() for text in texts()]
    tried, survived, file = times(scale, 300), 0, folder / "scene.toml"
    for _ in range(tried):
        file.write_bytes(mutant(chance.choice(known), chance))
        done = CliRunner().invoke(app, ["cite", str(file)])
        survived += done.exit_code in (0, 2) and "Traceback" not in done.output
    return Outcome(tried, survived, "code 0 or 2")


def generated(model: str) -> Any:
    """Scenes whose keys are right and whose values are anything."""

    def trial(scale: float, folder: Path) -> Outcome:
        chance, tried, accepted, silent = random.Random(model), times(scale, 3000), 0, 0
        usual = [
            plain for plain in map(tomllib.loads, texts()) if plain["model"] == model and "particles_from" not in plain
        ]
        for _ in range(tried):
            plain = disturbed(chance.choice(usual), SCENES[model], chance)
            try:
                from_plain({**plain, "model": model})
                accepted += 1
            except SceneError as error:
                # A refusal that names nothing is no answer.
                silent += not error.faults or not all(fault.message for fault in error.faults)
        return Outcome(tried, tried - silent, f"{accepted} were scenes")

    return trial


def disturbed(plain: dict[str, Any], kind: Any, chance: random.Random) -> dict[str, Any]:
    """Some values replaced, some keys added, by what may stand in that part of a scene."""
    fields = [field.name for field in dataclasses.fields(kind)]
    changed = dict(plain)
    for name in chance.sample(fields, min(len(fields), chance.randint(1, 3))):
        piece = part_of(typing.get_type_hints(kind)[name])
        if piece is not None and chance.random() < 0.8:
            below = changed.get(name)
            if isinstance(below, list) and below and isinstance(below[0], dict):
                changed[name] = [disturbed(below[0], piece, chance), *below[1:]]
            else:
                changed[name] = disturbed(below if isinstance(below, dict) else {}, piece, chance)
        else:
            changed[name] = chance.choice(VALUES)
    return changed


def part_of(hint: Any) -> Any:
    """The dataclass somewhere in an annotation, if there is one."""
    if dataclasses.is_dataclass(hint):
        return hint
    return next((found for part in typing.get_args(hint) if (found := part_of(part)) is not None), None)


def typos(scale: float, folder: Path) -> Outcome:
    """Each key of each template with two letters changed about: refused, with the right key."""
    tried = survived = 0
    for text in texts():
        for line, key in keys_of(text):
            if tried >= times(scale, 10_000):
                break
            wrong = swapped(key)
            broken = text.split("\n")
            broken[line] = broken[line].replace(key, wrong, 1)
            tried += 1
            survived += refused_for(wrong, key, "\n".join(broken))
    return Outcome(tried, survived, "refused, with the line and the right key")


def keys_of(text: str) -> Iterator[tuple[int, str]]:
    """The keys that begin a line, and its number; a scene without its model is another matter."""
    for number, line in enumerate(text.split("\n")):
        match = re.match(r"([a-z_]{4,}) *=", line)
        if match and match[1] not in ("model", "particles_from"):
            yield number, match[1]


def swapped(key: str) -> str:
    """With its last two letters exchanged, or one letter more where they are equal."""
    return key[:-2] + key[-1] + key[-2] if key[-1] != key[-2] else key + "x"


def refused_for(wrong: str, key: str, text: str) -> bool:
    """Whether a fault names the wrong key, its line, and what was meant."""
    try:
        load_scene(text)
    except SceneError as error:
        return any(wrong in fault.path and key in fault.message and fault.line for fault in error.faults)
    return False


ABSURD = (
    ("floating", {"duration": 1e10, "frame_every": 1e-7}),
    ("floating", {"duration": 1e10, "frame_every": 1e3, "integration": {"time_step": 1e-9}}),
    ("floating", {"particles": [{"count": 99_000_000, "radius": 1e-3, "density": 600.0, "contact_angle": 1.0}]}),
    ("floating", {"particles": [{"count": 10**12, "radius": 1e-3, "density": 600.0, "contact_angle": 1.0}]}),
    ("floating", {"dish": {"radius": 1e-6}}),
    ("sph", {"spacing": 1e-6}),
    ("sph", {"spacing": 1e-300}),
    ("sph", {"duration": 1e9, "frame_every": 1e9}),
    ("sph", {"tank": {"low": [0.0, 0.0, 0.0], "high": [900.0, 900.0, 900.0]}, "gravity": [0.0, -9.81, 0.0],
             "fluid": [{"low": [0.0, 0.0, 0.0], "high": [900.0, 900.0, 900.0]}]}),
    ("soft", {"particles": [{"radius": 1e-3, "modulus": 1e6, "count": 1_000_000}], "films": {}, "cell": None}),
    ("tracers", {"particles": [{"radius": 1e-3, "density": 1.0, "count": 100_000_000}]}),
    ("tracers", {"duration": 1e10, "frame_every": 1e3, "integration": {"time_step": 1e-9}}),
)  # fmt: skip
MEMORY, MACHINE = 3 * 2**30, 16e9


def absurd(scale: float, folder: Path) -> Outcome:
    """Scenes that nobody could run are refused before anything of their size is laid out."""
    survived, missed = 0, []
    for number, (model, changes) in enumerate(ABSURD):
        code = ended(forked(lambda model=model, changes=changes: _prepared(model, changes)))
        survived += code == BadInput.exit_code
        missed += [f"{number}: {code}"] if code != BadInput.exit_code else []
    return Outcome(len(ABSURD), survived, "; ".join(missed) or f"with {MEMORY >> 30} GiB of address space to spare")


def _prepared(model: str, changes: dict[str, Any]) -> None:
    """All that comes before the first step, with bounded memory and time."""
    from ecume.scenes.schema import to_plain

    plain = {key: value for key, value in {**to_plain(scene_of(model)), **changes}.items() if value is not None}
    psutil.virtual_memory = lambda: SimpleNamespace(total=MACHINE)  # a common machine, whichever this is
    there = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (there + MEMORY, there + MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
    try:
        scene = from_plain(plain)
        parameters = MODELS[model].parameters(scene)
        MODELS[model].start(scene, parameters)
        MODELS[model].summary(scene)
    except SceneError as error:
        raise BadInput(" ".join(str(error).split())) from error


TRIALS = (
    Trial("R8 mutated scenes", "bytes of templates changed", mutated),
    Trial("R8 mutated scenes, command", "the same through the command line", through_the_command),
    *(Trial(f"R9 generated scenes, {model}", "right keys, any values", generated(model)) for model in SCENES),
    Trial("R10 typos", "each key of each template misspelled", typos),
    Trial("R11 absurd scenes", "refused before allocation", absurd),
)
