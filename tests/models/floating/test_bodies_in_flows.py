"""Floats with shapes in flows and moving dishes, with dipoles and active forces."""

import itertools
import math

import numpy as np
import pytest

from ecume.laws.contact_lines import elongation, spin_in_flow
from ecume.models import MODELS
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.floating.time_integration.integration import forces_at
from tests.models import begun
from tests.models.floating.bowls import scene_of

# The functions are those of other runs; each combination of parts is compiled by itself.
pytestmark = pytest.mark.uncompiled

FLOATING = MODELS["floating"]
LIQUID = '[liquid]\ndensity = 1000.0\nviscosity = "20 mPa*s"\nsurface_tension = "72.8 mN/m"\n'
BEAD = "radius = 5e-4\ndensity = 800.0\ncontact_angle = 1.2\n"
ELLIPSOID = 'shape = { kind = "ellipsoid", width = 4e-4 }\n'
ALONE = '[interaction]\nlaw = "none"\n'
STOKES = '[hydrodynamics]\ndrag = "stokes"\n'
OVERDAMPED = '[integration]\nintegrator = "overdamped"\n'


def at(angle):
    return f'shape = {{ kind = "ellipsoid", width = 4e-4, angle = {angle} }}\n'


def scene_with(floats, rest, **times):
    return scene_of(f"{LIQUID}{floats}{rest}", **times)


def beads(places, more=""):
    return f"[[particles]]\n{BEAD}{more}positions = {[list(place) for place in places]}\n"


def after(scene, steps):
    parameters, state, workspace = begun(scene)
    assert FLOATING.advance(parameters, state, workspace, steps) == 0
    return parameters, state, FLOATING.observe(parameters, state, workspace).numbers


SURROUNDINGS = {
    "dish in motion": '[dish]\nradius = 0.05\nlaw = "none"\nmotion = { amplitude = 1e-3, frequency = 5.0, '
    "velocity = [1e-3, 0.0], entrainment = 0.25 }\n",
    "uniform flow": "[flow]\nvelocity = [2e-3, -1e-3]\n",
    "flow": "[flow]\nvelocity = [2e-3, -1e-3]\nshear_rate = 2.0\nrotation_rate = 1.0\nextension_rate = 0.5\n",
    "wall profile": '[dish]\nradius = 0.05\nlaw = "profile"\n',
    "active forces": "[activity]\nforce = 1e-7\npersistence = 0.1\n",
    "dipoles": "",
}


@pytest.mark.parametrize(
    ("around", "integrator"),
    [*itertools.product(SURROUNDINGS, ["velocity-verlet", "overdamped"])],
)
def test_a_sphere_beside_a_far_ellipsoid_moves_as_in_a_scene_of_spheres(around, integrator):
    moment = "magnetic_moment = 1e-8\n" if around == "dipoles" else ""
    far = (0.0, -0.03)
    rest = f'{SURROUNDINGS[around]}[integration]\nintegrator = "{integrator}"\ntime_step = 2e-4\n{STOKES}'
    two = beads([(3e-3, 1e-3), (4.5e-3, 1e-3)], moment)
    times = {"duration": 0.02, "frame_every": 0.02}
    round_floats = after(scene_with(two + beads([far]), rest, **times), 40)[1:]
    shaped = after(scene_with(two + beads([far], ELLIPSOID), rest, **times), 40)[1:]
    moved = round_floats[0].position[:2] - [(3e-3, 1e-3), (4.5e-3, 1e-3)]
    assert np.abs(moved).max() > 1e-9
    # The charge of the far ellipsoid differs by its size, and its pull by less than this.
    assert shaped[0].position[:2] == pytest.approx(round_floats[0].position[:2], abs=1e-6 * np.abs(moved).max() + 1e-14)
    assert shaped[0].velocity[:2] == pytest.approx(round_floats[0].velocity[:2], rel=1e-6, abs=1e-12)


