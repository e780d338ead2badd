"""Bodies that follow a prescribed path: gates, pistons, flaps, stirrers, rolling tanks."""

import dataclasses
import math

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.boundaries.driven_bodies import on_path
from ecume.models.sph.boundaries.rigid_bodies import drive_at
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN

SWING = {"amplitude": 0.02, "frequency": 1.0, "phase": -math.pi / 2}


def basin(duration=0.2, deep=8, **tables):
    """Water 0.1 m deep in a tank of 0.4 m."""
    return from_plain(
        {
            "model": "sph",
            "duration": duration,
            "frame_every": 0.05,
            "spacing": 0.1 / deep,
            "tank": {"low": [0.0, 0.0], "high": [0.4, 0.2], "top": OPEN, **tables.pop("tank", {})},
            "liquid": {"maximum_speed": 1.5},
            "fluid": [{"low": [0.0, 0.0], "high": [0.4, 0.1]}],
            **tables,
        }
    )


def pushed_by_a_body(motion, **keys):
    """The same between a body, in the place of the left side, and the right side."""
    body = {"low": [-0.08, 0.0], "high": [0.0, 0.2], "motion": motion}
    return basin(tank={"low": [-0.15, 0.0]}, bodies=[body], **keys)


def course(scene, *names):
    frames = list(ecume.simulate(scene))
    return [np.array([frame.numbers[name] for frame in frames]) for name in names]


@pytest.mark.long
@pytest.mark.compiled
def test_a_piston_that_is_a_body_does_what_the_side_does_that_it_equals():
    names = "injected_work", "kinetic_energy", "total_energy"
    of_side = course(basin(tank={"left": {"motion": SWING}}), *names, "left_force_x", "center_x")
    moving = {**SWING, "amplitude": [SWING["amplitude"], 0.0]}
    of_body = course(pushed_by_a_body(moving), *names, "body0_force_x", "center_x")
    work = of_side[0][-1]
    assert work > 0.7  # J per meter
    assert of_body[0][-1] == pytest.approx(work, rel=0.01)
    for mine, theirs in zip(of_body[1:3], of_side[1:3], strict=True):
        np.testing.assert_allclose(mine - mine[0], theirs - theirs[0], atol=0.01 * work)
    np.testing.assert_allclose(of_body[3], of_side[3], rtol=0.08)
    np.testing.assert_allclose(of_body[4] - 0.2, of_side[4] - 0.2, atol=0.02 * 0.0145)
    # What is gained beyond the work is what the moving side leaves, 0.8 % of it with eight particles.
    for found in (of_side, of_body):
        assert abs(found[2][-1] - found[2][0] - found[0][-1]) < 0.012 * work


def stirrer(deep=8, duration=0.5):
    """A disc that turns in the middle of a round basin of twice its radius."""
    return from_plain(
        {
            "model": "sph",
            "duration": duration,
            "frame_every": 0.25,
            "spacing": 0.1 / deep,
            "gravity": [0.0, 0.0],
            "liquid": {"viscosity": 10.0, "maximum_speed": 0.2},
            "method": {"viscosity_model": "monaghan"},
            "tank": {"low": [-0.3, -0.3], "high": [0.3, 0.3]},
            "fluid": [{"center": [0.0, 0.0], "radius": 0.2}],
            "obstacles": [{"center": [0.0, 0.0], "radius": 0.2, "hollow": True, "slip": "no-slip"}],
            "bodies": [{"center": [0.0, 0.0], "radius": 0.1, "slip": "no-slip", "motion": {"spin": 1.0}}],
        }
    )


@pytest.mark.long
@pytest.mark.compiled
def test_a_disc_that_turns_in_a_round_basin_has_the_torque_of_couette_flow():
    """T = 4 pi eta w / (1/R1^2 - 1/R2^2) for each meter; both walls are half a spacing thick in it (first order)."""
    *_, middle, last = ecume.simulate(stirrer())
    exact = 4.0 * math.pi * 10.0 / (1.0 / 0.1**2 - 1.0 / 0.2**2)
    assert -last.numbers["body0_torque_z"] == pytest.approx(exact, rel=0.12)
    assert last.numbers["obstacle0_torque_z"] == pytest.approx(-last.numbers["body0_torque_z"], rel=0.05)
    x, y = last.arrays["position"].T
    u, v = last.arrays["velocity"].T
    r = np.hypot(x, y)
    couette = (1.0 / r - r / 0.2**2) / (1.0 / 0.1**2 - 1.0 / 0.2**2)
    assert np.sqrt(np.mean(((x * v - y * u) / r - couette) ** 2)) < 0.05 * 0.1
    assert last.numbers["body0_angle"] == pytest.approx(0.5)
    # All the work is dissipated: the power is the torque times the spin.
    power = (last.numbers["injected_work"] - middle.numbers["injected_work"]) / 0.25
    assert power == pytest.approx(-last.numbers["body0_torque_z"], rel=0.02)


