"""Thin layers do not lie on walls, and what keeps them off is a force like others."""

import numpy as np
import pytest

import ecume
from ecume.laws import wall_forces
from ecume.models.sph.boundaries.walls import add_impulses, reflect_particles
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN, tank
from tests.models.sph.test_sums import at_start


def collapsing(dimension=2, deep=16, **tables):
    """A column in the corner of a tank that becomes a layer thinner than a particle."""
    return from_plain(
        {
            "model": "sph",
            "duration": 2.0,
            "frame_every": 0.5,
            "spacing": 1.0 / deep,
            "gravity": [0.0, -1.0, 0.0][:dimension],
            "liquid": {"density": 1.0, "maximum_speed": 1.0},
            "tank": {"low": [0.0] * dimension, "high": [1.0, 1.0, 0.5][:dimension], "top": OPEN},
            "fluid": [{"low": [0.0] * dimension, "high": [0.25, 0.25, 0.5][:dimension]}],
            "method": {"jitter": 0.1},
            **tables,
        }
    )


@pytest.mark.compiled
@pytest.mark.parametrize(("dimension", "deep"), [(2, 16), (3, 12)])
def test_a_layer_thinner_than_a_particle_does_not_lie_on_the_floor(dimension, deep):
    (*_, last) = ecume.simulate(collapsing(dimension, deep))
    assert last.numbers["guard_hits"] == 0
    assert last.arrays["position"][:, 1].min() * deep > 0.05
    assert last.numbers["leaning"] > 0


@pytest.mark.compiled
def test_no_particle_touches_a_wall_in_a_tank_at_rest():
    assert [frame.numbers["leaning"] for frame in ecume.simulate(tank(deep=12))] == [0.0] * 11


def pressed(**tables):
    """Parameters and state of a liquid whose lowest and leftmost particles stand too close to what is there."""
    scene = from_plain({**to_plain(tank(deep=16, jitter=0.0, artificial_viscosity=0.0)), **tables})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    for axis in range(2):
        state.position[axis, state.position[axis] < 0.05] -= 0.028
    state.reference[...] = state.position
    return parameters, state, SPH.workspace(parameters, state, 1.0)


@pytest.mark.compiled
@pytest.mark.parametrize("obstacles", [[], [{"low": [0.375, 0.375], "high": [0.625, 0.625]}]])
def test_walls_and_obstacles_report_the_force_on_the_liquid(obstacles):
    parameters, state, workspace = pressed(obstacles=obstacles)
    if obstacles:
        below = (np.abs(state.position[0] - 0.5) < 0.1) & (state.position[1] < 0.375)
        state.position[1, below] += 0.372 - state.position[1, below].max()
    SPH.advance(parameters, state, workspace, 1)
    frame = SPH.observe(parameters, state, workspace)
    got = (state.acceleration - parameters.gravity[:, None]) @ state.mass
    report = [sum(frame.numbers[key] for key in frame.numbers if key.endswith(f"force_{axis}")) for axis in "xy"]
    np.testing.assert_allclose(report, -got, rtol=1e-10)
    assert frame.numbers["leaning"] >= 31


@pytest.mark.compiled
def test_what_a_body_pushes_off_pushes_it():
    body = {"low": [0.4, 0.4], "high": [0.6, 0.6], "density": 1.0}
    parameters, state, workspace = pressed(bodies=[body], tank={"low": [-1.0, -1.0], "high": [2.0, 2.0]})
    close = np.argmin(np.linalg.norm(state.position.T - [0.3, 0.5], axis=1))
    state.position[:, close] = 0.396, 0.5
    SPH.advance(parameters, state, workspace, 1)
    frame = SPH.observe(parameters, state, workspace)
    leaning = frame.numbers["leaning"]
    push = state.body_acceleration[:2, 0] - parameters.gravity
    got = (state.acceleration - parameters.gravity[:, None]) @ state.mass
    np.testing.assert_allclose(got, -parameters.bodies.mass[0] * push, atol=1e-12)
    assert leaning == 1


