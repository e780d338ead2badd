"""Active floats: displacements, rotation and work."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.drag import schiller_naumann_factor
from ecume.models import MODELS
from ecume.models.floating.forces.activity import Activity, ActivityScratch, renew_activity
from ecume.models.floating.parameters import WORK
from ecume.units import parse, with_prefix
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

# `ecume validate activity` runs compiled code; each combination of parts is compiled by itself.
pytestmark = pytest.mark.uncompiled

FLOATING = MODELS["floating"]
RADIUS = 1e-5
ALONE = '[interaction]\nlaw = "none"\n[contacts]\nlaw = "none"\n'
SLOW = '[integration]\nintegrator = "overdamped"\n'


def swimmers(activity, *, count=1, more=SLOW + ALONE, **times):
    floats = f"[[particles]]\ncount = {count}\nradius = {RADIUS}\ndensity = 1500.0\ncontact_angle = 1.2\n"
    floats += 'placement = "lattice"\nspacing = 1e-3\n'
    return scene_of(f"{WATER}{floats}[activity]\n{activity}{more}", **times)


@pytest.mark.long
def test_a_random_force_is_stationary_and_forgets_at_its_rate():
    dice, count = np.random.default_rng(1), 20_000
    part = Activity(np.full(count, 3.0), 0.7, np.zeros(count), np.full(count, 0.4), np.full(count, 1.5), 5, False)
    own = ActivityScratch(dice.normal(size=(count, 3)), np.zeros((count, 0)), np.zeros((count, 2)))
    parameters, state, _ = begun(swimmers("propulsion = 1e-12\n"))
    parameters = parameters._replace(time_step=0.3)
    first = own.active.copy()
    for step in range(3):
        state.step[0] = step
        renew_activity(part, own, parameters, state, True)
        renew_activity(part, own, parameters, state, False)
    kept = math.exp(-3 * 0.3 / 0.7)
    assert np.mean(first[:, :2] * own.active[:, :2]) == pytest.approx(kept, abs=0.03)
    assert np.var(own.active[:, :2]) == pytest.approx(1.0, abs=0.03)
    turned = own.active[:, 2] - first[:, 2]
    assert turned.mean() == pytest.approx(1.5 * 0.9, abs=0.03)
    assert turned.var() == pytest.approx(2.0 * 0.4 * 0.9, rel=0.04)


def test_a_torque_makes_a_float_swim_in_a_circle():
    """Its radius is that of the speed p/zeta over the rate T/zeta_r."""
    from ecume.models.floating.setup.kinds import turning_frictions

    scene = swimmers("propulsion = 1e-12\ntorque = 1e-17\n", duration=1.0, frame_every=0.01)
    parameters, state, workspace = begun(scene)
    rate = 1e-17 / turning_frictions(scene)[0]
    turn = 2.0 * math.pi / rate
    parameters = parameters._replace(time_step=turn / 400)
    places = []
    for _ in range(400):
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        places.append(state.position[0].copy())
    speed = 1e-12 * float(parameters.kick.gain[0])
    assert np.ptp(places, axis=0) == pytest.approx(np.full(2, 2.0 * speed / rate), rel=1e-3)
    assert places[-1] == pytest.approx(places[0], abs=0.03 * speed / rate)


@pytest.mark.parametrize("integrator", ["overdamped", "velocity-verlet", "semi-implicit-euler", "stormer-verlet"])
def test_all_work_of_active_forces_is_injected(integrator):
    """Without other forces the energy never exceeds it; in steady motion drag takes it."""
    more = f'[integration]\nintegrator = "{integrator}"\n{ALONE}'
    activity = "force = 1e-12\npersistence = 0.05\npropulsion = 1e-12\n"
    scene = swimmers(activity, count=3, more=more, duration=0.2, frame_every=0.2)
    parameters, state, workspace = begun(scene)
    dissipated = 0.0
    for _ in range(60):
        before = state.position.copy()
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        speed = (state.position - before) / parameters.time_step
        dissipated += parameters.time_step * float(np.sum(speed**2)) / parameters.kick.gain[0]
    numbers = FLOATING.observe(parameters, state, workspace).numbers
    if integrator == "overdamped":
        assert numbers["injected_work"] == pytest.approx(dissipated, rel=0.1, abs=0.0)
    assert numbers["injected_work"] > 0.0


def test_stoermers_scheme_does_the_work_of_the_force_that_it_applies():
    more = f'[integration]\nintegrator = "stormer-verlet"\ntime_step = 1e-3\n{ALONE}'
    scene = swimmers("force = 1e-12\npersistence = 0.005\n", count=2, more=more, duration=0.1, frame_every=0.1)
    parameters, state, workspace = begun(scene)
    work = 0.0
    for _ in range(20):
        before = state.position.copy()
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        force = 1e-12 / math.sqrt(2.0) * state.active[:, :2]
        work += float(np.sum(force * (state.position - before)))
    assert state.tally[WORK] == pytest.approx(work, rel=1e-9, abs=0.0)


def test_only_the_active_species_moves():
    floats = "".join(
        f'[[particles]]\nname = "{name}"\nradius = {RADIUS}\ndensity = 1500.0\ncontact_angle = 1.2\n'
        f"positions = [[{place}, 0.0]]\n"
        for name, place in (("swimmer", 0.0), ("passive", 1e-3))
    )
    activity = '[activity]\nforce = 1e-12\npersistence = 0.5\nrotational_diffusion = 1.0\nspecies = ["swimmer"]\n'
    scene = scene_of(WATER + floats + activity + SLOW + ALONE, duration=1.0, frame_every=0.1)
    parameters, whole, workspace = begun(scene)
    assert FLOATING.advance(parameters, whole, workspace, 10) == 0
    assert np.hypot(*whole.position[0]) > 0.0
    assert whole.position[1].tolist() == [1e-3, 0.0]


@pytest.mark.parametrize(
    ("activity", "more", "reason"),
    [
        ("torque = 1e-17\n", SLOW + "[contacts]\nfriction = 0.3\n", "transmitted by their contacts"),
        ("torque = 1e-17\n", SLOW + '[hydrodynamics]\ninteraction = "rotne-prager"\n', "moves its neighbors"),
        ("propulsion = 1e-12\n", '[hydrodynamics]\ndrag = "none"\n', "drag limits the speed"),
        ("force = 1e-12\n", SLOW, "force and persistence together"),
        ('propulsion = 1e-12\nspecies = ["fish"]\n', SLOW, "fish"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(activity, more, reason):
    with pytest.raises(SceneError, match=reason):
        FLOATING.parameters(swimmers(activity, more=more))


def test_noise_turns_the_headings_of_small_swimmers():
    """A half-immersed bead of 2 um on water forgets its heading after 25 s: 1/D with D = kT/(4 pi eta R^3)."""
    floats = '[[particles]]\nradius = "2 um"\ndensity = 1000.0\ncontact_angle = "90 deg"\n'
    noise = f"{SLOW}[hydrodynamics]\nbrownian = true\n"
    for brownian, given, wanted in ((noise, 0.0, 1.0 / 24.8), (noise, 0.5, 0.5 + 1.0 / 24.8), (SLOW, 0.0, 0.0)):
        driven = f"[activity]\npropulsion = 1e-15\nrotational_diffusion = {given}\n"
        parameters = FLOATING.parameters(scene_of(WATER + floats + driven + brownian))
        part = next(part for part in parameters.parts.interactions if isinstance(part, Activity))
        assert part.diffusion.tolist() == pytest.approx([wanted], rel=1e-2)


def test_check_states_the_speed_of_swimmers_and_the_length_of_their_paths():
    scene = scene_of(
        '[integration]\nintegrator = "overdamped"\n[activity]\npropulsion = 1e-9\nrotational_diffusion = 0.5\n'
        "[[particles]]\nradius = 1e-4\ndensity = 1000.0\ncontact_angle = 1.57\npositions = [[0.0, 0.0]]\n"
    )
    floats = FLOATING.parameters(scene).floats
    speed = 1e-9 * floats.relaxation_time[0] / floats.mass[0]
    (row,) = (row for row in FLOATING.summary(scene) if row[0] == "speed of free swimmers")
    assert row[1] == with_prefix(speed, "m/s", 3)
    assert row[2].startswith(f"persistence length {with_prefix(2.0 * speed, 'm', 3)}, {2.0 * speed / 1e-4:.3g} radii")


def test_check_states_the_speed_of_fast_swimmers_with_the_drag_of_the_scene():
    """Re f(Re) = 125 with Re = 37: the drag is 3.4 times as large as by Stokes's law."""
    scene = scene_of(
        f"{WATER}[activity]\npropulsion = 5e-7\nrotational_diffusion = 0.5\n"
        "[[particles]]\nradius = 5e-4\ndensity = 1000.0\ncontact_angle = 1.57\npositions = [[0.0, 0.0]]\n"
    )
    parameters = FLOATING.parameters(scene)
    slow = 5e-7 * float(parameters.floats.relaxation_time[0] / parameters.floats.mass[0])
    (row,) = (row for row in FLOATING.summary(scene) if row[0] == "speed of free swimmers")
    speed, thickness = parse(row[1], "m/s"), parameters.drift.thickness
    assert thickness > 0.0
    assert speed < 0.5 * slow
    assert speed * schiller_naumann_factor(2.0 * 5e-4 * speed * thickness) == pytest.approx(slow, rel=0.01)
