"""The reading of quantities."""

from __future__ import annotations

import math
import subprocess
import sys
import time
import typing
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecume import units
from ecume.scenes.templates import copy_template
from ecume.units import (
    EXAMPLES,
    NAMED,
    NOT_PREFIXED,
    POWERS_OF_TEN,
    Unit,
    _in_base_units,
    _readable,
    base_of,
    example,
    factor,
    parse,
    same_dimension,
)

READINGS = [
    ("4 mm", "m", 0.004),
    ("1.7 mm", "m", 0.0017),
    ("2mm", "m", 0.002),
    ("-3.5e-2 km", "m", -35.0),
    ("5 μm", "m", 5e-6),
    ("70 deg", "rad", math.radians(70)),
    ("90°", "rad", math.pi / 2),
    ("1 g/cm^3", "kg/m^3", 1000.0),
    ("1 g/cm³", "kg/m^3", 1000.0),
    ("1030 kg m-3", "kg/m^3", 1030.0),
    ("1 cP", "Pa*s", 1e-3),
    ("2 mPa s", "Pa*s", 2e-3),
    ("2 mPa·s", "Pa*s", 2e-3),
    ("1 kg/(m*s)", "Pa*s", 1.0),
    ("72.8 dyn/cm", "N/m", 0.0728),
    ("45 mJ/m**2", "N/m", 0.045),
    ("9.81 m/s2", "m/s^2", 9.81),
    ("20 %", "1", 0.2),
    ("1.5 min", "s", 90.0),
    ("1 in", "m", 0.0254),
    ("20 degC", "K", 293.15),
    ("-5.5 °C", "K", 267.65),
    ("68 degF", "K", 293.15),
    ("300 K", "K", 300.0),
    ("300 mK", "K", 0.3),
]


@pytest.mark.parametrize(("text", "symbol", "value"), READINGS)
def test_a_quantity_is_read_in_si(text: str, symbol: str, value: float) -> None:
    assert parse(text, symbol) == pytest.approx(value, rel=3e-16, abs=0.0)


@pytest.mark.parametrize(
    ("text", "symbol", "says"),
    [
        ("2 kg", "m", "measures mass, expected length"),
        ("4 mm", "s", "measures length, expected time"),
        ("20 %", "rad", "measures a plain number, expected an angle"),
        ("20 deg", "1", "measures an angle, expected a plain number"),
        ("1 mm", "kg/m^3", "expected mass / length ** 3"),
        ("70", "rad", "without a unit"),
        ("7", "1", "without a unit"),
        ("four mm", "m", "is not a quantity"),
        ("", "m", "is not a quantity"),
        ("nan m", "m", "is not a quantity"),
        ("inf m", "m", "is not a quantity"),
        ("٣ mm", "m", "is not a quantity"),
        ("1e999 m", "m", "too large"),
        ("1e308 Mm", "m", "too large"),
        ("20 degC", "K/m", "offset"),
        ("3 parsnips", "m", "no such unit"),
        ("2 m + 3 m", "m", "not how a unit is written"),
        ("1,5 mm", "m", "the decimal separator is a point"),
        ("1 m;2 m", "m", "not how a unit is written"),
        ("1 __import__('os')", "m", "not how a unit is written"),
        ("1 __class__", "m", "no such unit"),
        ("1 " + "m" * 60, "m", "is not a quantity"),
    ],
)
def test_what_is_no_such_quantity_is_refused_with_its_reason(text: str, symbol: str, says: str) -> None:
    with pytest.raises(ValueError, match=says.replace("*", r"\*")):
        parse(text, symbol)


@pytest.mark.parametrize(
    "bomb",
    [
        "9**9**9 m",
        "1 m^99999",
        "1 m**9**9**9",
        "1 m^9^9^9",
        "1 m^(9^9)",
        "1 m*9**9**9",
        "1 (m^9)^9",
        "9e999 m^9",
        "1 m9999999",
    ],
)
def test_a_bomb_of_exponents_is_refused_at_once(bomb: str) -> None:
    parse("1 m", "m")  # Pint's registry is made
    began = time.process_time()
    with pytest.raises(ValueError):
        parse(bomb, "m")
    assert time.process_time() - began < 1.0  # of the processor, however busy it is


