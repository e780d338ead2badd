"""Templates that are changed, through `check` and ten steps: an answer in ten seconds and 1 GB, and no traceback."""

from __future__ import annotations

import contextlib
import copy
import json
import math
import os
import random
import resource
import signal
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba

from ecume import _variants
from ecume._jit import use_threads
from ecume.errors import EcumeError
from ecume.models import MODELS
from ecume.scenes.templates import folder as templates
from ecume.scenes.valid_part import load_and_examine
from ecume.simulation import Integration

from .inputs import VALUES, mutant
from .trials import CHILDREN, Outcome, Trial, ended, forked, times

STEPS = 10
LARGEST_MEMORY = 1e9
"""Resident bytes, those of Python and its libraries included."""
LIMIT = 10
"""Seconds of processor time for a scene."""
COMPILING = 300
"""Seconds of processor time where functions are compiled first."""
OUT_OF_TIME = (-signal.SIGXCPU, -signal.SIGKILL, -signal.SIGALRM)
FACTORS = (0.0, -1.0, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e6, 1e12, 1e300, math.inf, math.nan)
LARGEST = 300
"""Particles of the scenes that are integrated: larger templates are checked alone."""
ONE_STEP = {"soft": 0}
"""What asks a model for one step, where that is not 1: a tick of soft spheres may have thousands."""


def mutated_values(scale: float, folder: Path) -> Outcome:
    """One to three numbers of a template multiplied by something."""
    chance, tried, survived, missed = random.Random(24), times(scale, 10_000), 0, []
    known = {
        path.stem: tomllib.loads(path.read_text(encoding="utf-8"))
        for path in sorted(Path(str(templates())).glob("*.toml"))
    }
    numba.config.THREADING_LAYER = "workqueue"  # others end the processes that are forked
    use_threads(1)
    for plain in known.values():
        stepped(toml_of(plain))  # what is compiled is compiled once, and forked
    for _ in range(tried):
        name = chance.choice(list(known))
        changed = mutated(known[name], chance)
        verdict = tried_within(toml_of(changed))
        survived += not verdict
        if verdict:
            missed.append(f"{name}: {verdict}: {differences(known[name], changed)}")
    return Outcome(tried, survived, "; ".join(missed[:5]) or "each ended with an answer")


def mutated_scenes(scale: float, folder: Path) -> Outcome:
    """Keys, tables and bytes of a template: removed, doubled, taken from another one, replaced by anything."""
    chance, tried, survived, missed = random.Random(26), times(scale, 10_000), 0, []
    texts = [path.read_text(encoding="utf-8") for path in sorted(Path(str(templates())).glob("*.toml"))]
    known = [tomllib.loads(text) for text in texts]
    numba.config.THREADING_LAYER = "workqueue"  # others end the processes that are forked
    use_threads(1)
    # A compiler's memory would count as that of each child: another process compiles, this one reads what it stored.
    for plain in known:
        ended(forked(lambda plain=plain: bounded(toml_of(plain), COMPILING)))
        stepped(toml_of(plain))
    for number in range(tried):
        if chance.random() < SHARE_OF_BYTES:
            text = mutant(chance.choice(texts).encode(), chance).decode(errors="replace")
        else:
            text = toml_of(rearranged(chance.choice(known), known, chance))
        verdict = tried_within(text)
        survived += not verdict
        if verdict:
            missed.append(f"{number}: {verdict}")
            (folder.parent / f"{folder.name}-{number}.toml").write_text(text, encoding="utf-8")
    return Outcome(tried, survived, "; ".join(missed[:5]) or "each ended with an answer")


SHARE_OF_BYTES = 0.3
"""Of the scenes whose text is changed, as against their tables."""


def rearranged(plain: dict[str, Any], others: list[dict[str, Any]], chance: random.Random) -> dict[str, Any]:
    """A scene with one to three other keys or tables."""
    changed = copy.deepcopy(plain)
    for _ in range(chance.randint(1, 3)):
        places = list(places_of(changed))
        table, key = chance.choice(places)
        donor = chance.choice([other for other in others if other.get("model") == plain.get("model")])
        given, there = chance.choice(list(places_of(donor)))
        kind = chance.randrange(6)
        if kind == 0:
            del table[key]
        elif kind == 1:
            table[key] = chance.choice(VALUES)
        elif kind == 2:
            table[key] = copy.deepcopy(given[there])
        elif kind == 3 and isinstance(table, dict) and isinstance(given, dict):
            table[there] = copy.deepcopy(given[there])
        elif kind == 4 and isinstance(table[key], list) and table[key]:
            table[key] = [*table[key], copy.deepcopy(chance.choice(table[key]))]
        elif kind == 5 and is_quantity(table[key]):
            table[key] = multiplied(table[key], chance.choice(FACTORS))
    return changed


