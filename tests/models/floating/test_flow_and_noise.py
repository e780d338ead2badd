"""Overdamped floats with thermal noise and in flows of the surface."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.floating.time_integration.integrators import add_noise
from ecume.models.floating.time_integration.step_size import diffusion_step, longest_good_step
from ecume.simulation import simulate
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
SMALL = "radius = 2e-5\ndensity = 1500.0\ncontact_angle = 1.2\n"
ALONE = '[interaction]\nlaw = "none"\n'


def creeping(body, temperature=0.0, flow="", **times):
    warm = f"temperature = {temperature}\n" if temperature else ""
    brownian = f"brownian = {str(temperature > 0.0).lower()}\n"
    motion = f'[integration]\nintegrator = "overdamped"\n[hydrodynamics]\n{brownian}'
    return scene_of(WATER + warm + flow + body + motion, **times)


def test_a_creeping_float_goes_with_force_over_friction_at_once():
    floats = f"[[particles]]\n{SMALL}positions = [[0.0, 0.0], [2e-4, 0.0]]\n"
    scene = creeping(floats, duration=1e-3, frame_every=1e-3)
    parameters = FLOATING.parameters(scene)
    assert not parameters.scheme.inertia
    assert np.all(parameters.kick.decay == 0.0)
    state = FLOATING.start(scene, parameters)
    workspace = FLOATING.workspace(parameters, state, 1.0)
    FLOATING.advance(parameters, state, workspace, 1)
    friction = parameters.floats.mass / parameters.floats.relaxation_time
    found = state.velocity[:, 0] * friction
    from ecume.laws import flotation

    bead = flotation.Sphere(2e-5, 1500.0, 1.2)
    pull = flotation.pair_force(bead, bead, 2e-4, flotation.Liquid(1000.0, 0.0728, 1e-3), "nonlinear")
    assert found == pytest.approx([-pull, pull], rel=1e-6)


def test_the_step_of_creeping_floats_follows_drag_alone():
    floats = f"[[particles]]\n{SMALL}positions = [[0.0, 0.0], [1e-4, 0.0]]\n"
    slow, fast = (
        longest_good_step(FLOATING.parameters(creeping(floats.replace("1500.0", density))), 0.0)
        for density in ("1500.0", "3000.0")
    )
    assert fast < slow  # a heavier charge pulls harder


def test_noise_spreads_floats_by_twice_the_diffusion_coefficient():
    count, temperature = 1500, 300.0
    floats = f'[[particles]]\ncount = {count}\n{SMALL}placement = "lattice"\nspacing = 1e-3\n'
    scene = creeping(floats + ALONE, temperature)
    parameters = FLOATING.parameters(scene)
    velocity = np.zeros((count, 2))
    for step in range(4):
        add_noise(parameters, velocity, step)
    moved = velocity * parameters.time_step
    friction = parameters.floats.mass[0] / parameters.floats.relaxation_time[0]
    expected = 4 * 2 * 1.380649e-23 * temperature / friction * parameters.time_step
    found = np.mean(moved**2, axis=0) / expected
    assert found == pytest.approx([1.0, 1.0], abs=5 * math.sqrt(2 / count))
    assert abs(np.mean(moved[:, 0] * moved[:, 1])) < 5 * expected / math.sqrt(count)
    again = np.zeros((count, 2))
    for step in range(4):
        add_noise(parameters, again, step)
    assert np.array_equal(again, velocity)


@pytest.mark.long
@pytest.mark.compiled
def test_brownian_motion_has_the_temperature_of_the_scene_to_two_percent():
    """Displacements of free floats step by step: 60,000 independent numbers, whose variance has a standard error of
    0.6 %.
    """
    count, steps, temperature = 300, 100, 300.0
    floats = f'[[particles]]\ncount = {count}\n{SMALL}placement = "lattice"\nspacing = 1e-3\n'
    scene = creeping(floats + ALONE, temperature)
    parameters, state, workspace = begun(scene)
    squares = 0.0
    for _ in range(steps):
        before = state.position.copy()
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        squares += float(np.sum((state.position - before) ** 2))
    friction = parameters.floats.mass[0] / parameters.floats.relaxation_time[0]
    expected = 2.0 * 1.380649e-23 * temperature / friction * parameters.time_step
    standard_error = math.sqrt(2.0 / (2 * count * steps))
    assert squares / (2 * count * steps) / expected == pytest.approx(1.0, abs=3.5 * standard_error)


def test_warm_floats_take_steps_small_beside_their_radius():
    parameters = FLOATING.parameters(creeping(f"[[particles]]\n{SMALL}{ALONE}", 300.0))
    friction = parameters.floats.mass[0] / parameters.floats.relaxation_time[0]
    far = math.sqrt(2 * parameters.drift.thermal / friction * diffusion_step(parameters))
    assert far == pytest.approx(0.05 * 2e-5)
    assert parameters.drift.jump > 0.0
    assert diffusion_step(FLOATING.parameters(creeping(f"[[particles]]\n{SMALL}{ALONE}"))) == math.inf


def test_the_longest_step_of_noise_fits_into_the_neighbor_lists():
    """In its own step, not one that short frames limit."""
    places = [[0.0, 0.0], [1e-4, 0.0]]
    for radius in (1e-6, 2e-5):
        floats = f"[[particles]]\nradius = {radius}\ndensity = 1500.0\ncontact_angle = 1.2\npositions = {places}\n"
        scene = creeping(floats + ALONE, 300.0, duration=1e4, frame_every=1e4)
        parameters = FLOATING.parameters(scene)
        state = FLOATING.start(scene, parameters)
        assert parameters.time_step > 0.9 * diffusion_step(parameters)
        assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 40) == 0


@pytest.mark.parametrize("integrator", ["overdamped", "velocity-verlet"])
@pytest.mark.parametrize(
    ("flow", "velocity"),
    [
        ("velocity = [2e-3, -1e-3]", (2e-3, -1e-3)),
        ("shear_rate = 0.5", (0.5 * 2e-3, 0.0)),
        ("rotation_rate = 0.3", (-0.3 * 2e-3, 0.3 * 1e-3)),
        ("extension_rate = 0.2", (0.2 * 1e-3, -0.2 * 2e-3)),
    ],
)
def test_a_float_takes_on_the_velocity_of_the_surface(flow, velocity, integrator):
    body = f'[[particles]]\n{SMALL}positions = [[1e-3, 2e-3]]\n[integration]\nintegrator = "{integrator}"\n'
    scene = scene_of(f"{WATER}[flow]\n{flow}\n{body}", duration=0.004, frame_every=0.002)
    frames = list(simulate(scene))
    assert frames[-1].arrays["velocity"][0] == pytest.approx(velocity, rel=0.02, abs=2e-5)


def test_a_table_of_a_linear_flow_is_that_flow_and_ends_as_at_its_edge():
    places = "[[0.4e-3, -0.3e-3], [0.1e-3, 0.7e-3], [5e-3, 0.2e-3]]"
    motion = '[integration]\nintegrator = "overdamped"\ntime_step = 1e-3\n'
    body = f"[[particles]]\n{SMALL}positions = {places}\n{motion}{ALONE}"
    x, y = (-1e-3, 0.0, 1e-3), (-1e-3, -0.5e-3, 0.0, 0.5e-3, 1e-3)
    vx, vy = [[-0.3 * b for b in y] for a in x], [[0.3 * a for b in y] for a in x]
    table = f"nodes = {{ low = [-1e-3, -1e-3], high = [1e-3, 1e-3], vx = {vx}, vy = {vy} }}"
    found = []
    for flow in ("rotation_rate = 0.3", table):
        scene = scene_of(f"{WATER}[flow]\n{flow}\n{body}", duration=1e-3, frame_every=1e-3)
        parameters = FLOATING.parameters(scene)
        state = FLOATING.start(scene, parameters)
        FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 1)
        found.append(state.velocity.copy())
    assert found[1][:2] == pytest.approx(found[0][:2], rel=1e-12)
    assert found[1][2] == pytest.approx([-0.3 * (0.2e-3 + 0.5e-3 * 0.3e-3), 0.3 * 1e-3], rel=1e-12)


@pytest.mark.uncompiled  # multipoles and flows are compiled by others
def test_floats_on_one_surface_are_carried_as_well():
    body = f'[[particles]]\n{SMALL}positions = [[0.0, 0.0], [0.03, 0.0]]\n[integration]\nintegrator = "overdamped"\n'
    body += '[interaction]\nmethod = "multipole"\norder = 2\n'
    scene = scene_of(f"{WATER}[flow]\nvelocity = [1e-3, 2e-3]\n{body}", duration=0.002, frame_every=0.002)
    last = list(simulate(scene))[-1]
    assert last.arrays["velocity"] == pytest.approx(np.array([[1e-3, 2e-3]] * 2), rel=1e-3)


@pytest.mark.parametrize(
    ("motion", "kind"),
    [("overdamped", "rotation"), ("overdamped", "table"), ("coupled", "rotation"), ("inertia", "rotation")],
)
def test_a_rotating_surface_turns_floats_around_at_the_same_distance(motion, kind):
    """In 500 steps of 1/500 rad: with the current at the beginning of each step, distances would grow by 0.1 %."""
    x = (-2.1e-3, 2.1e-3)
    table = f"nodes = {{ low = [{x[0]}, {x[0]}], high = [{x[1]}, {x[1]}], vx = {[[-y for y in x]] * 2}, "
    table += f"vy = {[[place] * 2 for place in x]} }}"
    flow = "rotation_rate = 1.0" if kind == "rotation" else table
    integrator = "" if motion == "inertia" else 'integrator = "overdamped"\n'
    body = f"[[particles]]\n{SMALL}positions = [[1e-3, 0.0], [-2e-3, 0.0]]\nvelocity = [0.0, 1e-3]\n{ALONE}"
    body += f"[integration]\n{integrator}time_step = 0.002\n"
    body += '[hydrodynamics]\ninteraction = "rotne-prager"\n' * (motion == "coupled")
    parameters, state, workspace = begun(scene_of(f"{WATER}[flow]\n{flow}\n{body}", duration=6.0, frame_every=6.0))
    assert FLOATING.advance(parameters, state, workspace, 500) == 0
    # The midpoint rule adds an eighth of the fourth power of an angle in each step.
    distance = np.hypot(*state.position.T) / [1e-3, 2e-3]
    assert distance == pytest.approx([1.0, 1.0], abs=500 * 0.002**4 / 4.0 + 2e-4 * (motion == "inertia"))
    assert math.atan2(*state.position[0, ::-1]) == pytest.approx(1.0, abs=500 * 0.002**3 / 5.0)


# The step that is advised is for floats at the wall, where the meniscus is steep; these stay in the middle.
@pytest.mark.long
@pytest.mark.filterwarnings("ignore:integration.time_step")
@pytest.mark.compiled
def test_warm_floats_spread_in_a_well_as_boltzmann_says():
    """In the middle of a small dish, whose meniscus is a spring there: <x^2> = kT/k, a little more for the steps."""
    floats = f'[[particles]]\ncount = 100\n{SMALL}placement = "lattice"\nspacing = 5e-5\n'
    dish = '[dish]\nradius = 0.003\ncontact_angle = "10 deg"\n'
    apart = f'{ALONE}[contacts]\nlaw = "none"\n'
    motion = '[integration]\nintegrator = "overdamped"\ntime_step = 0.002\n[hydrodynamics]\nbrownian = true\n'
    scene = scene_of(WATER + "temperature = 300.0\n" + floats + dish + apart + motion, duration=80.0, frame_every=1.0)
    parameters = FLOATING.parameters(scene)
    from scipy.special import i1

    length = parameters.pair[1]
    spring = 0.5 * parameters.wall_strength[0, 0] / length**2 / i1(0.003 / length)
    friction = parameters.floats.mass[0] / parameters.floats.relaxation_time[0]
    assert 40.0 * spring / friction > 5.0
    frames = [frame for frame in simulate(scene) if frame.time > 40.0]
    found = np.mean([frame.arrays["position"] ** 2 for frame in frames])
    step = 1.0 - 0.5 * spring * parameters.time_step / friction
    assert found == pytest.approx(1.380649e-23 * 300.0 / spring / step, rel=0.12)


@pytest.mark.parametrize(
    ("motion", "flow", "path"),
    [
        ('[integration]\nintegrator = "overdamped"\n[hydrodynamics]\ndrag = "none"', "", "integration.integrator"),
        ("[hydrodynamics]\nbrownian = true", "", "hydrodynamics.brownian"),
        ("[hydrodynamics]\ndrag = 'none'", "[flow]\nshear_rate = 1.0\n", "flow"),
    ],
)
def test_what_moves_by_drag_needs_drag(motion, flow, path):
    with pytest.raises(SceneError) as caught:
        FLOATING.parameters(scene_of(f"{WATER}{flow}[[particles]]\n{SMALL}{motion}\n"))
    assert path in str(caught.value)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "semi-implicit-euler"])
def test_fast_floats_drag_as_schiller_and_naumann_found(integrator):
    """A bead at rest on a fast surface, and one with an initial velocity, compared with SciPy's integration."""
    from scipy.integrate import solve_ivp

    from ecume.laws import drag

    body = "[[particles]]\nradius = 1e-3\ndensity = 1300.0\ncontact_angle = 1.2\n"
    body += "positions = [[0.0, 0.0]]\nvelocity = [0.0, 0.1]\n"
    motion = f'[integration]\nintegrator = "{integrator}"\ntime_step = 5e-4\n'
    motion += '[hydrodynamics]\ndrag = "schiller-naumann"\nadded_mass = true\n'
    flow = "[flow]\nvelocity = [0.05, 0.0]\n"
    scene = scene_of(WATER + flow + body + motion, duration=0.1, frame_every=0.1)
    floats = FLOATING.parameters(scene).floats
    mass, friction = floats.mass[0], floats.mass[0] / floats.relaxation_time[0]
    assert mass > 1.1 * 1300.0 * 4 / 3 * math.pi * 1e-9

    def slowing(_, v):
        w = v - np.array([0.05, 0.0])
        reynolds = 2e-3 * math.hypot(*w) * 1000.0 / 1e-3
        return -drag.inertial_friction(friction, reynolds) / mass * w

    wanted = solve_ivp(slowing, (0.0, 0.1), [0.0, 0.1], rtol=1e-10, atol=1e-12).y[:, -1]
    found = list(simulate(scene))[-1].arrays["velocity"][0]
    assert found == pytest.approx(wanted, rel=5e-3)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "semi-implicit-euler", "explicit-euler"])
