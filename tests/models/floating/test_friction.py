"""Floats with surface friction."""

import math

import numpy as np
import pytest

from ecume import _jit
from ecume.errors import SceneError
from ecume.laws.drag import sphere_inertia, sphere_turning_friction
from ecume.laws.immersion import turning_factor
from ecume.models import MODELS
from ecume.models.floating.setup.kinds import float_kinds
from ecume.simulation import simulate
from tests.models.floating.bowls import HEAVY, WATER, scene_of
from tests.models.floating.test_rafts import digest, end_of

CROWD = (
    f'[[particles]]\nname = "a"\ncount = 25\n{HEAVY}'
    '[[particles]]\nname = "b"\ncount = 25\nradius = 0.7e-3\ndensity = 1100.0\ncontact_angle = 1.5707963\n'
    "velocity = [0.01, 0.0]\n"
)


def grazing(friction, *, restitution=0.5, viscosity=0.0, integrator="velocity-verlet", **times):
    """Two equal spheres without forces except contacts, which collide on the x axis while one moves along y."""
    floats = (
        f"[[particles]]\n{HEAVY}positions = [[-0.0011, 0.0]]\nvelocity = [0.04, 0.01]\n"
        f'[[particles]]\nname = "b"\n{HEAVY}positions = [[0.0011, 0.0]]\nvelocity = [-0.04, 0.01]\n'
        f'[[particles]]\nname = "c"\n{HEAVY}positions = [[0.5, 0.0]]\n'
    )
    drag = "stokes" if viscosity else "none"
    liquid = f"[liquid]\nviscosity = {max(viscosity, 1e-3)}\n"
    rest = f'[integration]\nintegrator = "{integrator}"\ntime_step = 1e-4\n'
    rest += f'[hydrodynamics]\ndrag = "{drag}"\n[interaction]\nlaw = "none"\n'
    contacts = f"[contacts]\nrestitution = {restitution}\nfriction = {friction}\n"
    return scene_of(liquid + floats.replace("[-0.04, 0.01]", "[-0.04, -0.01]") + rest + contacts, **times)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "stormer-verlet", "rk4"])
@pytest.mark.parametrize(("friction", "slides"), [(0.02, True), (0.5, False)])
def test_a_grazing_collision_gives_the_impulses_of_coulombs_law(friction, slides, integrator):
    *_, after = simulate(grazing(friction, integrator=integrator, duration=0.004, frame_every=0.002))
    mass, radius = after.arrays["mass"][0], after.arrays["radius"][0]
    # They touch after 2.5 ms, each 25 um off the axis, on opposite sides.
    tilt = math.asin(2 * 25e-6 / (2 * radius))
    approach = 0.08 * math.cos(tilt) + 0.02 * -math.sin(tilt)
    along = 0.02 * math.cos(tilt) + 0.08 * math.sin(tilt)
    normal, sticking = 1.5 * 0.5 * mass * approach, 1.5 * mass / 7.0 * along
    assert (friction * normal < sticking) == slides
    inertia = sphere_inertia(mass, radius)
    pushed = after.arrays["spin"][0] * inertia / radius
    assert abs(pushed) == pytest.approx(min(friction * normal, sticking), rel=0.02)
    assert after.arrays["spin"][0] == pytest.approx(after.arrays["spin"][1], rel=1e-12)
    assert after.numbers["collisions"] == 1


@pytest.mark.long
@pytest.mark.compiled
def test_a_spin_dies_away_as_the_drag_says():
    scene = grazing(0.5, viscosity=5e-3, duration=0.04, frame_every=0.01)
    frames, floats = list(simulate(scene)), float_kinds(scene)[0]
    arrays = frames[-1].arrays
    friction = sphere_turning_friction(1e-3, 5e-3, turning_factor(math.pi - floats.equilibrium.filling_angle))
    decay = math.exp(-friction / sphere_inertia(arrays["mass"][0], 1e-3) * 0.02)
    assert decay < 0.9
    assert arrays["spin"][0] / frames[2].arrays["spin"][0] == pytest.approx(decay, rel=1e-6)