@settings(max_examples=300)
@given(st.text(alphabet="0123456789.eE+-*/^() mkgsPaNrd°%µ_", max_size=45))
def test_any_text_is_a_finite_number_or_a_value_error(text: str) -> None:
    for symbol in ("m", "1"):
        try:
            value = parse(text, symbol)
        except ValueError:
            continue
        assert math.isfinite(value)


@given(st.floats(min_value=1e-6, max_value=1e6))
def test_millimeters_are_rounded_once(number: float) -> None:
    assert parse(f"{number!r} mm", "m") == float(Decimal(repr(number)).scaleb(-3))


def annotated() -> list[tuple[str, str]]:
    """Every annotation of the module with its symbol."""
    marks = {name: typing.get_args(kind)[1:] for name, kind in vars(units).items()}
    return [(name, mark.symbol) for name, found in marks.items() for mark in found if isinstance(mark, Unit)]


@pytest.mark.parametrize(("name", "symbol"), annotated())
def test_every_annotation_has_an_example_that_can_be_read(name: str, symbol: str) -> None:
    assert math.isfinite(parse(example(symbol), symbol)), name


def test_the_examples_belong_to_units_that_are_used() -> None:
    assert EXAMPLES.keys() - {symbol for _, symbol in annotated()} <= {"1/s"}


def test_a_factor_has_no_noise_in_its_last_digit() -> None:
    assert factor("l", "m^3") == 0.001
    assert factor("g/cm^3", "kg/m^3") == 1000.0


@pytest.mark.parametrize("value", [True, None, [1.0], {"m": 1}])
def test_a_scenes_number_is_a_number_or_text(value: object) -> None:
    with pytest.raises(ValueError, match="expected a number, or text with a unit such as '4 mm'"):
        Unit("m").number(value)


def test_a_whole_number_beyond_all_floats_is_refused() -> None:
    with pytest.raises(ValueError, match="too large"):
        Unit("m").number(10**400)


PREFIXED = sorted({prefix + name for name in NAMED for prefix in ("", *POWERS_OF_TEN)} - NOT_PREFIXED)


@pytest.mark.long
@settings(max_examples=400)
@given(st.data())
def test_a_product_of_prefixed_units_is_what_pint_makes_of_it(data: st.DataObject) -> None:
    """Pint is asked for its own units only."""
    power = st.sampled_from(["", "2", "^2", "**3", "^-1", "-2"])
    factors = data.draw(st.lists(st.builds(str.__add__, st.sampled_from(PREFIXED), power), min_size=1, max_size=3))
    signs = sorted(data.draw(st.lists(st.sampled_from(["*", " ", "/"]), min_size=2, max_size=2)), key="* /".index)
    unit = factors[0] + "".join(sign + each for sign, each in zip(signs, factors[1:], strict=False))
    found, expected = base_of(unit), _in_base_units(_readable(unit, "m"), "m")
    assert found is not None
    assert float(found.value) == pytest.approx(expected.magnitude, rel=1e-12)
    pints = {SYMBOLS[name]: power for name, power in expected.units._units.items()}
    assert found.powers == pints
    assert same_dimension(unit, "*".join(f"{name}^{power}" for name, power in pints.items()) or "m/m")


SYMBOLS = {"meter": "m", "kilogram": "kg", "second": "s", "kelvin": "K", "ampere": "A", "radian": "rad"}


@pytest.mark.parametrize("unit", ["dyn/cm", "inch", "mol", "ft", "%", "1", "m^", "m/", "(m)", "m(s)", "mmin", "cd"])
def test_units_that_only_pint_knows_are_left_to_it(unit: str) -> None:
    assert base_of(unit) in (None, (1, {}))


def test_a_degree_is_a_fraction_of_a_turn() -> None:
    assert factor("deg", "rad") == math.pi / 180.0 == pytest.approx(factor("degree", "rad"), rel=1e-15)
    assert not same_dimension("rad/s", "1/s")
    assert same_dimension("dyn", "N")
    assert not same_dimension("inch", "s")


def test_a_template_is_read_without_waiting_for_pint(tmp_path: Path) -> None:
    reads = "import sys, ecume; ecume.load_scene(sys.argv[1]); sys.exit('pint' in sys.modules)"
    (scene,) = copy_template("cereal-bowl", tmp_path / "bowl.toml")
    subprocess.run([sys.executable, "-c", reads, str(scene)], check=True, timeout=200)
