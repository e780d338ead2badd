"""From text to a scene, or to all that is wrong with it."""

from __future__ import annotations

import copy
import functools
import os
import random
import subprocess
import sys
import time
import tomllib
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ecume.errors import Fault, SceneError
from ecume.scenes.load import MOST_BYTES, assembled, load_scene, located
from ecume.scenes.templates import copy_template, templates

BOWL = """\
model = "floating"
duration = "20 s"
frame_every = "50 ms"

[liquid]
density = 1030.0

[[particles]]
count = 40
radius = "1.5 mm"
density = 600.0
contact_angle = "70 deg"

[dish]
radius = "3 cm"
"""


def faults_of(text: str | Path, overrides: tuple[str, ...] = ()) -> tuple[Fault, ...]:
    with pytest.raises(SceneError) as caught:
        load_scene(text, overrides)
    return caught.value.faults


def test_a_scene_is_read_in_si_with_its_defaults() -> None:
    scene = load_scene(BOWL)
    assert (scene.duration, scene.frame_every, scene.seed) == (20.0, 0.05, 0)
    assert (scene.particles[0].name, scene.particles[0].count, scene.particles[0].radius) == ("float-1", 40, 0.0015)
    assert scene.dish is not None
    assert (scene.dish.radius, scene.dish.law) == (0.03, "meniscus")
    assert scene.liquid.surface_tension == 0.0728


def test_all_faults_are_reported_at_once_with_their_places() -> None:
    broken = BOWL.replace("1030.0", "-1").replace('"1.5 mm"', '"1.5 kg"').replace("[dish]\nradius", "[dish]\nradios")
    output = [(fault.path, fault.line, fault.column) for fault in faults_of(broken)]
    assert output == [("liquid.density", 6, 1), ("particles[0].radius", 10, 1), ("dish.radios", 15, 1)]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("tank.left.velocity=[0, 1, 3]", "got 3 numbers; the tank has 2 dimensions"),
        ("tank.left.velocity=[1, 0]", "got 1 m/s normal to the wall"),
        ("tank.front.velocity=[1, 0, 0]", "is a side of 3D tanks"),
        ("tank.back.slip=free", "is a side of 3D tanks"),
        ("tank.left.profile=parabolic", "is of an inflow; this side is"),
        ('tank.left={ kind = "open", velocity = [0, 1] }', 'is of a wall; this side is of kind = "open"'),
        ('fluid[0].flow="couette"', "expected one of taylor-green, standing-wave, poiseuille"),
    ],
)
def test_what_no_side_or_flow_can_be_is_reported_in_one_line(change: str, says: str) -> None:
    (fault,) = faults_of(TANK.replace("MEASURES", '["level"]'), (change,))
    assert says in fault.message


def test_a_liquid_by_its_name_alone_is_short_for_a_table() -> None:
    short = TANK.replace("MEASURES", '["level"]') + 'liquid = "water"\ntemperature = "30 degC"\n'
    whole = TANK.replace("MEASURES", '["level"]') + '[liquid]\nname = "water"\ntemperature = "30 degC"\n'
    assert load_scene(short) == load_scene(whole)
    (fault,) = faults_of(short.replace("30 degC", "30 m"))
    assert (fault.path, fault.line) == ("liquid.temperature", 8)


TANK = """\
model = "sph"
duration = 1
frame_every = 1
spacing = 0.1
tank = { low = [0, 0], high = [1, 1] }
fluid = [{ low = [0, 0], high = [1, 0.5] }]
gauges = [{ name = "P", position = [0.5, 0.1], quantities = MEASURES }]
"""


@pytest.mark.parametrize(
    ("measures", "says"),
    [
        ('["temp"]', "got 'temp'; expected one of pressure, hydrostatic_pressure"),
        ("[]", "expected a list of 1 or more"),
    ],
)
def test_a_list_whose_items_are_wrong_is_not_short_of_items_besides(measures: str, says: str) -> None:
    (fault,) = faults_of(TANK.replace("MEASURES", measures))
    assert says in fault.message