def gate(duration=0.3, speed=1.0, deep=8):
    """A dam behind a gate that lifts."""
    body = {"low": [0.2, 0.0], "high": [0.25, 0.2], "motion": {"velocity": [0.0, speed], "start": 0.05, "until": 0.25}}
    scene = basin(duration, deep, tank={"high": [0.6, 0.3]}, bodies=[body])
    return dataclasses.replace(scene, fluid=(dataclasses.replace(scene.fluid[0], high=(0.2, 0.1)),))


@pytest.mark.long
@pytest.mark.compiled
def test_a_gate_holds_the_water_until_it_lifts():
    frames = list(ecume.simulate(gate()))
    front = [float(frame.arrays["position"][:, 0].max()) for frame in frames]
    assert max(front[:2]) < 0.2
    assert front[-1] > 0.3
    assert frames[-1].numbers["body0_y"] == pytest.approx(0.1 + 0.2)
    # Half a depth of water stands against it, on one side alone.
    assert frames[0].numbers["body0_force_x"] == pytest.approx(0.5 * 1000.0 * 9.81 * 0.1**2, rel=0.01)


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["obstacles", "bodies"])
def test_a_wall_that_holds_water_on_one_side_bears_its_pressure(name):
    """The side that is dry was taken for a narrow gap where it stands on the floor: 23 % of the force were missing."""
    wall = {"low": [0.2, 0.0], "high": [0.25, 0.2]}
    plain = to_plain(gate())
    plain |= {
        "bodies": [],
        "duration": 0.001,
        "frame_every": 0.001,
        name: [wall | ({"density": 2000.0} if name == "bodies" else {})],
    }
    frame = next(iter(ecume.simulate(from_plain(plain))))
    force = frame.numbers["body0_force_x" if name == "bodies" else "obstacle0_force_x"]
    assert force == pytest.approx(0.5 * 1000.0 * 9.81 * 0.1**2, rel=0.01)


def driven(motion, shape=None, **keys):
    return basin(bodies=[{**(shape or {"low": [0.1, 0.02], "high": [0.2, 0.06]}), "motion": motion}], **keys)


TABLE = {"times": [0.0, 0.1, 0.2], "positions": [[0.0, 0.0], [0.03, 0.0], [0.03, 0.02]], "angles": [0.0, 0.3, 0.0]}
LAWS = {
    "uniform": {"velocity": [0.1, 0.05], "spin": 2.0, "start": 0.02, "until": 0.12},
    "sine": {"amplitude": [0.02, 0.0], "angle_amplitude": 0.2, "frequency": 2.0, "pivot": [0.1, 0.02]},
    "table": TABLE,
    "formula": {"formula": ["0.02*sin(9*t)", "0.4*t**2"], "angle_formula": "0.2*tanh(5*t)", "pivot": [0.1, 0.02]},
}


@pytest.mark.parametrize("law", LAWS)
def test_velocities_and_accelerations_on_a_path_are_the_derivatives_of_its_pose(law):
    path = SPH.parameters(driven(LAWS[law])).bodies.paths[0][1]
    step = 1e-6
    for time in (0.01, 0.05, 0.11, 0.15, 0.19):
        before, now, after = (on_path(path, time + k * step) for k in (-1, 0, 1))
        np.testing.assert_allclose(now[1][:3], (after[0][:3] - before[0][:3]) / (2 * step), atol=1e-7)
        np.testing.assert_allclose(now[2], (after[1] - before[1]) / (2 * step), atol=1e-5)
        turning = 2.0 * (after[0][6] - before[0][6]) / (2 * step) / now[0][3]
        assert turning == pytest.approx(now[1][5], abs=1e-7)


