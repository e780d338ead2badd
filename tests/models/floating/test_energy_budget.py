"""The work of currents, dishes and noise on floats, in known limits and against their energy."""

import math

import numpy as np
import pytest

from ecume.models import MODELS
from ecume.models.invariants import INJECTED, NumberHistory, with_own
from ecume.simulation import simulate
from tests.models.floating.bowls import HEAVY, WATER, scene_of
from tests.models.floating.test_dish_motion import APART, SWING, dish
from tests.models.floating.test_flow_and_noise import SMALL

FLOATING = MODELS["floating"]
SPEED = 0.02
CURRENT = f"[flow]\nvelocity = [{SPEED}, 0.0]\n"
PAIR = f"[[particles]]\n{HEAVY}positions = [[-1.5e-3, 0.0], [1.5e-3, 0.5e-3]]\n"


def in_a_current(motion, **times):
    """A single float at rest on a flowing surface."""
    floats = f"[[particles]]\n{HEAVY}positions = [[0.0, 0.0]]\n"
    return scene_of(f"{WATER}{CURRENT}{floats}{motion}\n{APART}", head='hydrodynamics.drag = "stokes"', **times)


def friction_of(parameters):
    return float(parameters.floats.mass[0] / parameters.floats.relaxation_time[0])


def rises(scene):
    """The largest violation of the energy invariant in a run, and the last numbers of the run."""
    (energy,) = (one for one in FLOATING.invariants(scene, FLOATING.parameters(scene)) if one.name == "energy")
    seen, worst = None, 0.0
    for frame in simulate(scene):
        now = with_own(dict(frame.numbers))
        extremes = (now, now) if seen is None else (seen.least, seen.largest)
        pairs = zip((min, max), extremes, strict=True)
        least, largest = ({key: pick(now[key], one[key]) for key in now} for pick, one in pairs)
        seen = NumberHistory(now if seen is None else seen.first, now, least, largest)
        worst = max(worst, energy.value(seen))
    return worst, seen


def test_a_float_that_a_current_takes_along_is_given_what_it_gains_and_what_drag_takes():
    """At rest at first, v = u (1 - e): the current's part of the drag does zeta u^2 (t - tau (1 - e)), e = exp(-t/tau);
    half a step in the square is what the scheme errs by.
    """
    errors = []
    for step in (4e-3, 2e-3):
        scene = in_a_current(f"[integration]\ntime_step = {step}", duration=0.2, frame_every=0.2)
        parameters = FLOATING.parameters(scene)
        *_, last = simulate(scene)
        tau = float(parameters.floats.relaxation_time[0])
        wanted = friction_of(parameters) * SPEED**2 * (0.2 + tau * math.expm1(-0.2 / tau))
        errors.append(last.numbers[INJECTED] / wanted - 1.0)
    assert abs(errors[0]) < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_what_drifts_steadily_is_given_as_much_as_drag_takes():
    """Without inertia, so immediately: the power is zeta u^2, and the energy is constant."""
    scene = in_a_current('[integration]\nintegrator = "overdamped"', duration=1.0, frame_every=0.5)
    _, half, whole = (frame.numbers for frame in simulate(scene))
    power = friction_of(FLOATING.parameters(scene)) * SPEED**2
    assert [half[INJECTED], whole[INJECTED]] == pytest.approx([0.5 * power, power], rel=1e-12, abs=0.0)
    assert whole["total_energy"] == 0.0


def test_the_work_of_a_growing_current_is_evaluated_in_the_middle_of_each_step():
    """Without inertia, at u = s x: zeta s dx^2/2, whatever the steps, as a pull that is straight in the place does."""
    flow, there = "[flow]\nextension_rate = 2.0\n", f"[[particles]]\n{HEAVY}positions = [[1e-3, 0.0]]\n"
    scene = scene_of(WATER + flow + there + '[integration]\nintegrator = "overdamped"\n' + APART, duration=0.5)
    *_, last = simulate(scene)
    gained = last.arrays["position"][0, 0] ** 2 - 1e-6
    assert gained > 4e-6
    wanted = 0.5 * friction_of(FLOATING.parameters(scene)) * 2.0 * gained
    assert last.numbers[INJECTED] == pytest.approx(wanted, rel=1e-9, abs=0.0)


