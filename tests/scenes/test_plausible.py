"""Values that matter does not have: slips of a unit are remarked upon, and usual scenes are not."""

import itertools
import tomllib

import pytest

from ecume.scenes.faults import read_path
from ecume.scenes.plausible import RANGES, range_of, remarks
from ecume.scenes.templates import folder, templates

MEANT = {
    "floating": {
        "liquid.surface_tension": "45 mN/m", "liquid.density": "1.03 g/cm^3", "liquid.viscosity": "2 mPa*s",
        "liquid.gas_density": "0.0012 g/cm^3", "liquid.temperature": "20 degC", "gravity": "981 cm/s^2",
        "dish.radius": "4 cm", "dish.size": ["40 mm", "50 mm"], "particles[0].radius": "1.5 mm",
        "particles[0].density": "0.3 g/cm^3", "particles[0].positions": [["3 mm", "4 mm"]],
        "waves.headings": ["45 deg"],
        "activity.force": "2 uN", "magnetic_field.constant": "50 mT", "particles[0].shape.width": "2 mm",
        "particles[0].disc.angle": "30 deg", "dish.density": "2.5 g/cm^3",
        "surfactant.diffusivity": "1 cm^2/s", "surfactant.spacing": "0.75 mm", "surfactant.largest_fall": "34 mN/m",
        "surfactant.drops[0].radius": "3 mm", "surfactant.drops[0].position": ["12 mm", "0 mm"],
        "surfactant.drops[0].mass": "5 ug", "surfactant.sources[0].release": "2 ug/s",
        "particles[0].velocity": ["1 mm/s", "0 mm/s"],
    },
    "sph": {
        "liquid.surface_tension": "72.8 mN/m", "liquid.density": "1 g/cm^3", "liquid.viscosity": "1.5 mPa*s",
        "gravity": ["0 cm/s^2", "-981 cm/s^2"], "tank.high": ["500 mm", "300 mm"], "bodies[0].density": "0.5 g/cm^3",
        "liquid.atmospheric_pressure": "101.3 kPa", "fluid[0].velocity": ["150 cm/s", "0 cm/s"],
        "second_liquid.density": "0.8 g/cm^3", "second_liquid.viscosity": "1 mPa*s",
        "second_liquid.interface_tension": "50 mN/m", "gauges[0].diameter": "4.2 mm",
        "obstacles[0].radius": "75 mm", "bodies[0].center": ["400 mm", "500 mm"],
    },
    "soft": {
        "particles[0].modulus": "10 kPa", "particles[0].radius": "3 mm", "liquid.surface_tension": "30 mN/m",
        "long_range_forces.debye_length": "10 nm", "films.roughness": "5 um",
        "permeation.layer_height": "20 mm", "cell.size": ["10 mm", "35 mm"],
        "particles[0].positions": [["3 mm", "4 mm"]],
        "liquid.density": "1.03 g/cm^3", "liquid.temperature": "20 degC", "gravity": "981 cm/s^2",
    },
    "tracers": {
        "liquid.density": "1.03 g/cm^3", "liquid.viscosity": "2 mPa*s", "particles[0].radius": "5 um",
        "particles[0].density": "2.5 g/cm^3", "gravity": "981 cm/s^2", "liquid.temperature": "20 degC",
        "flow.speed": "200 cm/s", "particles[0].velocity": ["150 mm/s", "0 mm/s"],
    },
}  # fmt: skip
SLIPS = [(model, key, value) for model, keys in MEANT.items() for key, value in keys.items()]


def scene(model, key, value):
    """The plain data of a scene with one value."""
    raw = {"model": model}
    at, path = raw, read_path(key)
    for step, following in itertools.pairwise(path):
        if isinstance(following, int):
            at = at.setdefault(step, [{}])
        else:
            at = at[step] if isinstance(step, int) else at.setdefault(step, {})
    at[path[-1]] = value
    return raw


def without_unit(value):
    return [without_unit(item) for item in value] if isinstance(value, list) else float(value.split()[0])


@pytest.mark.parametrize(("model", "key", "value"), SLIPS)
def test_a_value_without_its_unit_gets_a_remark_that_names_the_unit(model, key, value):
    (found,) = remarks(scene(model, key, without_unit(value)))
    flat = value
    while isinstance(flat, list):
        flat = max(flat, key=lambda item: 0.0 if isinstance(item, list) else abs(float(item.split()[0])))
    assert found[0] == key
    assert "plain numbers are in SI units" in found[2]
    unit = found[2].rstrip("?").split()[-1]
    same_unit = flat.split()[1]
    lengths, speeds = {"um", "mm", "cm"}, {"mm/s", "cm/s"}  # which of them was meant nobody can know
    assert unit in next((each for each in (lengths, speeds) if same_unit in each), {same_unit})


@pytest.mark.parametrize(("model", "key", "value"), SLIPS)
def test_the_same_value_with_its_unit_gets_none(model, key, value):
    assert remarks(scene(model, key, value)) == []


def test_a_remark_states_the_factor_and_the_likely_unit():
    (found,) = remarks(scene("floating", "liquid.surface_tension", 45))
    text = "600 times that of water; plain numbers are in SI units: 45 mN/m?"
    assert found == ("liquid.surface_tension", "45 N/m", text)
    (stated,) = remarks(scene("floating", "liquid.surface_tension", "45 N/m"))
    assert stated[2] == "600 times that of water; unusual for matter: is the unit right?"


@pytest.mark.parametrize("name", templates())
def test_no_template_gets_a_remark(name):
    assert remarks(tomllib.loads((folder() / f"{name}.toml").read_text(encoding="utf-8"))) == []


def test_a_gas_may_carry_tracers():
    raw = {"model": "tracers", "liquid": {"density": 1.2, "viscosity": 1.8e-5}}
    assert remarks(raw) == []
    assert remarks({"model": "tracers", "liquid": {"density": 1.2}})


def test_every_range_contains_its_reference_and_is_within_what_is_possible():
    for row in RANGES:
        assert row.possible[0] <= row.usual[0] < row.usual[1] <= row.possible[1]
        if row.reference[0]:
            assert row.usual[0] <= row.reference[0] <= row.usual[1]


def test_a_key_without_a_dimension_has_no_range():
    assert range_of("sph", ("method", "smoothing_ratio"), "1") is None
