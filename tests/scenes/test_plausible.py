"""Values that matter does not have: slips of a unit are remarked upon, and usual scenes are not."""

import itertools
import math
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
        "particles[0].radii": ["1.5 mm", "2 mm"], "particles[0].sizes.mean": "1.5 mm", "cell.size": ["40 mm", "30 mm"],
        "dish.vertices": [["0 mm", "0 mm"], ["40 mm", "0 mm"], ["0 mm", "40 mm"]], "dish.motion.amplitude": "5 mm",
        "rows[0].vx": "2 cm/s", "flow.velocity": ["5 mm/s", "0 mm/s"], "flow.rotation_rate": "600 rpm",
        "flow.nodes.high": ["40 mm", "40 mm"], "dish.motion.velocity": ["20 mm/s", "0 mm/s"],
        "particles[0].surface_energies.solid_gas": "40 mN/m", "waves.frequency": "0.08 kHz",
        "dish.barrier.largest_pressure": "20 mN/m", "dish.barrier.velocity": "2 mm/s",
    },
    "sph": {
        "liquid.surface_tension": "72.8 mN/m", "liquid.density": "1 g/cm^3", "liquid.viscosity": "1.5 mPa*s",
        "gravity": ["0 cm/s^2", "-981 cm/s^2"], "tank.high": ["500 mm", "300 mm"], "bodies[0].density": "0.5 g/cm^3",
        "liquid.atmospheric_pressure": "101.3 kPa", "fluid[0].velocity": ["150 cm/s", "0 cm/s"],
        "second_liquid.density": "0.8 g/cm^3", "second_liquid.viscosity": "1 mPa*s",
        "second_liquid.interface_tension": "50 mN/m", "gauges[0].diameter": "4.2 mm",
        "obstacles[0].radius": "75 mm", "bodies[0].center": ["400 mm", "500 mm"],
        "spacing": "7.5 mm", "tank.left.motion.amplitude": "50 mm", "tank.top.velocity": ["30 cm/s", "0 cm/s"],
        "bodies[0].velocity": ["150 cm/s", "0 cm/s"], "liquid.maximum_speed": "250 cm/s", "tank.left.speed": "40 cm/s",
        "base_excitation.amplitude": "150 cm/s^2", "bodies[0].spin": "3000 rpm", "second_liquid.temperature": "20 degC",
        "bodies[0].mass": "60000 g", "central_force.angular_frequency": "900 rpm",
    },
    "soft": {
        "particles[0].modulus": "10 kPa", "particles[0].radius": "3 mm", "liquid.surface_tension": "30 mN/m",
        "long_range_forces.debye_length": "10 nm", "films.roughness": "5 um",
        "permeation.layer_height": "20 mm", "cell.size": ["10 mm", "35 mm"],
        "particles[0].positions": [["3 mm", "4 mm"]],
        "liquid.density": "1.03 g/cm^3", "liquid.temperature": "20 degC", "gravity": "981 cm/s^2",
        "particles[0].radii": ["3 mm", "2 mm"], "particles[0].sizes.mean": "3 mm", "walls[0].velocity": "10 mm/s",
        "permeation.permeability": "1 mm^2", "particles[0].torque": "2 uN*m", "films.critical_load": "20 uN",
        "long_range_forces.steric_length": "5 nm", "films.cavitation_pressure": "100 kPa",
        "particles[0].density": "1.2 g/cm^3", "walls[0].modulus": "10 kPa",
        "long_range_forces.hamaker_constant": "10 zJ",
    },
    "tracers": {
        "liquid.density": "1.03 g/cm^3", "liquid.viscosity": "2 mPa*s", "particles[0].radius": "5 um",
        "particles[0].density": "2.5 g/cm^3", "gravity": "981 cm/s^2", "liquid.temperature": "20 degC",
        "flow.speed": "200 cm/s", "particles[0].velocity": ["150 mm/s", "0 mm/s"],
        "particles[0].radii": ["5 um", "6 um"], "particles[0].sizes.radii": ["5 um", "6 um"],
        "liquid.mean_free_path": "68 nm", "flow.turbulence.diffusivities": ["2000 cm^2/s"], "flow.rate": "600 rpm",
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
    lengths, speeds = {"nm", "um", "mm", "cm"}, {"mm/s", "cm/s", "um/s"}  # which of them was meant cannot be known
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


WRONG_UNITS = {
    "floating": {
        "liquid.surface_tension": "72 N/m", "liquid.density": "1.03 kg/m^3", "particles[0].density": "0.3 kg/m^3",
        "particles[0].radius": "1.5 m", "dish.radius": "400 m", "liquid.temperature": "20 mK",
        "activity.force": "20 N", "magnetic_field.constant": "500 T", "particles[0].shape.thickness": "20 m",
    },
    "sph": {
        "bodies[0].density": "0.5 kg/m^3", "tank.high": ["5 km", "3 km"], "liquid.sound_speed": "30 km/s",
        "second_liquid.interface_tension": "50 N/m", "liquid.atmospheric_pressure": "101 GPa", "spacing": "0.5 km",
    },
    "soft": {
        "particles[0].modulus": "70000 GPa", "cell.size": ["10 km", "10 km"], "long_range_forces.debye_length": "10 m",
    },
    "tracers": {"particles[0].radius": "20 m", "liquid.viscosity": "1e13 Pa*s", "liquid.density": "0.001 kg/m^3"},
}  # fmt: skip


@pytest.mark.parametrize(
    ("model", "key", "value"),
    [(model, key, value) for model, keys in WRONG_UNITS.items() for key, value in keys.items()],
)
def test_a_written_unit_that_matter_does_not_have_is_asked_about(model, key, value):
    (found,) = remarks(scene(model, key, value))
    assert found[0] == key
    assert found[2].endswith("unusual for matter: is the unit right?")


MOTIONS = [("floating", "dish.motion"), ("sph", "tank.left.motion"), ("sph", "bodies[0].motion")]


@pytest.mark.parametrize(("model", "key"), MOTIONS)
@pytest.mark.parametrize("frequency", [60, "1 Hz", "60 Hz", 1.5])
def test_oscillations_per_minute_are_not_taken_for_hertz(model, key, frequency):
    """A wall that swings by 50 mm 60 times a second bears 700 g."""
    found = remarks(scene(model, key, {"amplitude": "50 mm", "frequency": frequency}))
    text = "a peak acceleration of 700 g; plain numbers are in Hz: 60 1/minute?"
    assert found == ([(f"{key}.frequency", "60 Hz", text)] if frequency == 60 else [])


def test_a_quantity_of_two_dimensions_has_a_range():
    (found,) = remarks(scene("soft", "walls[0].pressure", 1e12))
    assert found[:2] == ("walls[0].pressure", "1e+12 Pa (N/m in 2D)")


GARBAGE = [
    None, True, 3, -1.0, math.nan, 10**400, "x", "1e400 m", "milk", [], [[]], [1, "a"], {}, [{}, 3], [None], [[1, [2]]],
]  # fmt: skip


def places_in(value, path=()):
    yield path
    for key, item in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from places_in(item, (*path, key))


@pytest.mark.parametrize("name", templates())
def test_faulty_scenes_are_asked_about_too(name):
    """Whatever stands in place of a value."""
    text = (folder() / f"{name}.toml").read_text(encoding="utf-8")
    for number, path in enumerate(places_in(tomllib.loads(text))):
        if path:
            at = raw = tomllib.loads(text)
            for key in path[:-1]:
                at = at[key]
            at[path[-1]] = GARBAGE[number % len(GARBAGE)]
            assert all(isinstance(part, str) for row in remarks(raw) for part in row)


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