@pytest.mark.parametrize("place", ["side", "body", "base_excitation"])
def test_a_formula_is_the_sine_that_it_spells(place):
    def scene(**motion):
        if place == "side":
            return basin(tank={"left": {"motion": motion}})
        if place == "body":
            return driven(motion)
        return basin(base_excitation=motion)

    size = 0.02 if place == "side" else [0.02, 0.01]
    text = "{}*sin(6*t)"
    formula = text.format(0.02) if place == "side" else [text.format(part) for part in size]
    drives = []
    for motion in ({"amplitude": size, "frequency": 3.0 / math.pi}, {"formula": formula}):
        parameters = SPH.parameters(scene(**motion))
        of_bodies = [path.drive for _, path in parameters.bodies.paths]
        of_sides = [drive for _, drive in parameters.drives]
        (drive,) = [*of_bodies, *of_sides] or [parameters.base_excitation]
        drives.append([drive_at(drive, time) for time in (0.0, 0.07, 0.2)])
        drives[-1].append(parameters.material.fastest)
    for sine, formula in zip(*(drive[:3] for drive in drives), strict=True):
        for one, other in zip(sine, formula, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-14)
    assert drives[0][3] == pytest.approx(drives[1][3])


def moved_by_formulas():
    """A body that goes and turns, and a side that moves, by formulas."""
    motion = {"formula": ["0.03*sin(9*t)*tanh(20*t)", "0"], "angle_formula": "0.1*sin(5*t)"}
    left = {"motion": {"formula": "0.01*(1 - cos(7*t))"}}
    return dataclasses.replace(driven(motion, tank={"left": left}), duration=0.1, frame_every=0.05)


def test_a_pivot_holds_its_place():
    path = SPH.parameters(driven(LAWS["sine"] | {"amplitude": [0.0, 0.0]})).bodies.paths[0][1]
    corner = np.array([0.1, 0.02, 0.0]) - path.pose[:3]
    for time in (0.03, 0.2):
        (x, y, _, w, _, _, z), _, _ = on_path(path, time)
        angle = 2.0 * math.atan2(z, w)
        turned = [x + corner[0] * math.cos(angle) - corner[1] * math.sin(angle)]
        turned.append(y + corner[0] * math.sin(angle) + corner[1] * math.cos(angle))
        assert turned == pytest.approx([0.1, 0.02])


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(6))
def test_bodies_on_random_paths_do_the_work_that_the_liquid_gains(seed):
    """Energy less work never grows beyond what moving sides leave, and a body is where its path is."""
    generator = np.random.default_rng(seed)
    law = ("uniform", "sine", "table")[seed % 3]
    shape = [{"low": [0.12, 0.03], "high": [0.22, 0.08]}, {"center": [0.2, 0.05], "radius": 0.035}][seed % 2]
    size = float(generator.uniform(0.3, 1.0))
    motion = {
        "uniform": {"velocity": [0.25 * size, 0.0], "spin": float(generator.uniform(-1, 1))},
        "sine": {"amplitude": [0.04 * size, 0.0], "angle_amplitude": 0.2, "frequency": 1.5},
        "table": {"times": [0.0, 0.2], "positions": [[0.0, 0.0], [0.05 * size, 0.01]], "angles": [0.0, 0.2]},
    }[law]
    scene = driven(motion, shape, duration=0.15)
    work, energy, x = course(scene, "injected_work", "total_energy", "body0_x")
    assert abs(work[-1]) > 0.02  # rising, it does less than the weight of the liquid that takes its place
    assert (energy - energy[0] - work).max() < 0.05 * np.abs(work).max()
    path = SPH.parameters(scene).bodies.paths[0][1]
    assert x[-1] == pytest.approx(on_path(path, 0.15)[0][0], abs=1e-12)


@pytest.mark.long
@pytest.mark.compiled
def test_a_driven_body_pushes_a_free_one_and_is_not_pushed_back():
    pusher = {"low": [0.05, 0.0], "high": [0.1, 0.1], "motion": {"velocity": [0.5, 0.0]}}
    free = {"low": [0.12, 0.005], "high": [0.16, 0.045], "density": 3000.0, "restitution": 0.0}
    scene = basin(0.15, bodies=[pusher, free], fluid=[{"low": [0.3, 0.0], "high": [0.4, 0.05]}], gravity=[0.0, 0.0])
    last = list(ecume.simulate(scene))[-1].numbers
    assert last["body0_x"] == pytest.approx(0.075 + 0.5 * 0.15)
    assert last["body1_velocity_x"] == pytest.approx(0.5, rel=0.02)
    # Its kinetic energy and the same again, which the plastic impact took, are the work of the driven one.
    assert last["injected_work"] == pytest.approx(3000.0 * 0.04**2 * 0.5**2, rel=0.05)


