"""The page on vocabulary names keys that exist, and every table of every model."""

import dataclasses
import re
import typing
from pathlib import Path

import pytest

from ecume.scenes.floating.sources import SOURCES
from ecume.scenes.schema import SCENES

PAGE = (Path(__file__).parents[2] / "docs" / "vocabulary.md").read_text(encoding="utf-8")
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line.startswith("| ")]
MODELS = [cell.strip("`") for cell in ROWS[0][1:]]
SHARED = {
    "gravity": ("floating", "sph", "soft", "tracers"),
    "liquid.name": ("floating", "sph", "soft", "tracers"),
    "liquid.temperature": ("floating", "sph", "soft", "tracers"),
    "liquid.density": ("floating", "sph", "soft", "tracers"),
    "liquid.viscosity": ("floating", "sph", "soft", "tracers"),
    "integration.integrator": ("floating", "sph", "soft", "tracers"),
    "integration.time_step": ("floating", "sph", "tracers"),
    "hydrodynamics.drag": ("floating", "soft", "tracers"),
    "hydrodynamics.brownian": ("floating", "tracers"),
    "flow.velocity": ("floating", "tracers"),
    "flow.shear_rate": ("floating", "tracers"),
    "particles.radius": ("floating", "soft", "tracers"),
    "particles.density": ("floating", "soft", "tracers"),
    "particles.count": ("floating", "soft", "tracers"),
    "particles.positions": ("floating", "soft", "tracers"),
    "particles.name": ("floating", "soft", "tracers"),
    "particles.color": ("floating", "soft", "tracers"),
    "tank.low": ("sph", "tracers"),
    "tank.high": ("sph", "tracers"),
}
"""What is written in one way in all models that have it."""


def part_of(hint):
    """The table that an annotation describes; None where it describes a value."""
    if dataclasses.is_dataclass(hint):
        return hint
    return next((found for found in map(part_of, typing.get_args(hint)) if found is not None), None)


def has(kind, path):
    """Whether a key exists in the schema."""
    for key in path.split("."):
        hints = typing.get_type_hints(kind) if kind is not None else {}
        if key not in hints:
            return False
        kind = part_of(hints[key])
    return True


def keys_in(cell):
    return [key for key in re.findall(r"`([a-z_.]+)`", cell) if key not in SOURCES]


@pytest.mark.parametrize("model", MODELS)
def test_every_key_of_the_table_exists(model):
    named = [key for row in ROWS[1:] for key in keys_in(row[1 + MODELS.index(model)])]
    assert len(named) > 20
    assert [key for key in named if not has(SCENES[model], key)] == []


@pytest.mark.parametrize("model", MODELS)
def test_every_table_of_a_model_is_in_its_column(model):
    named = {key.split(".")[0] for row in ROWS[1:] for key in keys_in(row[1 + MODELS.index(model)])}
    assert {field.name for field in dataclasses.fields(SCENES[model])} - named == set()


def test_the_table_has_a_column_for_each_model():
    assert set(MODELS) == set(SCENES)
    assert all(len(row) == 1 + len(MODELS) for row in ROWS)


@pytest.mark.parametrize("path", SHARED)
def test_one_thing_is_written_in_one_way(path):
    assert tuple(model for model in MODELS if has(SCENES[model], path)) == SHARED[path]
