"""Tanks that roll about a pivot: the forces in their frame, and the energy."""

import math

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.boundaries.rolling import inertial_accelerations
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN


def drop(roll, velocity_gradient, gravity):
    """A drop above the floor of an open tank, far from its walls."""
    return from_plain(
        {
            "model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.02, "gravity": gravity,
            "tank": {"low": [-1.0, -1.0], "high": [1.0, 1.0], "top": OPEN},
            "liquid": {"sound_speed": 20.0, "maximum_speed": 2.0},
            "method": {"artificial_viscosity": 0.0, "density_diffusion": "none"},
            "fluid": [{"center": [0.3, 0.1], "radius": 0.06, "velocity_gradient": velocity_gradient,
                       "velocity": [0.0, 0.0]}],
            "roll": roll,
        }
    )  # fmt: skip


def turned(points, angle):
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return points @ turn.T


@pytest.mark.compiled
def test_free_liquid_falls_straight_whatever_the_tank_around_it_does():
    """At rest in the laboratory at first, it moves in the frame of the tank as the laboratory seems to."""
    rate, growth, pivot = 2.0, 5.0, np.array([0.1, -0.2])
    roll = {"formula": f"{rate}*t + {growth}*t**2", "pivot": pivot.tolist()}
    scene = drop(roll, [[0.0, rate], [-rate, 0.0]], [0.0, -9.81])
    center = np.array([0.3, 0.1])
    plain = to_plain(scene)
    arm = center - pivot
    plain["fluid"][0]["velocity"] = [rate * arm[1], -rate * arm[0]]
    first, last = ecume.simulate(from_plain(plain))
    time = last.time
    angle = rate * time + growth * time**2
    laboratory = first.arrays["position"] - pivot + np.array([0.0, -0.5 * 9.81 * time**2])
    expected = turned(laboratory, -angle) + pivot
    moved = np.abs(first.arrays["position"] - expected).max()
    assert moved > 0.1
    np.testing.assert_allclose(last.arrays["position"], expected, atol=0.002 * moved)


@pytest.mark.compiled
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
def test_liquid_at_rest_in_the_laboratory_circles_at_constant_speed_in_a_tank_that_spins(integrator):
    """Coriolis's acceleration turns velocities; taken at velocities half a kick late it would add 0.3 %."""
    rate, center = 8.0, np.array([0.3, 0.1])
    plain = to_plain(drop({"formula": f"{rate}*t", "pivot": [0.0, 0.0]}, [[0.0, rate], [-rate, 0.0]], [0.0, 0.0]))
    plain["fluid"][0]["velocity"] = [rate * center[1], -rate * center[0]]
    last = list(ecume.simulate(from_plain(plain | {"integration": {"integrator": integrator}})))[-1]
    speed = np.linalg.norm(last.arrays["velocity"].mean(axis=1 if len(last.arrays["velocity"]) == 2 else 0))
    assert speed == pytest.approx(rate * math.hypot(*center), rel=1e-4)


def basin(**more):
    plain = {
        "model": "sph", "duration": 0.4, "frame_every": 0.1, "spacing": 0.02, "liquid": {"maximum_speed": 1.5},
        "tank": {"high": [0.9, 0.4], "top": OPEN}, "fluid": [{"low": [0.0, 0.0], "high": [0.9, 0.1]}],
        "roll": {"formula": "0.07*sin(3.85*t)*tanh(4*t)"},
    }  # fmt: skip
    return from_plain(plain | more)


@pytest.mark.compiled
def test_liquid_in_a_tank_that_rolls_gains_no_more_than_the_work_of_its_forces():
    frames = list(ecume.simulate(basin()))
    energy = [frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in frames]
    work = frames[-1].numbers["injected_work"]
    assert work > 0.1
    assert -0.1 * work < energy[-1] - energy[0] < 0.01 * work
    x, y = frames[-1].arrays["position"].T
    tops = y[x < 0.1].max(), y[x > 0.8].max()
    assert tops[0] > tops[1] + 0.01  # counterclockwise: the left side went down


def test_three_dimensions_roll_as_two_do():
    """By default a tank in 3D turns about z, too; the velocity along the axis has no effect."""
    flat = basin()
    roll = SPH.parameters(flat).roll
    points, speeds = np.array([[0.1, 0.8], [0.05, 0.3]]), np.array([[0.3, -0.2], [0.1, 0.4]])
    of_plane = inertial_accelerations(roll, 0.3, points, speeds)
    box = {"high": [0.9, 0.4, 0.1], "top": OPEN}
    deep = basin(tank=box, fluid=[{"low": [0.0, 0.0, 0.0], "high": [0.9, 0.1, 0.1]}], spacing=0.05)
    roll = SPH.parameters(deep).roll
    third = np.array([[0.02, 0.07]])
    of_space = inertial_accelerations(roll, 0.3, np.concatenate([points, third]), np.concatenate([speeds, third]))
    np.testing.assert_allclose(of_space[:2], of_plane, atol=1e-14)
    np.testing.assert_allclose(of_space[2], 0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"roll": {}}, "roll: expected either amplitude and frequency, or a formula"),
        ({"roll": {"amplitude": 0.1}}, "roll.frequency: belongs to an amplitude"),
        ({"roll": {"formula": "t", "phase": 1.0}}, "roll.phase: belongs to a sine"),
        ({"roll": {"formula": "cos(t)"}}, "roll.formula: .* is 1 at t = 0"),
        ({"roll": {"formula": "t", "pivot": [0.0, 0.0, 0.0]}}, "roll.pivot: got 3 numbers"),
        ({"roll": {"formula": "t", "axis": [1.0, 0.0, 0.0]}}, "roll.axis: in two dimensions"),
        ({"bodies": [{"center": [0.4, 0.2], "radius": 0.05, "density": 500.0}]}, "bodies: does not go with"),
        ({"central_force": {"angular_frequency": 1.0, "center": [0.5, 0.5]}, "gravity": [0, 0]}, "central_force: does"),
    ],
)
def test_a_roll_that_cannot_be_says_why(changes, said):
    with pytest.raises(SceneError, match=said):
        SPH.parameters(basin(**changes))
