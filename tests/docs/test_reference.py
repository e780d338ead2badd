"""The reference of scenes: each key has a meaning, an example that is accepted, and an effect."""

import dataclasses
import importlib
import re
import sys
import tomllib
from pathlib import Path

import pytest
from pydantic import TypeAdapter, ValidationError

from ecume.scenes.schema import SCENES
from ecume.scenes.starts import StartSpec
from ecume.units import Unit

MAKING = Path(__file__).parents[2] / "docs" / "making"
LEAST = 3
"""Words of a meaning and of an effect."""
TO_DO: dict[str, int] = {}
"""Keys of each model that may still lack a meaning or an effect. These numbers only go down."""
sys.path.insert(0, str(MAKING))
scenes = importlib.import_module("scenes")
sys.path.pop(0)


def words(text):
    """The words of a text without its units, numbers and code."""
    plain = re.sub(r"`[^`]*`", "CODE", text)
    return [word for word in re.findall(r"[A-Za-z]+", plain) if not is_unit(word)]


def is_unit(word):
    """Whether a word is a unit."""
    try:
        Unit("1").number(f"1 {word}")
    except ValueError as fault:
        return "measures" in str(fault)
    return True


def keys(model):
    """Each key of a model, with its table."""
    for table in [*scenes.tables(SCENES[model]), scenes.Table("[start_from]", StartSpec)]:
        yield from ((table, field) for field in scenes.fields_of(table.kind))


def poor(field):
    """The missing parts of an entry."""
    faults = []
    if len(words(scenes.meaning_of(field))) < LEAST:
        faults.append("meaning")
    if len(words(scenes.effect_of(field))) < LEAST:
        faults.append("effect")
    return faults


@pytest.mark.long
@pytest.mark.parametrize("model", SCENES)
def test_every_key_has_a_meaning_and_an_effect(model):
    found = [f"{table.path}.{field.name}: {', '.join(poor(field))}" for table, field in keys(model) if poor(field)]
    assert len(found) <= TO_DO.get(model, 0), found


@pytest.mark.parametrize("says", ["m", "kg/m^3", "Pa s", "N/m; with `viscosity`", "", "A length (m). Effect: none."])
def test_an_entry_that_only_repeats_the_unit_is_refused(says):
    assert poor(scenes.Field("density", float, 1.0, says))


def accepted(field, sample):
    """Whether a value is valid for a key."""
    if sample.startswith(("[[", "[")) and re.fullmatch(r"\[+[a-z_]+\]+", sample):
        return True
    try:
        TypeAdapter(field.hint).validate_python(tomllib.loads(f"value = {sample}")["value"])
    except (ValidationError, tomllib.TOMLDecodeError):
        return False
    return True


@pytest.mark.parametrize("model", SCENES)
def test_every_example_is_accepted(model):
    samples = [(table, field, scenes.example_of(model, table, field)) for table, field in keys(model)]
    assert len(samples) > 40
    refused = [
        f"{table.path}.{field.name} = {sample}" for table, field, sample in samples if not accepted(field, sample)
    ]
    assert refused == []


def test_a_value_out_of_range_is_no_example():
    field = next(one for one in scenes.fields_of(SCENES["sph"]) if one.name == "spacing")
    assert accepted(field, '"2 cm"')
    assert not accepted(field, "-1")
    assert not accepted(field, '"2 kg"')


@pytest.mark.parametrize("model", SCENES)
def test_headings_are_concepts(model):
    headings = re.findall(r"^## (.*)$", scenes.page(model), re.MULTILINE)
    assert len(headings) > 5
    assert all(re.match(r"[A-Z][a-z]", heading) for heading in headings)


def test_every_model_has_all_its_tables():
    for model, kind in SCENES.items():
        named = {table.kind for table in scenes.tables(kind)}
        assert kind in named, model
        assert all(dataclasses.is_dataclass(each) for each in named)