@pytest.mark.long
@pytest.mark.compiled
def test_momentum_and_angular_momentum_last_through_many_collisions_with_friction():
    rest = "[hydrodynamics]\ndrag = 'none'\n[contacts]\nrestitution = 0.7\nfriction = 0.3\n"
    frames = list(simulate(scene_of(WATER + CROWD + rest, duration=2.0)))
    last, arrays = frames[-1].numbers, frames[-1].arrays
    pace = arrays["mass"] * np.hypot(*arrays["velocity"].T)
    assert last["collisions"] > 30
    assert np.max(np.abs(arrays["spin"])) > 1.0
    for name in ("momentum_x", "momentum_y"):
        assert last[name] == pytest.approx(frames[0].numbers[name], abs=1e-12 * np.sum(pace))
    around = np.sum(pace * np.hypot(*arrays["position"].T))
    # Nobody got so deep into another that places had to be moved.
    assert last["deepest_overlap"] < 1e-4 * np.min(arrays["radius"])
    assert last["angular_momentum"] == pytest.approx(frames[0].numbers["angular_momentum"], abs=1e-12 * around)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("among", "at_wall"), [(0.3, 0.0), (1.0, 0.5)])
def test_friction_takes_energy_and_makes_none_in_a_bowl_that_comes_to_rest(among, at_wall):
    body = f"{WATER}[[particles]]\ncount = 30\n{HEAVY}[dish]\nradius = 0.014\nfriction = {at_wall}\n"
    frames = list(simulate(scene_of(f"{body}[contacts]\nfriction = {among}\n", duration=8.0, frame_every=0.2)))
    energies = np.array([frame.numbers["total_energy"] for frame in frames])
    rises, last = np.diff(energies), frames[-1].numbers
    assert np.sum(rises[rises > 0]) < 1e-6 * np.ptp(energies)
    # With so much friction a braced raft may have no solution that sweeps find: rarely, and never without.
    assert last["unconverged_steps"] <= (5 if among == 1.0 else 0)
    assert last["deepest_overlap"] < 1e-3 * 1e-3


@pytest.mark.long
@pytest.mark.compiled
def test_a_rough_raft_at_rest_at_a_wall_takes_tens_of_sweeps_a_step_without_inertia():
    # One that is kicked before the drift alone is solved for once a step: a second solve, which has next to nothing to
    # stop, began with all the impulses of the first, and took thousands of sweeps to lose them.
    body = f"{WATER}[[particles]]\ncount = 20\n{HEAVY}[dish]\nradius = 0.0105\nfriction = 0.2\n"
    scene = scene_of(
        f'{body}[contacts]\nfriction = 0.4\n[integration]\nintegrator = "overdamped"\n', duration=0.2, frame_every=0.1
    )
    _, middle, end = simulate(scene)
    steps = MODELS["floating"].parameters(scene).steps_per_frame
    assert (end.numbers["contact_sweeps"] - middle.numbers["contact_sweeps"]) / steps < 100
    # While a braced raft folds a few solves may end in circles; at rest none does.
    assert end.numbers["unconverged_steps"] == middle.numbers["unconverged_steps"] <= 5
    assert end.numbers["deepest_overlap"] < 1e-3 * 1e-3


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("duration", [0.002, pytest.param(0.006, marks=pytest.mark.long)])
def test_a_large_rough_raft_has_the_same_bits_for_any_number_of_threads(duration):
    scene = scene_of(
        f'{WATER}[[particles]]\ncount = 2100\nplacement = "lattice"\nspacing = 2.001e-3\n{HEAVY}'
        "[contacts]\nfriction = 0.3\n",
        duration=duration,
        frame_every=duration,
    )
    ends = []
    for threads in (1, 2):
        _jit.use_threads(threads)
        ends.append(end_of(scene))
    assert ends[0] == ends[1]


@pytest.mark.parametrize(
    ("rest", "why"),
    [
        ('[contacts]\nfriction = 0.3\nlaw = "none"\n', "solved as impulses"),
        ("[contacts]\nfriction = 0.3\nlegacy_coefficient = 0.3\n", "legacy coefficient"),
    ],
)
def test_friction_that_cannot_be_had_is_refused(rest, why):
    with pytest.raises(SceneError, match=why):
        MODELS["floating"].parameters(scene_of(f"{WATER}[[particles]]\n{HEAVY}{rest}"))


def test_floats_without_friction_have_no_spins():
    scene = scene_of(f"{WATER}[[particles]]\n{HEAVY}")
    state = MODELS["floating"].start(scene, MODELS["floating"].parameters(scene))
    assert state.turning.shape == (1, 0)
    assert digest(state)