def test_a_lone_sphere_given_as_an_ellipsoid_takes_the_work_of_a_flow_as_a_round_float_does():
    rest = SURROUNDINGS["uniform flow"] + ALONE + STOKES + "[integration]\ntime_step = 1e-4\n"
    found = []
    for more in ("", 'shape = { kind = "ellipsoid", width = 1e-3 }\n'):
        scene = scene_with(beads([(3e-3, 1e-3)], more), rest, duration=0.02, frame_every=0.02)
        _, state, numbers = after(scene, 60)
        assert numbers["injected_work"] > numbers["kinetic_energy"] > 0.0
        found.append([*state.position[0], *state.velocity[0], numbers["injected_work"], numbers["kinetic_energy"]])
    assert found[1] == pytest.approx(found[0], rel=1e-9)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "overdamped"])
def test_an_ellipsoid_in_a_shear_flow_turns_as_jeffery_says(integrator):
    rate, ratio = 4.0, 2.5
    rest = f"[flow]\nshear_rate = {rate}\n{ALONE}" + f'[integration]\nintegrator = "{integrator}"\ntime_step = 2e-3\n'
    scene = scene_with(beads([(0.0, 0.0)], at(0.5)), rest, duration=2.0, frame_every=2.0)
    parameters, state, _ = after(scene, 200)
    start = math.atan(ratio * math.tan(0.5))
    # tan phi = tan(theta)/ratio, with theta falling at the rate g/(ratio + 1/ratio).
    theta = start - rate / (ratio + 1.0 / ratio) * 200 * parameters.time_step
    expected = math.atan2(math.sin(theta), ratio * math.cos(theta))
    turned = state.turning[0, 0]
    assert abs(math.remainder(turned - expected, 2.0 * math.pi)) < 1e-3
    assert 0.5 - turned > 0.3
    assert np.abs(state.position).max() < 1e-12


def test_the_spin_in_a_flow_follows_from_the_torque_of_a_needle_and_of_a_disc():
    """A needle turns with a material line; a disc with the liquid. Rotating both frames changes nothing."""
    gradient = np.array([[0.3, -0.8], [0.5, -0.3]])
    rotation, shear = gradient[1, 0] - gradient[0, 1], gradient[1, 0] + gradient[0, 1]
    extension = gradient[0, 0] - gradient[1, 1]
    for angle in (0.0, 0.4, 2.0):
        way = np.array([math.cos(angle), math.sin(angle)])
        line = np.array([-way[1], way[0]]) @ gradient @ way
        assert spin_in_flow(angle, 1.0, rotation, shear, extension) == pytest.approx(line, rel=1e-12)
        assert spin_in_flow(angle, 0.0, rotation, shear, extension) == pytest.approx(0.5 * rotation, rel=1e-12)
    assert elongation(2.0, 1.0) == -elongation(1.0, 2.0) == 0.6


def test_an_active_ellipsoid_swims_along_itself_at_the_speed_of_its_drag():
    rest = f"[activity]\npropulsion = 1e-7\n{OVERDAMPED}{ALONE}"
    scene = scene_with(beads([(0.0, 0.0)], at(0.7)), rest, duration=0.1, frame_every=0.1)
    _, state, _ = after(scene, 3)
    along = float_kinds(scene)[0].figure.friction[0]
    expected = 1e-7 / along * np.array([math.cos(0.7), math.sin(0.7)])
    assert state.velocity[0] == pytest.approx(expected, rel=1e-9)
    assert state.turning[0].tolist() == [0.7, 0.0]