def test_fast_drag_acts_along_the_motion_through_the_liquid_in_every_direction(integrator):
    """Turned by any angle, a float that is thrown into a current moves along the same path, turned by that angle."""
    from scipy.integrate import solve_ivp

    from ecume.laws import drag

    ends = []
    for angle in np.random.default_rng(5).uniform(0.0, 2.0 * math.pi, 4).tolist():
        turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        (flow_x, flow_y), (x, y) = turned @ [0.05, 0.02], turned @ [-0.03, 0.08]
        body = "[[particles]]\nradius = 1e-3\ndensity = 1300.0\ncontact_angle = 1.2\n"
        body += f"positions = [[0.0, 0.0]]\nvelocity = [{x}, {y}]\n"
        motion = f'[integration]\nintegrator = "{integrator}"\ntime_step = 2e-4\n'
        motion += '[hydrodynamics]\ndrag = "schiller-naumann"\n'
        flow = f"[flow]\nvelocity = [{flow_x}, {flow_y}]\n"
        scene = scene_of(WATER + flow + body + motion, duration=0.02, frame_every=0.02)
        ends.append(list(simulate(scene))[-1].arrays["velocity"][0] @ turned)
    assert ends[1:] == [pytest.approx(ends[0], rel=1e-9)] * 3
    floats = FLOATING.parameters(scene).floats
    mass, friction = floats.mass[0], floats.mass[0] / floats.relaxation_time[0]

    def slowing(_, v):
        w = v - np.array([0.05, 0.02])
        return -drag.inertial_friction(friction, 2e-3 * math.hypot(*w) * 1000.0 / 1e-3) / mass * w

    wanted = solve_ivp(slowing, (0.0, 0.02), [-0.03, 0.08], rtol=1e-10, atol=1e-12).y[:, -1]
    assert ends[0] == pytest.approx(wanted, rel=5e-3)