DEEP = {"low": [0.0, 0.0, 0.0], "high": [0.2, 0.2, 0.1], "top": OPEN}


def test_a_flap_turns_about_any_axis_in_3d():
    motion = {"angle_amplitude": 0.3, "frequency": 1.0, "axis": [0.0, 2.0, 0.0], "pivot": [0.1, 0.1, 0.05]}
    body = {"low": [0.08, 0.08, 0.03], "high": [0.12, 0.12, 0.07], "motion": motion}
    scene = basin(deep=5, bodies=[body], tank=DEEP, fluid=[{"low": [0.0, 0.0, 0.0], "high": [0.2, 0.05, 0.1]}])
    pose, move, _ = on_path(SPH.parameters(scene).bodies.paths[0][1], 0.25)
    assert pose[3:] == pytest.approx([math.cos(0.15), 0.0, math.sin(0.15), 0.0])
    assert move == pytest.approx(np.zeros(6), abs=1e-12)


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        ({}, "expected exactly one law"),
        ({"velocity": [1.0, 0.0], "times": [0.0], "positions": [[0.0, 0.0]]}, "expected exactly one law"),
        ({"angle_amplitude": 0.1}, "frequency: is missing"),
        ({"times": [0.0, 1.0], "angles": [0.0]}, "angles: got 1 for 2 times"),
        ({"times": [0.0, 1.0]}, "needs positions, angles, or both"),
        ({"times": [1.0, 0.0], "angles": [0.0, 1.0]}, "times that ascend"),
        ({"velocity": [1.0, 0.0, 0.0]}, "velocity: got 3 numbers; the tank has 2"),
        ({"spin": 1.0, "axis": [1.0, 0.0, 0.0]}, "axis: in two dimensions a body turns about z alone"),
        ({"spin": 1.0, "until": 0.0}, "until: expected the end of a uniform motion"),
        ({"velocity": [-1.0, 0.0]}, "through the left side at t = 0.1"),
        ({"velocity": [1.0, 0.0], "frequency": 2.0}, "frequency: belongs to another law"),
        ({"times": [0.0, 1.0], "angles": [0.0, 1.0], "start": 0.1}, "start: belongs to another law"),
        ({"times": [0.0, 1.0], "positions": [[0.1, 0.0], [0.1, 0.0]]}, "has moved the body at t = 0"),
        ({"amplitude": [0.3, 0.0], "frequency": 199.0 / 0.2}, "through the (left|right) side"),
        ({"formula": ["t", "0"], "spin": 1.0}, "expected exactly one law"),
        ({"formula": ["t"]}, "formula: got 1 formulas; the tank has 2"),
        ({"formula": ["t", "y"]}, "formula: got 'y'; a formula knows t, pi"),
        ({"angle_formula": "cos(t)"}, "which is 1 at t = 0; expected 0"),
        ({"formula": ["0", "0.01*log(0.1 - t)"]}, "is -0.023 at t = 0"),
        ({"formula": ["0", "t/(0.1 - t)"]}, "has no finite value at t = 0.1"),
        ({"formula": ["5*t", "0"]}, "through the right side"),
    ],
)
def test_a_path_that_cannot_be_says_why(motion, said):
    with pytest.raises(SceneError, match=said):
        SPH.parameters(driven(motion))


def test_a_body_has_a_motion_or_a_mass():
    with pytest.raises(SceneError, match="density, mass, or a prescribed motion"):
        basin(bodies=[{"low": [0.1, 0.0], "high": [0.2, 0.1], "density": 500.0, "motion": {"spin": 1.0}}])
    with pytest.raises(SceneError, match="prescribes the velocity, too"):
        basin(bodies=[{"low": [0.1, 0.0], "high": [0.2, 0.1], "velocity": [1.0, 0.0], "motion": {"spin": 1.0}}])
