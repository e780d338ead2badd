"""Scenes, plain data and TOML text."""

from __future__ import annotations

import dataclasses
import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecume.errors import SceneError
from ecume.scenes.floating import FloatingScene, FloatRow, FloatSpec, species_of
from ecume.scenes.load import load_scene
from ecume.scenes.schema import SCENES, from_plain, scene_hash, to_plain
from ecume.scenes.writing import to_toml

lengths = st.floats(1e-8, 1e3)
places = st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
speeds = st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
names = st.text(st.characters(exclude_categories=["C", "Z"]), max_size=10)
angles = st.one_of(
    st.fixed_dictionaries({"contact_angle": st.one_of(st.floats(0, math.pi), st.just("original-closure"))}),
    st.fixed_dictionaries(
        {"surface_energies": st.fixed_dictionaries({"solid_gas": st.floats(0, 1), "solid_liquid": st.floats(0, 1)})}
    ),
)
bodies = st.fixed_dictionaries({"radius": lengths, "density": st.floats(1e-3, 1e5)}).flatmap(
    lambda body: angles.map(lambda angle: {**body, **angle})
)
species = bodies.flatmap(
    lambda body: st.fixed_dictionaries(
        {},
        optional={"positions": st.lists(places, min_size=1, max_size=3), "velocity": speeds, "color": st.just("red")},
    ).map(lambda more: {**body, **more})
)
rows = bodies.flatmap(
    lambda body: st.fixed_dictionaries(
        {"x": lengths, "y": lengths}, optional={"vx": lengths, "species_name": names}
    ).map(lambda more: {**body, **more})
)
dishes = st.one_of(
    st.fixed_dictionaries({"radius": lengths}),
    st.fixed_dictionaries({"size": st.tuples(lengths, lengths)}, optional={"restitution": st.floats(0, 1)}),
)
scenes = st.fixed_dictionaries(
    {
        "model": st.just("floating"),
        "duration": st.integers(1, 1000).map(lambda frames: frames * 0.03),
        "frame_every": st.just(0.03),
        "particles": st.lists(species, min_size=1, max_size=3),
    },
    optional={
        "title": st.text(st.characters(exclude_categories=["C"]), max_size=20),
        "seed": st.integers(0, 2**63 - 1),
        "rows": st.lists(rows, max_size=3),
        "dish": dishes,
        "hydrodynamics": st.fixed_dictionaries({"drag": st.sampled_from(["stokes", "none"])}),
        "integration": st.fixed_dictionaries({"time_step": st.floats(1e-6, 0.03)}),
    },
)
anything = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.just("4 mm"), st.just(10**400)
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=8), inner, max_size=3)),
    max_leaves=6,
)


def bowl() -> dict[str, object]:
    species = {"count": 3, "radius": 0.001, "density": 600, "contact_angle": 1.0}
    return {"model": "floating", "duration": 1, "frame_every": 0.1, "particles": [species]}


@settings(max_examples=80)
@given(scenes)
def test_a_scene_survives_json_and_toml_to_the_last_bit(plain: dict[str, object]) -> None:
    scene = from_plain(plain)
    assert from_plain(json.loads(json.dumps(to_plain(scene)))) == scene
    again = load_scene(to_toml(scene))
    assert again == scene
    assert scene_hash(again) == scene_hash(scene)


def keys_of(kind: type) -> list[str]:
    return [field.name for field in dataclasses.fields(kind)]


@pytest.mark.long
@settings(max_examples=150)
@given(st.sampled_from([*keys_of(FloatingScene), "other"]), st.sampled_from([*keys_of(FloatSpec), "other"]), anything)
def test_whatever_stands_at_a_key_gives_a_scene_or_faults(key: str, inner: str, value: object) -> None:
    plain = bowl()
    for changed in ({**plain, key: value}, {**plain, "particles": [{**plain["particles"][0], inner: value}]}):  # type: ignore[index]
        try:
            scene = from_plain(changed)
        except SceneError:
            continue
        assert json.dumps(to_plain(scene), allow_nan=False)


@pytest.mark.parametrize("model", SCENES)
def test_every_key_of_a_scene_is_explained(model: str) -> None:
    import ast
    import inspect

    module = inspect.getmodule(SCENES[model])
    assert module is not None
    for piece in ast.parse(inspect.getsource(module)).body:
        if isinstance(piece, ast.ClassDef):
            for field, after in zip(piece.body, piece.body[1:], strict=False):
                if isinstance(field, ast.AnnAssign):
                    assert isinstance(after, ast.Expr), f"{piece.name}.{ast.unparse(field.target)} has no docstring"


def test_equal_scenes_have_one_hash_and_others_have_another() -> None:
    scene = from_plain(bowl())
    assert scene_hash(scene) == scene_hash(from_plain(bowl()))
    assert scene_hash(scene) != scene_hash(dataclasses.replace(scene, seed=1))


def test_a_scene_cannot_be_changed() -> None:
    scene = from_plain(bowl())
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.seed = 3  # type: ignore[misc]


def test_a_scene_made_in_python_is_checked_as_well() -> None:
    with pytest.raises(ValueError, match=r"radius: got -1\.0; expected 1e-08 or more"):
        FloatSpec(radius=-1.0, density=600.0, contact_angle=1.0)
    assert FloatSpec(radius="2 mm", density=600.0, contact_angle="90 deg").radius == 0.002  # type: ignore[arg-type]


def test_species_are_numbered_as_they_come() -> None:
    scene = from_plain(bowl())
    row = FloatRow(x=0.0, y=0.0, radius=0.001, density=1.0, contact_angle=1.0, species_name="b", color="red")
    assert species_of(dataclasses.replace(scene, rows=(row, row))) == [("float-1", None), ("b", "#d62728")]


def test_a_key_that_was_misspelt_is_not_called_missing_as_well() -> None:
    plain = bowl()
    plain["particles"] = [{"radios": 1, "density": 600, "contact_angle": 1.0}]
    with pytest.raises(SceneError) as caught:
        from_plain(plain)
    assert [fault.message for fault in caught.value.faults] == ["no such key; did you mean radius?"]


def test_a_flood_of_faults_is_cut_short() -> None:
    plain = bowl()
    plain["particles"] = [{"radius": -1}] * 1000
    with pytest.raises(SceneError) as caught:
        from_plain(plain)
    assert len(caught.value.faults) <= 501
    assert "more faults" in caught.value.faults[-1].message


@pytest.mark.parametrize("key", ["\x1b[31m", "a\nb", "x" * 5000, ""])
def test_a_hostile_key_is_reported_without_harm(key: str) -> None:
    with pytest.raises(SceneError) as caught:
        from_plain({**bowl(), key: 1})
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500
