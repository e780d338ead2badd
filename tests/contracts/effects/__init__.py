"""For each key of each model: a scene in which it matters, and a value that changes what the run or a picture shows.

A key without an entry fails `tests/contracts/test_no_dead_keys.py`. An entry is a new value of the key, and the changes
to the model's base scene beside which it matters.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

RUN, PICTURE, EXPORT, FILES, REFUSED, STOPS = "run", "picture", "export", "files", "refused", "stops"


class Effect(NamedTuple):
    """A change of one key."""

    value: Any
    """None removes the key"""
    beside: dict[str, Any]
    """changes to the base scene, before"""
    shows: str
    """`run`: in the recorded frames; `picture`: in titles, colors and legends; `export`: in exported files; `files`:
    in the files of a run; `refused`: the scene is refused with or without the change; `stops`: the run ends earlier"""


def of(value: Any, shows: str = RUN, **beside: Any) -> Effect:
    """An effect, with tables of the scene beside it."""
    return Effect(value, beside, shows)


def grid(name: str, scale: float = 1.0) -> str:
    """A file with two instants of a rotating flow."""
    path = Path(tempfile.gettempdir()) / f"ecume-effects-{os.getpid()}-{name}.npz"
    x, t = np.linspace(0.0, 0.02, 5), np.array([0.0, 1.0])
    along, up = np.meshgrid(x, x, indexing="ij")
    u, v = -scale * (up - 0.01), scale * (along - 0.01) + 0.3 * along * (along - 0.02)
    arrays = {"x": x, "y": x, "t": t, "u": np.stack([u, 2.0 * u]), "v": np.stack([v, 2.0 * v])}
    arrays |= {"other": 0.9 * x, "tau": 2.0 * t, "w": 2.0 * arrays["v"]}
    np.savez(path, **arrays)
    return str(path)


def push(distance: float, parameters: Any) -> float:
    """A pair law (N)."""
    strength: float = parameters.constants[0]
    return strength / distance


def hold(distance: float, parameters: Any) -> float:
    """Another pair law (N)."""
    strength: float = parameters.constants[0]
    return -strength * distance


def drift(position: Any, velocity: Any, time: float, parameters: Any) -> tuple[float, float]:
    """An external law (m/s^2)."""
    return parameters.constants[0], 0.0


def lift(position: Any, velocity: Any, time: float, parameters: Any) -> tuple[float, float]:
    """Another external law (m/s^2)."""
    return 0.0, parameters.constants[0]


LAWS = (push, hold, drift, lift)
"""User laws of scenes that name them."""
SAMPLES = {"output": {"samples": {"every_steps": 2, "block": 2, "numbers": ["kinetic_energy"]}}}
OUTPUT = {
    "output.quantities": of(["position"], FILES),
    "output.precision": of("single", FILES),
    "output.samples.every_steps": of(3, FILES, **SAMPLES),
    "output.samples.block": of(1, FILES, **SAMPLES),
    "output.samples.numbers": of(["kinetic_energy", "total_energy"], FILES, **SAMPLES),
}
"""Of any model with time steps of one length, but for `output.samples.every`."""


def merged(one: Any, other: Any) -> Any:
    """Merge two plain trees; of a key that both set, the value of the second one, and no key where it is None. Lists of
    tables are merged table by table.
    """
    if isinstance(one, dict) and isinstance(other, dict):
        both = {key: merged(one.get(key), other[key]) if key in other else one[key] for key in {**one, **other}}
        return {key: value for key, value in both.items() if value is not None}
    if isinstance(one, list) and isinstance(other, list) and other and all(isinstance(part, dict) for part in other):
        rest = one[len(other) :]
        return [merged(one[index] if index < len(one) else {}, part) for index, part in enumerate(other)] + rest
    return merged({}, other) if isinstance(other, dict) else other