def test_a_message_says_what_came_what_was_wanted_and_the_way_out() -> None:
    (fault,) = faults_of(BOWL.replace("count", "cuont"))
    assert str(fault) == "line 9, column 1: particles[0].cuont: no such key; did you mean count?"
    (fault,) = faults_of(BOWL.replace('"1.5 mm"', '"1.5 kg"'))
    assert fault.message == "got '1.5 kg'; 'kg' measures mass, expected length as in '4 mm'"


@pytest.mark.parametrize(
    ("before", "after", "path", "says"),
    [
        ('"1.5 mm"', "nan", "particles[0].radius", "got nan; expected a finite number"),
        ('"1.5 mm"', "1e999", "particles[0].radius", "got inf; expected"),
        ('"1.5 mm"', "0", "particles[0].radius", "got 0; expected 1e-08 or more"),
        ('"1.5 mm"', '"-1 mm"', "particles[0].radius", "got '-1 mm'; expected 1e-08 or more"),
        ('"1.5 mm"', "true", "particles[0].radius", "got true; expected a number, or text with a unit"),
        ('"1.5 mm"', '"7"', "particles[0].radius", "text without a unit"),
        ('"1.5 mm"', "[1]", "particles[0].radius", "got 1 radii; expected one for each of 40 particles"),
        ('"1.5 mm"', "1979-05-27", "particles[0].radius", "expected a number"),
        ('"1.5 mm"', "0x" + "f" * 5000, "particles[0].radius", "got a whole number of 20000 bits"),
        ("= 40", "= 0", "particles[0].count", "expected 1 or more"),
        ("= 40", "= 1_000_000_000", "particles[0].count", "expected 50000000 or less"),
        ("= 40", "= 40.5", "particles[0].count", "expected a whole number"),
        ("= 40", '= "40"', "particles[0].count", "expected a whole number"),
        ('"70 deg"', "70", "particles[0].contact_angle", "plain numbers are radians: write '70 deg' for degrees"),
        ('"70 deg"', '"200 deg"', "particles[0].contact_angle", "from 0 to 180 deg"),
        ('contact_angle = "70 deg"', "", "particles[0]", "contact_angle or surface_energies; got neither"),
        ('"20 s"', '"1 ms"', "frame_every", "got 0.05 s, longer than the duration, 0.001 s"),
        ('"50 ms"', '"1 ns"', "frame_every", "more than 1e+07"),
        ("1030.0", "1e300", "liquid.density", "expected 100000 or less"),
        ("[dish]", "[dish]\nsize = [1, 1]", "dish", "got radius and size"),
        ("[dish]", "[dish]\nlaw = 3", "dish.law", "got 3; expected text"),
        ("[dish]", "[dish]\nlaw = '\\u001b[31m'", "dish.law", "contains characters that are not allowed"),
        ("[dish]", "[integration]\ntime_step = 1\n[dish]", "integration.time_step", "longer than frame_every"),
        ("[dish]", "[integration]\ntime_step = '1e-11 s'\n[dish]", "integration.time_step", "more than 1e+11"),
        ("[dish]", "[contacts]\nrestitution = 1.1\n[dish]", "contacts.restitution", "expected 1 or less"),
        ("[dish]", "[interaction]\naccuracy = 0\n[dish]", "interaction.accuracy", "expected 1e-12 or more"),
        (
            '"floating"',
            '"floatin"',
            "model",
            'expected one of "floating", "soft", "sph", "tracers"; did you mean floating?',
        ),
        ('model = "floating"', "", "model", "is missing"),
        ("count = 40", 'placement = "rng"', "particles[0].placement", "did you mean ring?"),
        ("count = 40", 'placement = "ring"', "particles[0].placement", "needs ring_radius"),
        ("count = 40", "spacing = 1", "particles[0].spacing", 'only with placement = "lattice"'),
        ("count = 40", "count = 3\npositions = [[0, 0]]", "particles[0].count", "got 3; there are 1 positions"),
        (
            "count = 40",
            "positions = [[0, 0], [1]]",
            "particles[0].positions[1]",
            "got a list of 1; expected a list of 2",
        ),
        ("count = 40", "positions = [[0, 0, 0]]", "particles[0].positions[0]", "expected a list of 2"),
        ("count = 40", 'color = "blu"', "particles[0].color", "expected a color"),
        ("count = 40", "surface_energies = {solid_gas = 1, solid_liquid = 1}", "particles[0]", "got both"),
        ("density = 1030.0", "gas_density = 2000", "liquid.gas_density", "expected less than that of the liquid"),
    ],
)
def test_a_value_that_cannot_be_is_refused(before: str, after: str, path: str, says: str) -> None:
    (fault,) = faults_of(BOWL.replace(before, after, 1))
    assert fault.path == path
    assert says in fault.message
    assert fault.line is not None


