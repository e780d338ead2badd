import math
import re
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import k1

from ecume.errors import Diverged, SceneError
from ecume.laws import drag, flotation
from ecume.models import MODELS
from ecume.models.floating.setup.kinds import float_kind
from ecume.models.floating.time_integration.integrators import SCHEMES
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.simulation import simulate
from tests.models import begun
from tests.models.floating.bowls import HEAVY, LIGHT, WATER, lone_float_in_a_dish, scene_of, two_floats

FLOATING = MODELS["floating"]
DRAG = {True: 'drag = "stokes"', False: 'drag = "none"'}
ELSEWHERE = ("rk4", "stormer-verlet")
"""Compiled for varying flows; each of these would be compiled for ten seconds once more, with a dish."""
ORDERS = {"velocity-verlet": 2, "explicit-euler": 1, "stormer-verlet": 2, "semi-implicit-euler": 1, "rk4": 4}


def test_the_order_of_every_integrator_with_inertia_is_tested():
    assert set(ORDERS) == set(SCHEMES) - {"overdamped"}


def meeting_time(apart, drag_on):
    """When two floats released at rest touch: the equation of motion, by an integrator of order 8."""
    scene = two_floats(apart, hydrodynamics=DRAG[drag_on])
    kind = float_kind(scene.particles[0], scene)
    length = flotation.Liquid(1000.0, 0.0728, 1e-3).capillary_length
    strength = 2.0 * math.pi * 0.0728 * kind.charge**2 / length
    friction = kind.friction if drag_on else 0.0

    def rate(_, y):
        return [y[1], 2.0 * (-strength * k1(y[0] / length) - friction * 0.5 * y[1]) / kind.mass]

    def touching(_, y):
        return y[0] - 2.0 * kind.body.radius

    touching.terminal = True
    found = solve_ivp(rate, (0, 60), [apart, 0.0], "DOP853", events=touching, rtol=1e-10, atol=1e-14)
    return found.t_events[0][0]


@pytest.mark.compiled
@pytest.mark.parametrize("drag_on", [False, True])
def test_two_floats_meet_when_the_equation_of_motion_says_so(drag_on):
    apart, expected = 6e-3, meeting_time(6e-3, drag_on)
    every = expected / 2000
    drag = DRAG[drag_on]
    scene = two_floats(apart, hydrodynamics=drag, duration=2100 * every, frame_every=every)
    for frame in simulate(scene):
        gap = np.diff(frame.arrays["position"][:, 0])[0] - 2e-3
        if gap < 1e-9:
            break
    # The gap closes between two frames, which lie a twentieth of a per cent apart.
    assert frame.time == pytest.approx(expected, rel=1e-3)