def test_a_growing_drag_is_stokess_for_slow_floats_and_goes_with_some_integrators():
    slow = f"[[particles]]\n{SMALL}positions = [[0.0, 0.0], [1e-4, 0.0]]\n[hydrodynamics]\n"
    plain, fast = (
        list(simulate(scene_of(f"{WATER}{slow}{law}", duration=0.002, frame_every=0.002)))[-1].arrays["velocity"]
        for law in ("", 'drag = "schiller-naumann"\n')
    )
    assert fast == pytest.approx(plain, rel=0.02)
    with pytest.raises(SceneError, match="needs an integrator whose kicks solve drag exactly"):
        FLOATING.parameters(scene_of(f'{WATER}{slow}drag = "schiller-naumann"\n[integration]\nintegrator = "rk4"\n'))
    with pytest.raises(SceneError, match="no such law"):
        FLOATING.parameters(scene_of(f'{WATER}{slow}drag = "newton"\n'))


def test_a_warm_run_that_pauses_has_the_bits_of_one_that_does_not():
    floats = f"[[particles]]\n{SMALL}positions = [[0.0, 0.0], [2e-4, 0.0]]\n"
    scene = creeping(floats, 300.0, flow="[flow]\nshear_rate = 0.1\n", duration=0.1, frame_every=0.1)
    parameters = FLOATING.parameters(scene)
    states = []
    for pauses in ((6,), (2, 4)):
        state = FLOATING.start(scene, parameters)
        for steps in pauses:
            FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), steps)
        states.append(state)
    assert np.array_equal(states[0].position, states[1].position)
    assert np.array_equal(states[0].velocity, states[1].velocity)
    other = FLOATING.parameters(
        creeping(floats, 300.0, flow="[flow]\nshear_rate = 0.1\n", duration=0.1, frame_every=0.1, head="seed = 7")
    )
    state = FLOATING.start(scene, other)
    FLOATING.advance(other, state, FLOATING.workspace(other, state, 1.0), 6)
    assert not np.array_equal(states[0].position, state.position)
