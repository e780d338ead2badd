"""What means the same is read in the same way in all models."""

import pytest

from ecume.errors import SceneError
from ecume.models.liquids import liquid_of, material_of
from ecume.scenes.schema import SCENES, from_plain, to_plain

RUN = {"duration": 1.0, "frame_every": 0.5}
FLOATING = {"model": "floating", **RUN, "particles": [{"radius": 1e-3, "density": 600.0, "contact_angle": 1.2}]}
SPHERES = [{"radius": 1e-3, "modulus": 1e4, "density": 2000.0, "positions": [[x, 0.0]]} for x in (0.0, 3e-3)]
SOFT = {"model": "soft", **RUN, "liquid": {"viscosity": 1.0, "density": 1000.0}, "particles": SPHERES}
TANK = {"model": "sph", **RUN, "spacing": 0.1, "tank": {"high": [1.0, 1.0]}, "fluid": [{"low": [0, 0], "high": [1, 1]}]}
TRACERS = {"model": "tracers", **RUN, "tank": {"high": [1.0, 1.0]}, "particles": [{"radius": 1e-3, "density": 1.0}]}
ALL = {"floating": FLOATING, "sph": TANK, "soft": SOFT, "tracers": TRACERS}


@pytest.mark.parametrize("model", SCENES)
def test_gravity_is_a_magnitude_in_all_models(model):
    assert from_plain({**ALL[model], "gravity": "1.62 m/s^2"}).gravity in (1.62, (0.0, -1.62))


@pytest.mark.parametrize("plain", [TANK, SOFT])
def test_gravity_is_a_vector_where_it_has_a_direction(plain):
    scene = from_plain({**plain, "gravity": [1.0, "-9 m/s^2"]})
    assert scene.gravity == (1.0, -9.0)
    assert from_plain(to_plain(scene)) == scene
    for wrong, says in ((-1.0, "magnitude from 0"), ([1.0, 2.0, 3.0], "got 3"), ("1 kg", "measures mass")):
        with pytest.raises(SceneError, match=says):
            from_plain({**plain, "gravity": wrong})


@pytest.mark.parametrize("model", SCENES)
def test_a_named_liquid_sets_what_is_not_given(model):
    named = from_plain({**ALL[model], "liquid": {"name": "water", "temperature": "20 degC", "viscosity": 2e-3}})
    material = material_of(named.liquid)
    assert material.density == pytest.approx(998.2, abs=0.1)
    assert material.viscosity == 2e-3
    with pytest.raises(SceneError, match="did you mean water"):
        material_of(from_plain({**ALL[model], "liquid": {"name": "watr"}}).liquid)


def test_a_named_liquid_carries_floats():
    liquid = liquid_of(from_plain({**FLOATING, "liquid": {"name": "water"}, "gravity": 1.0}))
    assert liquid.surface_tension == pytest.approx(0.0728, abs=1e-4)
    assert (liquid.gravity, liquid.gas_density) == (1.0, 0.0)
    plain = liquid_of(from_plain(FLOATING))
    assert (plain.density, plain.viscosity, plain.surface_tension) == (1000.0, 1e-3, 0.0728)


def test_soft_spheres_need_a_viscosity_or_a_name():
    with pytest.raises(SceneError, match=r"liquid\.viscosity: is missing; give it, or the name"):
        from_plain({**SOFT, "liquid": {}})


@pytest.mark.parametrize("plain", [TANK, TRACERS])
def test_a_tank_begins_at_the_origin(plain):
    assert from_plain(plain).tank.low == (0.0, 0.0)
    with pytest.raises(SceneError, match="expected a corner above low"):
        from_plain({**plain, "tank": {"low": [2.0, 0.0], "high": [1.0, 1.0]}})


@pytest.mark.parametrize(
    ("plain", "change", "says"),
    [
        (FLOATING, {"floats": []}, "floats: no such key; did you mean particles?"),
        (FLOATING, {"liquid": {"gravity": 1.0}}, "liquid.gravity: no such key; did you mean gravity, at the top"),
        (FLOATING, {"interaction": {"sum": "grid"}}, "did you mean summation?"),
        (FLOATING, {"brownian": True}, "brownian: no such key; did you mean hydrodynamics.brownian?"),
        (TANK, {"obstacles": [{"length_unit": "1 mm"}]}, "did you mean outline_unit?"),
        (SOFT, {"spheres": []}, "spheres: no such key; did you mean particles?"),
        (SOFT, {"box": {}}, "box: no such key; did you mean cell?"),
        (SOFT, {"liquid": {"viscosity": 1.0, "drag": True}}, "did you mean hydrodynamics.drag?"),
        (TANK, {"liquid": {"fastest": 1.0}}, "did you mean maximum_speed?"),
        (TANK, {"shake": {}}, "did you mean base_excitation?"),
        (TANK, {"method": {"time_step": 1e-3}}, "did you mean integration.time_step?"),
        (TRACERS, {"tank": {"size": [1.0, 1.0]}}, "did you mean tank.low and tank.high?"),
    ],
)
def test_other_words_lead_to_the_key(plain, change, says):
    with pytest.raises(SceneError) as caught:
        from_plain({**plain, **change})
    assert says in str(caught.value)