@pytest.fixture
def coarse_steps_allowed():
    """Permit long steps, which these tests use on purpose."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StepWarning)
        yield


def final_position(integrator, step):
    integration = f'integrator = "{integrator}"\ntime_step = {step!r}'
    scene = lone_float_in_a_dish(HEAVY, integration=integration, duration=0.32, frame_every=0.32)
    return list(simulate(scene))[-1].arrays["position"][0, 0]


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.usefixtures("coarse_steps_allowed")
@pytest.mark.parametrize("integrator", ORDERS)
def test_each_scheme_has_its_order(integrator):
    exact = final_position("rk4", 0.32 / 1024)
    errors = [abs(final_position(integrator, 0.32 / steps) - exact) for steps in (64, 128)]
    order = math.log2(errors[0] / errors[1])
    assert order == pytest.approx(ORDERS[integrator], abs=0.25)


@pytest.mark.compiled
@pytest.mark.parametrize("integrator", ["velocity-verlet", pytest.param("stormer-verlet", marks=pytest.mark.long)])
def test_symmetric_schemes_go_back_to_the_start_in_reversed_time(integrator):
    scene = lone_float_in_a_dish(HEAVY, integration=f'integrator = "{integrator}"', duration=2.0, frame_every=0.1)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    began = state.position.copy()
    for _ in range(2):
        FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 500)
        state.velocity[:] *= -1.0
    assert state.position == pytest.approx(began, abs=1e-12 * 4e-3 * 1000)


def energy_drift(integrator, steps):
    """The largest change of the energy of one float that swings in a dish, over the energy of the swing."""
    every = 20_000
    integration = f'integrator = "{integrator}"\ntime_step = 4e-3'
    scene = lone_float_in_a_dish(HEAVY, integration=integration, duration=steps * 4e-3, frame_every=every * 4e-3)
    energies = np.array([frame.numbers["total_energy"] for frame in simulate(scene)])
    swing = abs(energies[0] - lowest_energy())
    return np.max(np.abs(energies - energies[0])) / swing


def lowest_energy():
    scene = lone_float_in_a_dish(HEAVY, place=(0.0, 0.0))
    return next(iter(simulate(scene))).numbers["total_energy"]


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.usefixtures("coarse_steps_allowed")
def test_verlet_keeps_the_energy_for_a_hundred_thousand_steps():
    # A million are among the validations.
    assert energy_drift("velocity-verlet", steps=100_000) < 1e-3


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.usefixtures("coarse_steps_allowed")
def test_explicit_euler_does_not_keep_the_energy():
    try:
        drift = energy_drift("explicit-euler", steps=100_000)
    except Diverged:
        drift = math.inf
    assert drift > 0.1


@pytest.mark.parametrize("per_relaxation", [0.01, 1.0, 100.0])
def test_a_steady_force_gives_the_exact_terminal_speed_however_long_the_step(per_relaxation):
    scene = two_floats(8e-3, hydrodynamics="", contacts='law = "none"')
    parameters = FLOATING.parameters(scene)
    relaxation, mass = parameters.floats.relaxation_time[0], parameters.floats.mass[0]
    from ecume.models.floating.time_integration.integrators import apply_kick
    from ecume.models.floating.time_integration.step_size import kick_of

    kick = kick_of(parameters.scheme, 2.0 * per_relaxation * relaxation, parameters.floats, 0)
    force = np.array([[3e-7, 0.0], [0.0, -2e-7]])
    velocity = force * relaxation / mass
    apply_kick(kick, velocity, force)
    assert velocity == pytest.approx(force * relaxation / mass, rel=1e-13)


@pytest.mark.compiled
def test_drag_takes_away_a_velocity_exponentially():
    scene = scene_of(
        f"{WATER}[[particles]]\n{HEAVY}positions = [[0.0, 0.0]]\nvelocity = [0.01, 0.0]\n"
        '[hydrodynamics]\ndrag = "stokes"\n',
        duration=0.2,
        frame_every=0.1,
    )
    kind = float_kind(scene.particles[0], scene)
    frames = list(simulate(scene))
    relaxation = drag.relaxation_time(kind.mass, kind.friction)
    # Kicks take drag exactly; the drift in between adds an error of second order in the step.
    assert frames[-1].arrays["velocity"][0, 0] == pytest.approx(0.01 * math.exp(-0.2 / relaxation), rel=1e-12)
    assert frames[-1].arrays["position"][0, 0] == pytest.approx(
        0.01 * relaxation * -math.expm1(-0.2 / relaxation), rel=1e-3
    )


def test_syrup_needs_no_tinier_step_than_water():
    steps = []
    for viscosity in (1e-3, 0.1, 10.0):
        text = WATER.replace('"1 mPa*s"', str(viscosity))
        scene = scene_of(f"{text}[[particles]]\n{HEAVY}count = 5\n", duration=100.0, frame_every=100.0)
        steps.append(FLOATING.parameters(scene).time_step)
    assert steps[0] <= steps[1] <= steps[2]


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("kind", "wall_angle", "leaves"),
    [(HEAVY, "45 deg", True), (LIGHT, "45 deg", False), (HEAVY, "135 deg", False), (LIGHT, "135 deg", True)],
)
def test_heavy_floats_leave_a_wetting_wall_and_light_ones_climb_it(kind, wall_angle, leaves):
    scene = lone_float_in_a_dish(kind, wall_angle=wall_angle, place=(6e-3, 0.0), hydrodynamics="", duration=0.2)
    frames = list(simulate(scene))
    moved = frames[-1].arrays["position"][0, 0] - 6e-3
    assert bool(moved < 0) == leaves
    assert abs(moved) > 1e-5


def test_a_step_that_is_unstable_is_refused_with_the_number_that_would_do():
    with pytest.raises(SceneError, match=r"integration.time_step: .* is unstable here; expected at most .* s is good"):
        FLOATING.parameters(
            two_floats(6e-3, hydrodynamics="", integration="time_step = 1.0", duration=10.0, frame_every=1.0)
        )


def test_a_coarse_step_is_warned_of():
    good = FLOATING.parameters(two_floats(6e-3, duration=100.0, frame_every=100.0)).time_step
    step = 8.0 * good
    times = {"duration": 10 * step, "frame_every": step}
    scene = two_floats(6e-3, hydrodynamics="", integration=f"time_step = {step!r}", **times)
    with pytest.warns(StepWarning, match="coarse"):
        FLOATING.parameters(scene)


def test_the_summary_says_what_a_longer_step_would_be():
    def report(**changes):
        rows = {name: (value, remark) for name, value, remark in FLOATING.summary(two_floats(6e-3, **changes))}
        return rows["time step"]

    value, remark = report(duration=100.0, frame_every=100.0)
    good = float(value.split()[0])
    coarse, refused = (float(word) for word in re.findall(r"above ([0-9.]+) ms", remark))
    assert remark.startswith("good; coarse above ")
    assert (coarse / good, refused / good) == (pytest.approx(4.0, rel=0.01), pytest.approx(20.0, rel=0.01))
    step = 8e-3 * good
    times = {"duration": 10 * step, "frame_every": step}
    with pytest.warns(StepWarning):
        value, remark = report(hydrodynamics="", integration=f"time_step = {step!r}", **times)
    assert re.fullmatch(r"coarse; [0-9.]+ ms is good, refused above [0-9.]+ ms", remark)


def test_a_step_that_does_not_divide_the_frames_is_refused():
    with pytest.raises(SceneError, match="does not divide frame_every"):
        FLOATING.parameters(two_floats(6e-3, hydrodynamics="", integration="time_step = 0.0037"))


def test_runge_kutta_refuses_a_liquid_too_viscous_for_it():
    text = WATER.replace('"1 mPa*s"', "10.0")
    scene = scene_of(f'{text}[[particles]]\n{HEAVY}count = 2\n[integration]\nintegrator = "rk4"\n')
    with pytest.raises(SceneError, match="rk4"):
        FLOATING.parameters(scene)


@pytest.mark.parametrize(
    "scheme", [pytest.param(name, marks=[pytest.mark.uncompiled] * (name in ELSEWHERE)) for name in SCHEMES]
)
def test_whatever_the_scheme_a_dish_does_not_move_by_itself(scheme):
    scene = lone_float_in_a_dish(HEAVY, hydrodynamics="", integration=f'integrator = "{scheme}"')
    parameters, state, workspace = begun(scene)
    for _ in range(4):
        FLOATING.advance(parameters, state, workspace, 1)
        assert workspace.midstep_velocity[1:].tolist() == [[0.0, 0.0]]


def test_a_run_that_leaves_its_range_says_when_who_and_what_to_do():
    scene = two_floats(6e-3, duration=1.0)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    state.velocity[1, 0] = 50.0
    workspace = FLOATING.workspace(parameters, state, 1.0)
    assert FLOATING.advance(parameters, state, workspace, 10) == 2
    assert "float 1 moves at 50 m/s" in FLOATING.diagnosis(parameters, state)
    state.position[0, 1] = np.nan
    assert FLOATING.advance(parameters, state, workspace, 10) == 2
    assert "float 0 has a position that is not finite" in FLOATING.diagnosis(parameters, state)
