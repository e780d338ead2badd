"""Scenes from Python objects: quantities, arrays, dataclasses, and changes of single values."""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ecume
from ecume.errors import SceneError
from ecume.units import N, Pa, Quantity, Unit, cm, deg, degC, kg, m, mm, parse, percent, quantity_of, s

FLOAT = {"radius": 2 * mm, "density": 600 * kg / m**3, "contact_angle": 70 * deg}
KEYS = {"duration": 10 * s, "frame_every": (0.1, "s"), "liquid": "water", "dish": {"radius": "5 cm"}}


def bowl(**more: object) -> ecume.FloatingScene:
    return ecume.scene("floating", **{**KEYS, "particles": [{**FLOAT, "count": 3}], **more})  # type: ignore[arg-type]


def test_a_scene_from_objects_equals_that_of_a_file() -> None:
    text = """
        model = "floating"
        duration = "10 s"
        frame_every = "0.1 s"
        liquid = "water"
        particles = [{ radius = "2 mm", density = 600, contact_angle = "70 deg", count = 3 }]
        dish = { radius = "5 cm" }
    """
    assert bowl() == ecume.load_scene(text)


@pytest.mark.parametrize(
    ("quantity", "written"),
    [
        (2 * mm, "2 mm"),
        (-mm, "-1 mm"),
        (3 * mm / s, "3 mm/s"),
        (1030 * kg / m**3, "1030 kg/m^3"),
        (1 / s, "1 s^-1"),
        (2 * (N / m) / 4, "0.5 N/m"),
        (mm * mm, "1 mm^2"),
        (Pa * s * 2, "2 Pa*s"),
        (Quantity(1, "J/(kg*K)") * kg, "1 J/K"),
        (cm / cm, "1 1"),
        (np.float64(1.5) * mm, "1.5 mm"),
        (m**-2, "1 m^-2"),
    ],
)
def test_products_and_quotients_have_combined_units(quantity: Quantity, written: str) -> None:
    assert repr(quantity) == written


@settings(deadline=None)
@given(st.floats(-1e300, 1e300))
def test_a_quantity_is_the_same_bits_as_its_text(value: float) -> None:
    assert Unit("m").number(value * mm) == parse(f"{value!r} mm", "m")


@pytest.mark.parametrize(
    ("quantity", "value"),
    [(2 * mm, 0.002), (70 * deg, math.radians(70)), (20 * degC, 293.15), (20 * percent, 0.2), (2 * mm / mm, 2.0)],
)
def test_a_quantity_converts_to_a_number_in_si_units(quantity: Quantity, value: float) -> None:
    assert float(quantity) == value


def test_lists_and_arrays_times_a_unit_are_lists_of_quantities() -> None:
    assert [[1, 2.5], [3, 4]] * mm == np.array([[1, 2.5], [3, 4]]) * mm == [[1 * mm, 2.5 * mm], [3 * mm, 4 * mm]]
    for wrong in ("2", None, ["2"]):
        with pytest.raises(TypeError, match="expected a number or lists of numbers"):
            wrong * mm  # type: ignore[operator]


def test_quantities_of_pint_are_accepted() -> None:
    units = pint.UnitRegistry()
    of_pint = bowl(
        particles=[{**FLOAT, "radius": units.Quantity(1.7, "mm"), "positions": units.Quantity([[0, 1]], "cm")}]
    )
    (species,) = of_pint.particles
    assert (species.radius, species.positions) == (0.0017, ((0.0, 0.01),))
    assert Unit("kg/m^3").number(units.Quantity(2, "g/cm**3")) == 2000.0
    assert Unit("K").number(units.Quantity(20, "degC")) == 293.15


@pytest.mark.parametrize(
    "positions",
    [
        [(1 * mm, 2 * mm), (9 * mm, "2 mm")],
        ([[1, 2], [9, 2]], "mm"),
        np.array([[1, 2], [9, 2]]) * mm,
        np.array([[0.001, 0.002], [0.009, 0.002]]),
    ],
)
def test_positions_may_be_arrays_and_pairs(positions: object) -> None:
    scene = bowl(particles=[{**FLOAT, "positions": positions}])
    assert scene.particles[0].positions == ((0.001, 0.002), (0.009, 0.002))


def test_tables_may_be_dataclasses_with_quantities() -> None:
    spec = ecume.FloatSpec(count=3, **FLOAT)  # type: ignore[arg-type]
    assert bowl(particles=[spec], dish=ecume.DishSpec(radius=0.05)) == bowl()


