"""Liquid that hits a wall is braked without a water hammer, and what brakes it is a force like others."""

import numpy as np
import pytest

import ecume
from ecume.laws.kernels import kernel
from ecume.laws.wall_forces import impact_braking
from ecume.models.sph.boundaries.rigid_bodies import with_moved_solids
from ecume.models.sph.boundaries.walls import all_braked, weight_at
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN, tank

SOUND = 20.0
WALLS = ["mirror", "dummy"]


def thrown(speed=1.0, walls="mirror", **method):
    """A strip of liquid, two particles high, that flies against the right wall without gravity."""
    return from_plain(
        {
            "model": "sph",
            "duration": 0.6,
            "frame_every": 0.004,
            "spacing": 0.05,
            "gravity": [0.0, 0.0],
            "liquid": {"density": 1.0, "maximum_speed": 2.0, "sound_speed": SOUND},
            "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0], "top": OPEN, "walls": walls},
            "fluid": [{"low": [0.2, 0.5], "high": [0.6, 0.6], "velocity": [speed, 0.0]}],
            "method": method,
        }
    )


def incompressible():
    """The same strip without sound."""
    plain = to_plain(thrown(pressure="incompressible"))
    return from_plain({**plain, "liquid": {"density": 1.0, "maximum_speed": 2.0}})


def started(scene):
    """Parameters, state and workspace."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    return parameters, state, SPH.workspace(parameters, state, 1.0)


def not_braked(parameters):
    """The same parameters without braking."""
    guard = parameters.boundary.guard._replace(weights=np.empty(0))
    return parameters._replace(boundary=parameters.boundary._replace(guard=guard))


@pytest.mark.compiled
@pytest.mark.parametrize("walls", WALLS)
def test_a_strip_that_hits_a_wall_loses_energy_and_makes_no_water_hammer(walls):
    frames = list(ecume.simulate(thrown(walls=walls)))
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    highest = max(float(frame.arrays["pressure"].max()) for frame in frames)
    assert highest < 0.4 * SOUND  # rho c u is 20
    assert energy[-1] < 0.9 * energy[0]
    assert np.diff(energy).max() < 2e-3 * energy[0]


@pytest.mark.compiled
def test_walls_report_the_braking_and_the_liquid_gets_the_opposite():
    parameters, state, workspace = started(thrown())
    state.position[0] += 0.37
    state.reference[...] = state.position
    (pushed,) = [each for each in all_braked(parameters, state) if len(each.who)]
    reported = [SPH.observe(which, state, workspace).numbers for which in (parameters, not_braked(parameters))]
    got = float(pushed.acceleration[0] @ state.mass[pushed.who])
    assert got < -0.1
    assert reported[0]["right_force_x"] - reported[1]["right_force_x"] == pytest.approx(-got, rel=1e-9)
    for key in ("left_force_x", "bottom_force_y"):
        assert reported[0][key] == reported[1][key]


@pytest.mark.compiled
def test_who_leaves_a_wall_or_moves_along_it_is_not_braked():
    for speed in ([-1.0, 0.0], [0.0, 1.0], [0.0, 0.0]):
        parameters, state, _ = started(thrown())
        state.position[0] += 0.37
        state.velocity[...] = np.array(speed)[:, None]
        right = [each for each in all_braked(parameters, state) if parameters.boundary.names[each.owner] == "right"]
        assert [len(each.who) for each in right] == [0]


@pytest.mark.compiled
def test_the_braking_is_relative_to_a_moving_wall():
    moving = {"kind": "wall", "motion": {"amplitude": 0.05, "frequency": 1.0, "phase": 0.0}}
    plain = to_plain(thrown())
    parameters, state, _ = started(from_plain({**plain, "tank": {**plain["tank"], "right": moving}}))
    now = with_moved_solids(parameters, state)
    speed = now.boundary.guard.sheet.number[now.boundary.guard.owner == 1][0, 4]
    state.position[0] += 0.37
    state.velocity[0] = speed + 1e-12 * np.sign(speed)
    pushed = [each for each in all_braked(now, state) if parameters.boundary.names[each.owner] == "right"]
    assert abs(speed) > 0.1
    assert sum(float(np.abs(each.acceleration).sum()) for each in pushed) < 1e-9


@pytest.mark.parametrize("scene", [
    tank(walls="reflect"), tank(artificial_viscosity=0.0), incompressible(),
])  # fmt: skip
def test_where_there_is_no_water_hammer_nothing_is_braked(scene):
    parameters = SPH.parameters(scene)
    assert len(parameters.boundary.guard.weights) == 0
    assert all_braked(parameters, SPH.start(scene, parameters)) == []


@pytest.mark.compiled
def test_a_tank_at_rest_is_the_same_without_braking():
    scene = tank(deep=12, jitter=0.0)
    with_, without = (started(scene) for _ in range(2))
    assert len(with_[0].boundary.guard.weights)
    SPH.advance(*with_, 50)
    SPH.advance(not_braked(without[0]), *without[1:], 50)
    np.testing.assert_allclose(with_[1].position, without[1].position, atol=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_weight_is_the_kernel_over_a_plane(dimension):
    plain = to_plain(thrown())
    if dimension == 3:
        plain["gravity"] = [0.0, 0.0, 0.0]
        plain["tank"] |= {"low": [0.0] * 3, "high": [1.0] * 3}
        plain["fluid"] = [{"low": [0.2, 0.5, 0.2], "high": [0.6, 0.6, 0.4]}]
    parameters = SPH.parameters(from_plain(plain))
    guard, shape = parameters.boundary.guard, kernel("wendland-c2", dim=dimension)
    h = guard.support / shape.support
    for gap in (0.0, 0.4 * guard.support, 0.93 * guard.support):
        exact = float(np.asarray(shape.over_plane(gap / h))) / h
        assert weight_at(gap, guard.support, guard.weights) == pytest.approx(exact, abs=2e-4 / h)
    # Half of the kernel is behind a wall through its middle.
    assert float(np.trapezoid(guard.weights)) * guard.support / (len(guard.weights) - 1) == pytest.approx(0.5, abs=1e-3)


def test_the_braking_takes_the_approach_but_never_turns_it_around():
    shape, h, speed = kernel("wendland-c2", dim=2), 0.5, 1.0
    gaps, step = np.linspace(shape.support * h, 0.0, 2000, retstep=True)
    for weight in np.asarray(shape.over_plane(gaps / h)) / h:
        speed += step * impact_braking(speed, weight, 1e3) / speed
    # du/dx = 12 u w, and w adds up to 1/2.
    assert speed == pytest.approx(np.exp(-6.0), rel=0.05)