def test_a_body_in_a_moving_dish_is_left_behind_less_across_itself():
    dish = '[dish]\nradius = 0.05\nlaw = "none"\nmotion = { velocity = [1e-3, 0.0] }\n'
    scene = scene_with(beads([(0.0, 0.0)], at(0.25 * math.pi)), dish + ALONE, duration=0.02, frame_every=0.02)
    parameters, state, numbers = after(scene, 30)
    kind = float_kinds(scene)[0]
    time = 30 * parameters.time_step
    left = [1e-3 * math.sqrt(0.5) * -math.expm1(-friction / kind.mass * time) for friction in kind.figure.friction[:2]]
    # Along (1, 1) and across, (-1, 1), of a drag toward -x.
    assert state.velocity[0] == pytest.approx(
        np.array([-left[0] - left[1], left[1] - left[0]]) * math.sqrt(0.5), rel=1e-9
    )
    assert state.turning[0, 1] == 0.0
    assert numbers["injected_work"] > numbers["kinetic_energy"] > 0.0


def test_an_ellipsoid_that_turns_while_a_flow_carries_it_follows_the_flow():
    """Its frictions turn with it. With those of the beginning of a step its path is off by 0.002 of its length."""
    speed, rate, time = 2e-3, 4.0, 0.4
    rest = f"[flow]\nvelocity = [{speed}, 0.0]\nrotation_rate = {rate}\n{ALONE}"
    rest += '[integration]\nintegrator = "overdamped"\ntime_step = 5e-3\n'
    scene = scene_with(beads([(0.0, 0.0)], at(0.5)), rest, duration=time, frame_every=time)
    _, state, _ = after(scene, 80)
    expected = speed / rate * np.array([math.sin(rate * time), 1.0 - math.cos(rate * time)])
    assert state.position[0] == pytest.approx(expected, abs=2e-4 * np.hypot(*expected))
    assert state.turning[0, 0] == pytest.approx(0.5 + rate * time, rel=1e-9)


@pytest.mark.filterwarnings("ignore:integration.time_step.* is coarse:UserWarning")
@pytest.mark.parametrize("integrator", ["velocity-verlet", "semi-implicit-euler", "overdamped"])
def test_a_body_keeps_its_distance_from_the_center_of_a_rotation_to_second_order(integrator):
    """Drag acts within a step. With the flow of the beginning of a step the distance grows by half of the step in each
    radian, and a mean error of second order is left of the angle.
    """
    rate, wrong = 100.0, []
    small = "[[particles]]\nradius = 2e-5\ndensity = 1100.0\ncontact_angle = 1.2\npositions = [[3e-4, 0.0]]\n"
    small += 'shape = { kind = "ellipsoid", width = 1.6e-5, angle = 0.3 }\n'
    for step in (5e-4, 2.5e-4):
        rest = f"[flow]\nrotation_rate = {rate}\n{ALONE}{STOKES}"
        rest += f'[integration]\nintegrator = "{integrator}"\ntime_step = {step}\n'
        scene = scene_with(small, rest, duration=0.04, frame_every=0.04)
        parameters, state, _ = after(scene, round(0.04 / step))
        assert step > 20.0 * float(parameters.floats.relaxation_time.max())
        wrong.append(math.hypot(*state.position[0]) / 3e-4 - 1.0)
        assert abs(wrong[-1]) < 0.1 * rate * 0.04 * rate * step
    assert abs(wrong[0]) > 3.0 * abs(wrong[1])


def test_the_force_of_an_exact_profile_on_a_body_along_the_wall_is_the_slope_of_its_energy():
    """Its charges are nearer to the wall than its radius; the table of the wall reaches there."""
    dish = '[dish]\nradius = 0.02\nlaw = "profile"\ncontact_angle = 0.5\n'
    shift, place = 1e-7, 0.02 - 2.2e-4
    found = []
    for x in (place - shift, place, place + shift):
        scene = scene_with(beads([(x, 0.0)], at(0.5 * math.pi)), dish, duration=1.0, frame_every=1.0)
        parameters, state, workspace = begun(scene)
        found.append(
            (
                forces_at(parameters, state.position, workspace)[0, 0],
                FLOATING.observe(parameters, state, workspace).numbers["wall_energy"],
            )
        )
    (_, before), (force, _), (_, behind) = found
    assert force == pytest.approx((before - behind) / (2.0 * shift), rel=1e-6)
    assert abs(force) > 1e-7
