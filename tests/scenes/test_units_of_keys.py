"""Every key with a number accepts each unit of its dimension, and no unit of another."""

import dataclasses
import math
import re
import typing

import pytest
from pydantic import TypeAdapter, ValidationError

from ecume.errors import SceneError
from ecume.scenes.quantities import ByDimension, Concentration, Frequency, Measured, TurningRate
from ecume.scenes.schema import SCENES, from_plain
from ecume.units import Unit

UNITS = {
    "m": ("mm", "inch", "foot"), "m/s": ("km/hour", "mm/s"), "m/s^2": ("cm/s^2",), "rad": ("deg", "mrad"),
    "s": ("ms", "hour"), "kg/m^3": ("g/cm^3", "g/l"), "Pa*s": ("mPa*s", "poise"), "N/m": ("mN/m", "dyn/cm", "J/m^2"),
    "Pa": ("kPa", "bar", "atm", "N/m^2"), "N": ("uN", "dyn"), "K": ("degC", "mK"), "1/s": ("Hz", "minute^-1"),
    "rad/s": ("rpm", "deg/s", "s^-1", "rad/min"),
    "kg": ("g", "lb"), "kg/m": ("g/cm",), "J": ("erg", "eV"), "N*m": ("uN*m",), "A*m^2": ("mA*m^2",), "T": ("mT",),
    "1": ("%",), "1/m^3": ("cm^-3", "l^-1"), "1/m^2": ("cm^-2",), "m^2": ("mm^2",), "m^2/s": ("cm^2/s",),
    "kg/s": ("g/s", "ug/minute"), "N*m/kg": ("J/kg", "mN*m/g"),
}  # fmt: skip
"""Other units of each dimension that keys have."""
ALIKE = ({"J", "N*m"}, {"J", "N*m"}), ({"rad/s"}, {"1/s"})
"""Units whose keys also accept others: torques are energies, and text may omit radians."""
PLAIN = {"constants"}
"""Numbers of user-defined and named laws, in SI units."""


def keys():
    """(model and path, annotation of one number, its mark) of every number in every scene."""
    return [one for model in ("floating", "soft", "sph", "tracers") for one in below(SCENES[model], model)]


def below(piece, path):
    hints = typing.get_type_hints(piece, include_extras=True)
    for field in dataclasses.fields(piece):
        yield from parts(hints[field.name], f"{path}.{field.name}")


def parts(hint, path):
    if dataclasses.is_dataclass(hint):
        yield from below(hint, path)
    elif typing.get_origin(hint) is typing.Annotated:
        inner, *marks = typing.get_args(hint)
        units = [mark for mark in marks if isinstance(mark, (Unit, Measured, ByDimension))]
        if units or inner is float:
            yield path, hint, units[0] if units else None
        else:
            yield from parts(inner, path)
    elif hint is float:
        yield path, hint, None
    else:
        for part in typing.get_args(hint):
            yield from parts(part, path)


def spelled(symbol):
    """A unit as text has it."""
    return re.sub(r"^1/(\w+)\^?(\d?)$", lambda found: f"{found[1]}^-{found[2] or 1}", symbol)


def accepts(hint, text):
    """Whether the unit of a number is accepted; its size may be out of range."""
    listed = typing.get_origin(typing.get_args(hint)[0]) is tuple
    for value in ([text, text], text) if listed else (text,):
        try:
            TypeAdapter(hint).validate_python(value)
        except ValidationError as error:
            message = str(error)
            if "measures" in message or "expected two or three" in message or "has an offset" in message:
                continue
        return True
    return False


KEYS = keys()


def test_every_number_has_a_unit():
    assert len(KEYS) > 200
    without = {path for path, _, mark in KEYS if mark is None and path.rpartition(".")[2] not in PLAIN}
    assert without == set()


@pytest.mark.parametrize("path", sorted({path for path, _, mark in KEYS if mark is not None}))
def test_a_key_accepts_the_units_of_its_dimension_and_no_other(path):
    for name, hint, mark in KEYS:
        if name != path or mark is None:
            continue
        own = {mark.plane, mark.space} if isinstance(mark, ByDimension) else {mark.symbol}
        for symbol in own:
            for unit in (spelled(symbol), *UNITS[symbol]) if symbol != "1" else UNITS["1"]:
                assert accepts(hint, f"0.5 {unit}"), (path, unit)
        alike = own.union(*(others for units, others in ALIKE if own & units))
        for symbol in UNITS.keys() - alike - {"1"}:
            assert not accepts(hint, f"0.5 {spelled(symbol)}"), (path, symbol)
        if "1" not in own:
            assert not accepts(hint, "50 %"), path


@pytest.mark.parametrize(("text", "expected"), [
    ("60 rpm", math.tau), ("360 deg/s", math.tau), ("2 rad/s", 2.0), ("2 1/s", 2.0), ("120 rad/min", 2.0),
    ("2 s⁻¹", 2.0),
])  # fmt: skip
def test_an_angular_velocity_may_omit_radians_but_is_no_number_of_turns(text, expected):
    assert TypeAdapter(TurningRate).validate_python(text) == pytest.approx(expected, rel=1e-12)
    for turns in ("1 Hz", "1 hertz", "2 kilohertz", "120/min", "120 min^-1", "1 1/h", "2/day"):
        with pytest.raises(ValidationError, match="counts turns; write for example '60 rpm'"):
            TypeAdapter(TurningRate).validate_python(turns)
    with pytest.raises(ValidationError, match="measures angle / time, expected 1 / time"):
        TypeAdapter(Frequency).validate_python("60 rpm")


@pytest.mark.parametrize("text", ["100 1/mL", "100/mL", "100 / mL", "100 mL^-1", "1e8 m⁻³", "100 cm⁻³"])
def test_a_number_per_volume_is_read_as_people_write_it(text):
    assert TypeAdapter(Concentration).validate_python(text) == pytest.approx(1e8, rel=1e-12)


TANK = {
    "model": "sph", "duration": "0.1 s", "frame_every": "50 ms", "spacing": "10 cm",
    "tank": {"low": [0, 0, 0], "high": [0.8, 0.8, 0.8]}, "fluid": [{"low": [0, 0, 0], "high": [0.8, 0.4, 0.8]}],
}  # fmt: skip


@pytest.mark.parametrize(("mass", "dimensions", "expected"), [("5 kg", 3, 5.0), ("500 g", 3, 0.5), ("94 g/cm", 2, 9.4)])
def test_the_mass_of_a_body_has_a_unit(mass, dimensions, expected):
    body = {"center": [0.4] * dimensions, "radius": "20 cm", "mass": mass}
    tank, fluid = (
        {key: value[:dimensions] for key, value in part.items()} for part in (TANK["tank"], TANK["fluid"][0])
    )
    made = from_plain(TANK | {"tank": tank, "fluid": [fluid], "bodies": [body]})
    assert made.bodies[0].mass == pytest.approx(expected)
    with pytest.raises(SceneError, match=rf"expected kg(/m)? in {dimensions}D"):
        from_plain(
            TANK
            | {"tank": tank, "fluid": [fluid], "bodies": [body | {"mass": "1 kg" if dimensions == 2 else "1 kg/m"}]}
        )