@pytest.mark.compiled
def test_who_falls_onto_a_floor_comes_back_as_fast():
    scene = collapsing(fluid=[{"low": [0.5, 0.5], "high": [0.5625, 0.5625]}], method={"artificial_viscosity": 0.0})
    frames = list(ecume.simulate(scene))
    assert len(frames[0].arrays["mass"]) == 1
    energy = [frame.numbers["total_energy"] for frame in frames]
    assert frames[-1].numbers["guard_hits"] == 0
    assert energy[-1] == pytest.approx(energy[0], rel=0.01)


def test_the_push_is_the_slope_of_its_energy():
    for gap in (-0.02, 0.03, 0.09, 0.2):
        ahead, behind = (wall_forces.standoff_energy(gap + step, 0.1, 3.0) for step in (1e-6, -1e-6))
        assert wall_forces.standoff_push(gap, 0.1, 3.0) == pytest.approx((behind - ahead) / 2e-6, rel=1e-6)


@pytest.mark.compiled
def test_walls_that_only_reflect_do_nothing_else():
    (*_, last) = ecume.simulate(tank(walls="reflect"))
    assert last.numbers["leaning"] == 0
    assert last.numbers["guard_hits"] > 0


def test_a_particle_turned_back_in_a_corner_pushes_each_side_along_its_normal():
    parameters, state, _ = at_start(tank(jitter=0.0))
    guard, mass = parameters.boundary.guard, float(state.mass[0])
    who = np.argsort(state.position[0] + state.position[1])[:1]
    state.position[:, who], state.velocity[:, who] = [[-0.01], [-0.02]], [[-1.0], [-3.0]]
    met = reflect_particles(guard, state.position, state.velocity, np.zeros_like(state.velocity), 0.05)
    add_impulses(parameters, state, met)
    forces = {name: state.struck[row, :2] * parameters.time_step for row, name in enumerate(parameters.boundary.names)}
    np.testing.assert_allclose(forces["left"], [-mass * met.change[0, 0], 0.0], atol=1e-12)
    np.testing.assert_allclose(forces["bottom"], [0.0, -mass * met.change[1, 0]], atol=1e-12)
    assert met.change.min() > 1.0


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("walls", "solids"), [("mirror", []), ("dummy", []), ("mirror", [{"low": [0.9, 0.0], "high": [1.1, 0.15]}])]
)
def test_solids_bear_all_momentum_of_an_incompressible_liquid(walls, solids):
    """Its forces are means over each step. Without impulses of the guard they missed a third, evaluated after the step
    6 to 16 % of the changes of momentum; what is left is the damping of approach, by velocities after the step.
    """
    end = 2.5
    scene = from_plain(
        {
            "model": "sph", "duration": end, "frame_every": end / 400, "spacing": 1.0 / 24, "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0}, "tank": {"high": [1.6, 1.5], "top": OPEN, "walls": walls},
            "fluid": [{"low": [0.0, 0.0], "high": [0.5, 0.5]}], "obstacles": solids,
            "method": {"pressure": "incompressible"},
        }
    )  # fmt: skip
    frames = list(ecume.simulate(scene))
    assert frames[-1].numbers["substeps"] == 400
    assert frames[-1].numbers["guard_hits"] > 0
    weight = frames[0].arrays["mass"].sum()
    for axis, pull in (("x", 0.0), ("y", -weight)):
        momentum = np.array([frame.numbers[f"momentum_{axis}"] for frame in frames])
        names = [name for name in frames[0].numbers if name.endswith(f"_force_{axis}")]
        force = np.array([sum(frame.numbers[name] for name in names) for frame in frames])
        missed = np.diff(momentum) + (force[1:] - pull) * end / 400
        assert np.sum(missed**2) < 0.02**2 * np.sum((np.diff(momentum) - pull * end / 400) ** 2)