def test_a_float_on_which_nothing_drags_has_back_after_a_swing_what_the_dish_has_put_in():
    frames = list(simulate(dish(SWING, integration="time_step = 5e-4", duration=0.25, frame_every=0.0125)))
    work, motion = (np.array([frame.numbers[key] for frame in frames]) for key in (INJECTED, "kinetic_energy"))
    assert work == pytest.approx(motion, abs=1e-3 * motion.max())
    assert abs(work[-1]) < 1e-4 * work.max()


def test_a_dish_that_is_drawn_through_a_liquid_pays_for_the_drag():
    """The float remains in the liquid, and moves backward in the frame of the dish at its speed: zeta V^2."""
    scene = dish(
        "velocity = [0.02, 0.0]\n",
        hydrodynamics="",
        integration='integrator = "overdamped"',
        duration=0.5,
        frame_every=0.5,
    )
    *_, last = simulate(scene)
    assert last.numbers[INJECTED] == pytest.approx(
        friction_of(FLOATING.parameters(scene)) * 4e-4 * 0.5, rel=1e-9, abs=0.0
    )


@pytest.mark.uncompiled
def test_the_energy_from_noise_is_heat():
    """In a well: the energy changes by the heat, but for the third power of a step."""
    floats = f'[[particles]]\ncount = 20\n{SMALL}placement = "lattice"\nspacing = 5e-5\n'
    well = '[dish]\nradius = 0.003\ncontact_angle = "10 deg"\n[interaction]\nlaw = "none"\n[contacts]\nlaw = "none"\n'
    motion = '[integration]\nintegrator = "overdamped"\ntime_step = 0.002\n[hydrodynamics]\nbrownian = true\n'
    first, *_, last = simulate(
        scene_of(WATER + "temperature = 300.0\n" + floats + well + motion, duration=0.5, frame_every=0.25)
    )
    change, thermal = last.numbers["total_energy"] - first.numbers["total_energy"], 1.380649e-23 * 300.0
    assert abs(change) > 0.1 * thermal
    assert last.numbers[INJECTED] == pytest.approx(change, abs=1e-3 * abs(change))


@pytest.mark.parametrize(
    "driven",
    [
        CURRENT + "shear_rate = 5.0\n" + PAIR + '[hydrodynamics]\ndrag = "schiller-naumann"\n',
        pytest.param(
            CURRENT + "rotation_rate = 5.0\n" + PAIR + '[integration]\nintegrator = "overdamped"\n',
            marks=pytest.mark.compiled,
        ),
        PAIR + '[dish]\nradius = 0.01\n[dish.motion]\namplitude = 2e-3\nfrequency = 3.0\n',
        pytest.param(PAIR + '[integration]\nintegrator = "overdamped"\n', marks=pytest.mark.compiled),
    ],
)  # fmt: skip
def test_energy_rises_only_by_the_injected_work(driven):
    """Floats that attract each other and collide, and a wall that attracts them, too."""
    worst, seen = rises(scene_of(WATER + driven, duration=0.3, frame_every=0.01))
    assert worst < 1e-5
    assert (INJECTED in seen.now) == ("flow" in driven or "motion]\namp" in driven)


def test_a_run_of_a_former_version_has_no_place_for_work_and_goes_on():
    scene = in_a_current("", duration=0.02, frame_every=0.01)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    state = state._replace(tally=state.tally[:4].copy())
    workspace = FLOATING.workspace(parameters, state, 1.0)
    FLOATING.advance(parameters, state, workspace, 1)
    numbers = FLOATING.observe(parameters, state, workspace).numbers
    assert INJECTED not in numbers
    (energy,) = (one for one in FLOATING.invariants(scene, parameters) if one.name == "energy")
    now = with_own({**numbers, "step": 1.0})
    assert energy.value(NumberHistory(now, {**now, "energy_less_work": 1.0}, now, now)) == 0.0