def places_of(plain: Any) -> Iterator[tuple[Any, Any]]:
    """Each table or list of a scene with each key of it."""
    for key, value in list(plain.items() if isinstance(plain, dict) else enumerate(plain)):
        yield plain, key
        if isinstance(value, (dict, list)):
            yield from places_of(value)


def tried_within(text: str) -> str:
    """What was wrong with the answer to a scene; empty where it came in time, with little memory."""
    code, memory = _ended(forked(lambda: bounded(text, LIMIT)))
    if code in OUT_OF_TIME or memory > LARGEST_MEMORY:
        # A change may select functions that were never compiled: that is done once, and stored.
        _ended(forked(lambda: bounded(text, COMPILING)))
        code, memory = _ended(forked(lambda: bounded(text, LIMIT)))
    return str(code) if code else f"{memory / 1e9:.2f} GB" if memory > LARGEST_MEMORY else ""


def _ended(child: int) -> tuple[int, float]:
    """Wait for a process; its exit code, or minus the signal that killed it, and its largest memory (bytes)."""
    _, status, used = os.wait4(child, 0)
    CHILDREN.discard(child)
    return os.waitstatus_to_exitcode(status), 1024.0 * used.ru_maxrss


def numbers_of(plain: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """The numbers of a scene, also those with a unit, and their paths."""
    items = plain.items() if isinstance(plain, dict) else enumerate(plain) if isinstance(plain, list) else ()
    for key, value in items:
        if isinstance(value, dict | list):
            yield from numbers_of(value, (*path, key))
        elif is_quantity(value):
            yield (*path, key), value


def is_quantity(value: Any) -> bool:
    """Whether it is a number, or a text of one with a unit."""
    return parts_of(value) is not None if isinstance(value, str) else type(value) in (int, float)


def parts_of(text: str) -> tuple[float, str] | None:
    """The number and the unit of a text, if it is a quantity."""
    number, _, unit = text.partition(" ")
    try:
        return float(number), unit
    except ValueError:
        return None


def mutated(plain: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """A scene with one to three other numbers."""
    changed = copy.deepcopy(plain)
    for path, value in chance.sample(known := list(numbers_of(plain)), min(len(known), chance.randint(1, 3))):
        at = changed
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = multiplied(value, chance.choice(FACTORS))
    return changed


def multiplied(value: Any, factor: float) -> Any:
    """A number, or a quantity, times a factor."""
    if isinstance(value, str):
        number, unit = parts_of(value) or (1.0, "")
        return f"{number * factor!r} {unit}"
    if isinstance(value, int) and math.isfinite(factor):
        return int(value * factor)
    return value * factor


def differences(one: Any, other: Any) -> str:
    """The numbers that differ."""
    there = dict(numbers_of(other))
    changed = [path for path, value in numbers_of(one) if there.get(path) != value]
    return ", ".join(f"{'.'.join(map(str, path))} = {there.get(path)}" for path in changed)


def bounded(text: str, limit: int) -> None:
    """A scene in this process, with bounded processor time (s)."""
    resource.setrlimit(resource.RLIMIT_CPU, (spent() + limit, spent() + limit))
    signal.alarm(20 * limit)
    _variants._FORKED.clear()  # one thread of the work queue runs in forks, too
    stepped(text)


def spent() -> int:
    """The processor time of this process, s."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return math.ceil(used.ru_utime + used.ru_stime)


def stepped(text: str) -> None:
    """What `check` reports of a scene, then its first steps."""
    try:
        with contextlib.chdir(str(templates())):
            scene = load_and_examine(text, [], lambda scene: MODELS[scene.model].summary(scene))
        model = MODELS[scene.model]
        parameters = model.parameters(scene)
        if sum(getattr(species, "count", 0) or 0 for species in getattr(scene, "particles", ())) > LARGEST:
            return
        state = model.start(scene, parameters)
        if len(state.position) <= LARGEST:
            integration = Integration(model, parameters, state, 0.25)
            for _ in range(STEPS):
                integration.go(ONE_STEP.get(scene.model, 1))
            integration.observe()
    except EcumeError:  # an answer
        return


def toml_of(plain: dict[str, Any]) -> str:
    """Plain tables as TOML."""
    return "\n".join(f"{key} = {value_of(value)}" for key, value in plain.items()) + "\n"


def value_of(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {value_of(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(value_of, value)) + "]"
    if isinstance(value, float):
        return "nan" if math.isnan(value) else ("inf" if value > 0 else "-inf") if math.isinf(value) else repr(value)
    return json.dumps(value)


TRIALS = (
    Trial("R24 mutated values", "numbers of templates changed, check and ten steps", mutated_values),
    Trial(
        "R26 mutated scenes, in full",
        "keys, tables and bytes of templates changed, check and ten steps",
        mutated_scenes,
    ),
)
