"""Liquids whose viscosity depends on the rate of strain: the sum, walls, channels, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.yield_stress import apparent_viscosity, channel_speed
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations
from ecume.models.sph.record import SPH
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain
from ecume.simulation import simulate
from tests.models.sph.scenes import free_blob
from tests.models.sph.test_turbulence import in_a_flow

BINGHAM = {"consistency": 2.0, "yield_stress": 30.0, "largest_viscosity": 400.0}
THINNING = {"consistency": 4.0, "exponent": 0.5, "largest_viscosity": 400.0}
CHANNEL = """
model = "sph"
duration = "0.3 s"
frame_every = "0.1 s"
spacing = "1 mm"
gravity = [1.0, 0.0]
[tank]
low = [0.0, 0.0]
high = ["1.2 cm", "2 cm"]
walls = "{walls}"
left = {{ kind = "periodic" }}
right = {{ kind = "periodic" }}
[[fluid]]
low = [0.0, 0.0]
high = ["1.2 cm", "2 cm"]
[liquid]
maximum_speed = "4 cm/s"
[liquid.rheology]
consistency = {consistency}
exponent = {exponent}
yield_stress = {yield_stress}
largest_viscosity = 20.0
"""


def sheared(rheology, gradient, dimension=2):
    """The viscosities of a blob in a flow of this gradient, and its accelerations."""
    plain = free_blob(dimension, artificial_viscosity=0.0)
    kept = to_plain(plain)
    liquid = {key: value for key, value in kept["liquid"].items() if key != "viscosity"}
    scene = from_plain({**kept, "liquid": {**liquid, "rheology": rheology}})
    return in_a_flow(scene, gradient)


@pytest.mark.parametrize("rheology", [BINGHAM, THINNING])
@pytest.mark.parametrize("rate", [0.01, 3.0, 40.0])
def test_the_viscosity_is_that_at_the_rate_of_strain(rheology, rate):
    viscosity, _ = sheared(rheology, [[0.0, rate], [0.0, 0.0]])
    numbers = (rheology["consistency"], rheology.get("exponent", 1.0), rheology.get("yield_stress", 0.0), 400.0)
    np.testing.assert_allclose(viscosity, apparent_viscosity(rate, *numbers), rtol=1e-9)


def test_a_rigid_rotation_does_not_yield():
    viscosity, state = sheared(BINGHAM, [[0.0, -2.0], [2.0, 0.0]])
    np.testing.assert_allclose(viscosity, 400.0, rtol=1e-6)
    assert np.abs(state.acceleration).max() < 1e-7


@pytest.mark.long
def test_in_space_the_rate_of_strain_is_that_of_all_directions():
    gradient = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -2.0]]
    viscosity, _ = sheared(BINGHAM, gradient, dimension=3)
    rate = math.sqrt(2.0 * 6.0)
    np.testing.assert_allclose(viscosity, apparent_viscosity(rate, 2.0, 1.0, 30.0, 400.0), rtol=1e-9)


def channel(walls="mirror", consistency=1.0, exponent=1.0, yield_stress=0.0, **changes):
    text = CHANNEL.format(walls=walls, consistency=consistency, exponent=exponent, yield_stress=yield_stress)
    return load_scene(text, [f"{key}={value}" for key, value in changes.items()])


def test_the_largest_viscosity_limits_the_step():
    narrow, wide = channel(yield_stress=4.0), channel(yield_stress=4.0, **{"liquid.rheology.largest_viscosity": 40.0})
    assert SPH.parameters(narrow).time_step == pytest.approx(2.0 * SPH.parameters(wide).time_step, rel=0.02)


@pytest.mark.long
def test_walls_that_hold_the_liquid_have_its_viscosity():
    """Otherwise the mean of both would be up to twice that of the liquid."""
    scene = channel(walls="dummy", yield_stress=4.0)
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[0] = 3.0 * state.position[1]
    workspace = SPH.workspace(parameters, state, 1.0)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    dummies = parameters.boundary.dummies.position.shape[1]
    count = state.position.shape[1]
    there = workspace.fields.viscosity[count : count + dummies]
    liquid = workspace.fields.viscosity[:count]
    assert there.max() <= liquid.max()
    assert there[there > 0.0].min() >= (1.0 - 1e-12) * liquid.min()
    assert (there > 0.0).any()


@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_the_first_frame_has_the_force_of_the_viscosity_at_its_rate_of_strain(walls):
    """It has not taken a step; with the largest viscosity the force was eight times as large."""
    plain = to_plain(channel(walls, yield_stress=4.0))
    plain["fluid"] = [{**plain["fluid"][0], "velocity_gradient": [[0.0, 3.0], [0.0, 0.0]]}]
    first = next(iter(simulate(from_plain(plain))))
    stress = 3.0 * apparent_viscosity(3.0, 1.0, 1.0, 4.0, 20.0)
    assert first.numbers["bottom_force_x"] == pytest.approx(0.012 * stress, rel=0.1)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("walls", "liquid", "close"),
    [
        ("mirror", (1.0, 1.0, 0.0), 0.01), ("dummy", (1.0, 1.0, 0.0), 0.01),
        *(pytest.param(*case, marks=pytest.mark.long) for case in (
            ("mirror", (4.0, 0.5, 0.0), 0.025), ("dummy", (1.0, 1.0, 4.0), 0.047), ("mirror", (2.0, 0.6, 3.0), 0.05),
        )),
    ],
)  # fmt: skip
def test_a_channel_has_the_profile_of_its_liquid(walls, liquid, close):
    """With twenty particles across. With forty, the errors of the power law are 0.6 instead of 2.3 % between mirrors,
    and 2.4 instead of 5.3 % between walls of particles, whose viscosity is a mean over the liquid before them. A liquid
    that thins, one that yields and one that does both are tried between one kind of walls each.
    """
    # The largest viscosity limits the step: no more of it than the liquid has anywhere.
    largest = 2.0 if liquid == (1.0, 1.0, 0.0) else 20.0
    *_, last = simulate(channel(walls, *liquid, **{"liquid.rheology.largest_viscosity": largest}))
    y, speed = last.arrays["position"][:, 1] - 0.01, last.arrays["velocity"][:, 0]
    exact = np.array([channel_speed(each, 0.01, 1000.0, *liquid) for each in y])
    assert np.sqrt(np.mean((speed - exact) ** 2)) < close * np.sqrt(np.mean(exact**2))


def test_check_says_how_slowly_the_liquid_creeps():
    rows = {name: (value, remark) for name, value, remark in SPH.summary(channel(yield_stress=4.0))}
    assert rows["rheology"][0] == "4 Pa + 1 Pa s"
    assert "below 0.21 1/s" in rows["rheology"][1]
    thin = {name: value for name, value, _ in SPH.summary(channel(exponent=0.5))}
    assert thin["rheology"] == "1 Pa s^0.5"


def test_the_viscosity_of_a_named_liquid_does_not_limit_that_of_its_rheology():
    """`water` with a yield stress had the viscosity of water."""
    plain, named = channel(yield_stress=4.0), channel(yield_stress=4.0, **{"liquid.name": '"water"'})
    bounds = [
        SPH.parameters(dataclasses.replace(scene, liquid=dataclasses.replace(scene.liquid, rheology=free))).rheology
        for scene in (plain, named)
        for free in (dataclasses.replace(scene.liquid.rheology, largest_viscosity=None),)
    ]
    assert bounds[0] == bounds[1]
    assert bounds[0].largest_viscosity > 1.0
    rows = {name for name, *_ in SPH.summary(named)}
    assert "rheology" in rows
    assert "viscosity" not in rows


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"liquid.viscosity": 1.0}, "the rheology sets it"),
        ({"method.turbulence": '"smagorinsky"'}, "liquids of one viscosity"),
        ({"passive_tracers": "[{positions=[[0.005, 0.01]], radius=1e-4, density=2500.0}]"}, "drag on grains"),
        ({"liquid.rheology.consistency": 0.0}, "expected a consistency, a yield_stress, or both"),
    ],
)
def test_what_no_law_is_known_for_is_refused(changes, says):
    with pytest.raises(SceneError, match=says):
        channel(**changes)


@pytest.mark.long
def test_a_liquid_of_one_viscosity_has_the_same_bits_by_either_key():
    """Bingham's liquid without yield stress is Newton's."""
    short = {
        "duration": '"2 ms"',
        "frame_every": '"1 ms"',
        "spacing": '"2 mm"',
        "liquid.rheology.largest_viscosity": 1.0,
    }
    plain = channel(consistency=1.0, **short)
    newton = dataclasses.replace(plain, liquid=dataclasses.replace(plain.liquid, rheology=None, viscosity=1.0))
    one, other = ([f.arrays["velocity"] for f in simulate(scene)][-1] for scene in (plain, newton))
    np.testing.assert_array_equal(one, other)