def test_vectors_and_temperatures_take_quantities() -> None:
    tank = {"low": [0 * m, 0 * m], "high": ([1, 2], "m")}
    sph = {"duration": 1, "frame_every": 1, "spacing": 10 * cm, "tank": tank, "fluid": [tank]}
    scene = ecume.scene("sph", gravity=(1.62, "m/s^2"), liquid={"name": "water", "temperature": 20 * degC}, **sph)  # type: ignore[arg-type]
    assert (scene.gravity, scene.tank.high, scene.liquid.temperature) == ((0.0, -1.62), (1.0, 2.0), 293.15)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"duration": 3 * mm}, "scene: duration: got 3 mm; 'mm' measures length, expected time as in '20 s'"),
        ({"particles": [{**FLOAT, "radius": (2, "kg")}]}, "scene: particles[0].radius: got 2 kg; 'kg' measures mass"),
        (
            {"particles": [{**FLOAT, "radius": -1 * mm}]},
            "scene: particles[0].radius: got -1 mm; expected 1e-08 or more",
        ),
        ({"dish": {"radius": math.nan * mm}}, "dish.radius: got nan mm; expected a finite number"),
        ({"particles": [], "particles_from": "nowhere"}, "scene: particles_from: 'nowhere' does not exist"),
        ({"dihs": {}}, "scene: dihs: no such key; did you mean dish?"),
    ],
)
def test_a_fault_of_an_object_names_its_path(changes: dict[str, object], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        bowl(**changes)
    assert message in str(caught.value)
    assert len(caught.value.faults) == 1


def test_a_dataclass_alone_has_the_messages_of_files() -> None:
    with pytest.raises(SceneError) as caught:
        ecume.FloatSpec(radius=-2 * mm, densty=1, contact_angle=1.0)  # type: ignore[arg-type, call-arg]
    assert str(caught.value).split("\n") == [
        "FloatSpec: radius: got -2 mm; expected 1e-08 or more",
        "FloatSpec: densty: no such key; did you mean density?",
    ]


def test_an_unknown_model_is_refused() -> None:
    with pytest.raises(SceneError, match="did you mean floating"):
        ecume.scene("floting", duration=1)


def test_a_changed_scene_is_validated_again() -> None:
    scene = bowl()
    assert scene.replace("dish.radius", "6 cm").dish == ecume.DishSpec(radius=0.06, law="meniscus")
    both = scene.replace({"particles[0].count": 7, "duration": 20 * s})
    assert (both.particles[0].count, both.duration, both.dish) == (7, 20.0, scene.dish)
    assert scene.replace("dish", None).dish is None
    assert scene == bowl()


def test_what_a_scene_did_not_state_follows_from_the_changes() -> None:
    scene = bowl()
    assert scene.interaction.charge == "nonlinear"
    assert scene.replace("theory", "linear").interaction.charge == "linear"
    placed = bowl(particles=[{**FLOAT, "positions": [[0, 0], [10, 0]] * mm}])
    assert placed.replace("particles[0].positions", [[0, 0]]).particles[0].count == 1


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("dish.radus", 1 * mm, "dish.radus: no such key; did you mean radius?"),
        ("particles[3].count", 1, "particles[3].count: particles is a list; expected one of it: particles[0]"),
        ("dish radius", 1, "dish radius: expected the path of a key, such as dish.radius"),
        ("dish.radius", -1, "dish.radius: got -1; expected more than 0"),
    ],
)
def test_a_change_that_cannot_be_is_refused(name: str, value: object, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        bowl().replace(name, value)  # type: ignore[arg-type]
    assert message in str(caught.value)


def test_representations_are_short() -> None:
    scene = bowl(title="A bowl", particles=[{**FLOAT, "count": 3, "name": "corks"}])
    assert repr(scene) == "FloatingScene('A bowl', 10 s, 101 frames, 3 corks)"
    assert repr(scene.liquid) == "LiquidSpec(name='water')"
    many = bowl(particles=[{**FLOAT, "positions": [[10.0 * k, 0.0] for k in range(9)]}], dish=None)
    assert "positions=<9 items>" in repr(many.particles[0])


def test_only_a_pair_of_a_number_and_a_unit_is_a_quantity() -> None:
    assert quantity_of((2, "mm")) == Quantity(2.0, "mm")
    assert [quantity_of(other) for other in ((2, 3), [2, "mm"], (True, "mm"), "2 mm", 2.0, None)] == [None] * 6