def test_a_scene_with_nothing_afloat_is_refused() -> None:
    (fault,) = faults_of('model = "floating"\nduration = 1\nframe_every = 1')
    assert "nothing afloat" in fault.message


def test_two_species_cannot_have_one_name() -> None:
    species = "[[particles]]\nname = 'a'\nradius = 1\ndensity = 1\ncontact_angle = 1\n"
    (fault,) = faults_of('model = "floating"\nduration = 1\nframe_every = 1\n' + species * 2)
    assert (fault.path, fault.line) == ("particles[1].name", 10)


def test_the_three_ways_to_a_contact_angle_can_be_said() -> None:
    assert load_scene(BOWL.replace("70 deg", "original-closure")).particles[0].contact_angle == "original-closure"
    young = BOWL.replace('contact_angle = "70 deg"', 'surface_energies = {solid_gas = "40 mN/m", solid_liquid = 0.01}')
    energies = load_scene(young).particles[0].surface_energies
    assert energies is not None
    assert (energies.solid_gas, energies.solid_liquid) == (0.04, 0.01)


def test_left_out_a_count_is_the_number_of_positions_or_one() -> None:
    assert load_scene(BOWL.replace("count = 40", "positions = [[0, 0], [1, 0]]")).particles[0].count == 2
    assert load_scene(BOWL.replace("count = 40", "")).particles[0].count == 1


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("model = ", "is not TOML"),
        ("x = " + "[" * 5000, "nested too deeply"),
        ("x = " + "{a=" * 3000, "nested too deeply"),
        ("x = " + "9" * 5000, "is not TOML"),
        ("a = 1\na = 2", "is not TOML"),
        ("# " + "x" * MOST_BYTES + "\n", "longer than 1 MiB"),
    ],
)
def test_text_that_is_no_toml_is_refused(text: str, says: str) -> None:
    (fault,) = faults_of(text + "\n")
    assert says in fault.message


@pytest.mark.parametrize(
    ("line", "meant"),
    [("radius = 1.5 mm  # a cereal", "1.5 mm"), ("duration=20s", "20s"), ("model = floating", "floating")],
)
def test_text_without_quotes_is_reported_with_them(line: str, meant: str) -> None:
    (fault,) = faults_of(f"seed = 1\n{line}\n")
    assert fault.message.endswith(f'need quotes: "{meant}"')
    assert fault.line == 2


@pytest.mark.parametrize("line", ["radius == 3", "a = [1, 2", 'title = "bowl', "radius = ", "a = {b = 1", "=1"])
def test_quotes_are_not_the_cure_of_other_faults(line: str) -> None:
    (fault,) = faults_of(f"seed = 1\n{line}")
    assert "quotes" not in fault.message


def test_a_syntax_fault_has_its_line_and_column() -> None:
    (fault,) = faults_of('model = "floating"\nduration == 3\n')
    assert (fault.line, fault.column) == (2, 11)
    (fault,) = faults_of('model = "floating"\ntitle = "bowl')
    assert (fault.line, fault.column) == (2, 14)


