"""Scenes as text: what is read from it is the same scene to the last bit."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ecume
from ecume.errors import BadInput, SceneError
from ecume.scenes import writing
from ecume.scenes.schema import Scene, from_plain, scene_hash, to_plain
from ecume.scenes.templates import folder
from ecume.scenes.writing import spelled, to_toml, write_scene
from ecume.units import Unit

ROOT = Path(__file__).parents[2]
FILES = sorted([*(ROOT / "examples").glob("*.toml"), *Path(str(folder())).glob("*.toml")])
UNITS = ["m", "s", "m/s", "Pa*s", "N/m", "N", "Pa", "1/s", "rad", "K", "m/s^2", "A*m^2", "J", "kg/m^3", "1"]


def read_again(scene: Scene, *, defaults: bool = False) -> Scene:
    return ecume.load_scene(to_toml(scene, defaults=defaults))


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_every_template_and_example_is_read_again(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ECUME_SCENE_FOLDERS", str(file.parent))
    scene = ecume.load_scene(file)
    for again in (ecume.load_scene(write_scene(scene, tmp_path / "a.toml")), read_again(scene, defaults=True)):
        assert again == scene
        assert scene_hash(again) == scene_hash(scene)


@pytest.mark.parametrize("name", ["cereal-bowl", "dam-break", "sheared-packing", "settling", "floating-bodies"])
def test_a_written_template_has_the_keys_and_units_of_the_template(name: str) -> None:
    text = (Path(str(folder())) / f"{name}.toml").read_text(encoding="utf-8")
    written = to_toml(ecume.load_scene(text)).splitlines()
    lines = [line.partition("  #")[0].strip() for line in text.splitlines()]
    expected = [line for line in lines if line and not line.startswith("#")]
    same = [line for line in expected if line in written]
    assert len(same) > 0.7 * len(expected), set(expected) - set(written)
    assert len(written) <= len(lines) + 5


def numbers(plain: object, path: tuple[object, ...] = ()) -> list[tuple[object, ...]]:
    """The paths of the floating-point numbers of a scene."""
    items = plain.items() if isinstance(plain, dict) else enumerate(plain) if isinstance(plain, list) else []
    found = [path] if isinstance(plain, float) else []
    return found + [one for key, value in items for one in numbers(value, (*path, key))]


PLAIN = [to_plain(ecume.load_scene(file)) for file in FILES if "raft-from-table" not in file.name]


@settings(max_examples=30)
@given(st.sampled_from(range(len(PLAIN))), st.data())
def test_a_random_scene_of_any_model_is_read_again(number: int, data: st.DataObject) -> None:
    plain = from_plain(PLAIN[number])
    changed = to_plain(plain)
    for path in data.draw(st.lists(st.sampled_from(numbers(changed)), min_size=1, max_size=6, unique=True)):
        table = changed
        for key in path[:-1]:
            table = table[key]  # type: ignore[index]
        table[path[-1]] *= data.draw(st.floats(0.5, 2.0))  # type: ignore[index]
    try:
        scene = from_plain(changed)
    except SceneError:
        return
    for again in (read_again(scene), read_again(scene, defaults=True)):
        assert again == scene
        assert scene_hash(again) == scene_hash(scene)


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(UNITS))
def test_a_number_with_a_unit_is_the_same_bits(value: float, unit: str) -> None:
    text = spelled(value, unit)
    assert repr(text if isinstance(text, float) else Unit(unit).number(text)) == repr(value)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.6, "m", "60 cm"),
        (0.0018, "m", "1.8 mm"),
        (2e-5, "m", "20 um"),
        (-1.61, "m", "-1.61 m"),
        (0.0, "m", "0 m"),
        (-0.0, "m", -0.0),
        (1e-12, "m", "0.001 nm"),
        (0.08, "s", "80 ms"),
        (1e4, "Pa", "10 kPa"),
        (math.radians(75), "rad", "75 deg"),
        (1.0, "rad", "1.0 rad"),
        (293.15, "K", "20 degC"),
        (998.2, "kg/m^3", 998.2),
        (5.0, "1/s", "5 s^-1"),
        (1 / 3, "m", "33.33333333333333 cm"),
        (1e-300, "m", 1e-300),
        (3.1e306, "rad", 3.1e306),
    ],
)
def test_units_have_a_fitting_size(value: float, unit: str, text: object) -> None:
    assert repr(spelled(value, unit)) == repr(text)


def test_long_lists_hold_plain_numbers_on_several_lines() -> None:
    positions = [[0.01 * k, 0.001] for k in range(40)]
    species = {"radius": 1e-3, "density": 600, "contact_angle": 1.0, "positions": positions, "color": "red"}
    scene = from_plain({"model": "floating", "duration": 1, "frame_every": 0.1, "particles": [species]})
    text = to_toml(scene)
    assert "    [0.0, 0.001], [0.01, 0.001]," in text
    assert 'color = "red"' in text
    assert max(map(len, text.splitlines())) <= 110
    assert ecume.load_scene(text) == scene


def test_text_with_quotes_and_letters_of_any_script_is_written() -> None:
    scene = ecume.scene("tracers", duration=1, frame_every=1, title='A "drop" \\ Öl 水', tank={"high": [1, 1]},
                        particles=[{"radius": 1e-3, "density": 1.0, "name": "水"}])  # fmt: skip
    assert read_again(scene) == scene


def test_a_file_is_replaced_with_force_only(tmp_path: Path) -> None:
    scene = ecume.load_scene(FILES[0])
    file = write_scene(scene, tmp_path / "new" / "scene.toml")
    with pytest.raises(BadInput, match="exists already; name another file, or pass force=True"):
        write_scene(scene, file)
    other = scene.replace("duration", "2 s")
    assert ecume.load_scene(write_scene(other, file, force=True)) == other


def test_a_scene_too_large_for_a_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = ecume.load_scene(FILES[0])
    monkeypatch.setattr(writing, "MOST_BYTES", 2**8)
    with pytest.raises(BadInput, match="scene file; keep the positions in a table and name it with particles_from"):
        write_scene(scene, tmp_path / "large.toml")
    assert not (tmp_path / "large.toml").exists()
