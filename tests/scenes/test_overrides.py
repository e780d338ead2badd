"""Changes from the command line."""

from __future__ import annotations

import pytest

from ecume.errors import SceneError
from ecume.scenes.load import load_scene
from ecume.scenes.overrides import split

SCENE = """\
model = "floating"
duration = 1
frame_every = 0.1
[[particles]]
radius = "1 mm"
density = 600
contact_angle = 1
"""


@pytest.mark.parametrize(
    ("override", "path", "value"),
    [
        ("seed=3", ("seed",), 3),
        ("particles[0].count=10", ("particles", 0, "count"), 10),
        ("dish.radius=4 cm", ("dish", "radius"), "4 cm"),
        ('dish.radius="4 cm"', ("dish", "radius"), "4 cm"),
        ("dish.size=[1, 2]", ("dish", "size"), [1, 2]),
        ("hydrodynamics.drag=none", ("hydrodynamics", "drag"), "none"),
        ("title=a=b", ("title",), "a=b"),
        ("title=1\nmodel='x'", ("title",), "1\nmodel='x'"),
        ("title=" + "[" * 5000, ("title",), "[" * 5000),
        ("title=", ("title",), ""),
    ],
)
def test_an_override_is_a_path_and_a_toml_value_or_text(override: str, path: object, value: object) -> None:
    assert split(override) == (path, value)


def test_overrides_change_the_scene_and_make_tables_on_the_way() -> None:
    scene = load_scene(
        SCENE, ["particles[0].count=10", "dish.radius=4 cm", "particles[0].positions=[[0, 0]]", "particles[0].count=1"]
    )
    assert scene.particles[0].count == 1
    assert scene.dish is not None
    assert scene.dish.radius == 0.04


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("seed", "--set 'seed': expected key=value"),
        ("=3", "expected key=value"),
        ("floats[x].count=3", "expected key=value"),
        ("particles[1].count=3", "particles is a list; expected one of it: particles[0]"),
        ("particles.count=3", "particles is a list; expected one of it: particles[0]"),
        ("flots[0].count=3", "the scene has no flots"),
        ("duration.x=3", "the scene has no duration.x"),
        ("title=" + "x" * 20_000, "too long"),
        ("particles[0].cuont=3", "particles[0].cuont: no such key; did you mean count? (from --set)"),
        ("particles[0].radius=-1", "particles[0].radius: got -1; expected 1e-08 or more (from --set)"),
        ("dish.radius=4 kg", "dish.radius: got '4 kg'; 'kg' measures mass"),
    ],
)
def test_an_override_that_cannot_be_is_a_fault_without_a_line(override: str, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene(SCENE, [override])
    assert says in str(caught.value)
    assert "line" not in str(caught.value)