def test_thousands_of_unknown_keys_are_refused_without_reading_the_tables_for_each(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked, read = [], typing.get_type_hints
    monkeypatch.setattr(typing, "get_type_hints", lambda *given, **options: asked.append(1) or read(*given, **options))
    found = faults_of("\n".join(f"key_{number} = 1" for number in range(600)) + "\n" + BOWL)
    assert len(found) == 501
    assert len(asked) < 100


def test_a_file_must_be_utf8(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_bytes(b"model = 'floating'\ntitle = '\xff'\n")
    (fault,) = faults_of(file)
    assert str(fault) == "line 2, column 10: byte 0xff is not UTF-8 text"


def test_a_byte_order_mark_and_windows_line_ends_are_welcome(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_bytes(b"\xef\xbb\xbf" + BOWL.replace("\n", "\r\n").encode())
    assert load_scene(file) == load_scene(BOWL)


def test_what_is_no_file_is_refused_with_its_name(tmp_path: Path) -> None:
    for path, says in ((tmp_path / "none.toml", "No such file"), (tmp_path, "is a folder")):
        with pytest.raises(SceneError, match=says) as caught:
            load_scene(str(path))
        assert str(path) in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scene.toml")
    (fault,) = faults_of(tmp_path / "scene.toml")
    assert "is not a regular file" in fault.message


def test_a_file_above_the_limit_is_refused(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text("#" * (MOST_BYTES + 1))
    (fault,) = faults_of(tmp_path / "scene.toml")
    assert fault.message == "is larger than 1 MiB"


def test_faults_of_a_model_get_their_places_too(tmp_path: Path) -> None:
    file = tmp_path / "bowl.toml"
    file.write_text(BOWL)
    found = SceneError([Fault("particles[0].density", "sinks"), Fault("dish.law", "no such law"), Fault("", "odd")])
    output = located(found, file)
    assert [fault.line for fault in output.faults] == [11, 14, None]
    assert output.source == str(file)


def corrupted(text: str, chance: random.Random) -> bytes:
    """The text with a few bytes changed, lost, doubled or moved."""
    data = bytearray(text.encode())
    for _ in range(chance.randint(1, 6)):
        at = chance.randrange(len(data))
        piece = bytes(data[at : at + chance.randint(1, 30)])
        kind = chance.randrange(5)
        if kind == 0:
            data[at] = chance.randrange(256)
        elif kind == 1:
            del data[at : at + len(piece)]
        elif kind == 2:
            data[at:at] = piece
        elif kind == 3:
            data[at:at] = chance.choice(
                [b"[", b"{", b'"', b"=", b"\n", b"9" * 20, b"-", b"nan", b"inf", b"[[a]]", b"e9"]
            )
        else:
            data += piece
    return bytes(data)


def faults_or_none(file: Path) -> tuple[Fault, ...]:
    """The faults of a file; none when it is a scene."""
    try:
        load_scene(file)
    except SceneError as error:
        return error.faults
    return ()


@pytest.mark.long
def test_corrupted_scenes_give_scenes_or_faults_with_places(tmp_path: Path) -> None:
    chance = random.Random(2)
    file = tmp_path / "scene.toml"
    texts = [copy_template(name, tmp_path / f"{name}.toml")[0].read_text() for name in templates()]
    found = []
    for number in range(400):
        file.write_bytes(corrupted(texts[number % len(texts)], chance))
        found.append(faults_or_none(file))
    assert all(fault.message and fault.line for faults in found for fault in faults)
    assert found.count(()) < 100


STRANGE = (["floating"], {"a": 1}, [], {}, 5, -1, "x", "", True, [[1, 2], [3]], [{"a": 1}], "1 mm", ["1 mm", "x"])


def places_in(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of everything below a value."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, below in pairs:
        yield (*at, key)
        yield from places_in(below, (*at, key))


def test_a_value_of_another_kind_anywhere_is_a_fault_or_a_scene(tmp_path: Path) -> None:
    chance = random.Random(3)
    tables = [tomllib.loads(copy_template(name, tmp_path / f"{name}.toml")[0].read_text()) for name in templates()]
    for table in tables:
        for place in [("model",), *chance.sample(list(places_in(table)), 12)]:
            raw = copy.deepcopy(table)
            piece = functools.reduce(lambda part, key: part[key], place[:-1], raw)
            piece[place[-1]] = copy.deepcopy(STRANGE[0] if place == ("model",) else chance.choice(STRANGE))
            scene, faults = assembled(raw, tmp_path)
            assert (scene is None) == bool(faults), place


@pytest.mark.parametrize(
    ("spin", "output"),
    [
        ("[1.0, 2.0]", "bodies[0].spin: got a list of 2; expected a list of 3"),
        ("[]", "bodies[0].spin: got a list of 0; expected a list of 3"),
        ("[1.0, 2.0, 'x']", "bodies[0].spin[2]: got 'x'"),
        ("[1e9, 0, 0]", "bodies[0].spin[0]: got 1000000000.0; expected 1e+06 or less"),
        ("1e9", "bodies[0].spin: got 1000000000.0; expected 1e+06 or less"),
        ("'abc'", "bodies[0].spin: got 'abc'"),
    ],
)
def test_a_fault_in_a_number_or_list_reports_the_expected_kind(spin: str, output: str, tmp_path: Path) -> None:
    (file,) = copy_template("floating-bodies", tmp_path / "bodies.toml")
    text = file.read_text().replace("[[bodies]]", f"[[bodies]]\nspin = {spin}", 1)
    with pytest.raises(SceneError) as refused:
        load_scene(text)
    (fault,) = refused.value.faults
    assert f"{fault.path}: {fault.message}".startswith(output)


@pytest.mark.parametrize("key", ["tuple[float]", "a[0]"])
def test_an_unknown_key_is_reported_even_where_it_looks_like_a_kind(key: str, tmp_path: Path) -> None:
    (file,) = copy_template("floating-bodies", tmp_path / "bodies.toml")
    text = file.read_text().replace("[[bodies]]", f"[[bodies]]\n'{key}' = [1.0]", 1)
    with pytest.raises(SceneError, match="no such key"):
        load_scene(text)


def test_reading_a_scene_imports_no_compiler() -> None:
    heavy = "[name for name in ('numba', 'matplotlib', 'gsd') if name in sys.modules]"
    code = f"import sys, ecume; ecume.load_scene({BOWL!r}); print({heavy})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_table_given_as_its_kind_alone_is_explained():
    text = TANK.replace("MEASURES", '["level"]') + '[liquid]\nname = "water"\n'
    text = text.replace("high = [1, 1] }", 'high = [1, 1], right = "outflow", left = "nonsense" }')
    with pytest.raises(SceneError) as error:
        load_scene(text)
    output = {fault.path: fault.message for fault in error.value.faults}
    assert output["tank.right"].endswith('expected a table of keys and values; write right = { kind = "outflow" }')
    assert output["tank.left"].endswith("expected a table of keys and values")


DEEP = {
    "2,000 parts": "a" + ".a" * 2_000 + " = 1\n",
    "100,000 parts": "a" + ".a" * 100_000 + " = 1\n",
    "in quotes": "x = { " + '",".' * 50_000 + "a = 1 }\n",
    "a table": "[" + "a." * 50_000 + "a]\n",
    "tables in tables": "a = " + "{ a = " * 80 + "1" + " }" * 80 + "\n",
}


@pytest.mark.parametrize("name", DEEP)
def test_keys_of_many_parts_are_refused_at_once(name):
    began = time.process_time()
    with pytest.raises(SceneError, match="is nested too deeply"):
        load_scene(DEEP[name])
    assert time.process_time() - began < 2.0  # of the processor, however busy it is


def test_dots_elsewhere_are_no_keys():
    text = "# " + "." * 200 + "\ntitle = '" + "a." * 40 + "'\npositions = [" + "1.0, " * 200 + "]\n"
    with pytest.raises(SceneError, match="model: is missing"):
        load_scene(text)
