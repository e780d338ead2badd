"""Floats with hydrodynamic interaction: rafts, pairs, currents, contacts and friction."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.drag import pair_factor
from ecume.laws.pair_mobility import compact_raft, raft_speed_factor, surface_mobility
from ecume.models import MODELS
from ecume.models.floating.coupled.mobility import CoupledKicks, MobilityMatrix, add_divergence, fill_mobility
from ecume.models.floating.forces.films import closing_of, find_films, solve_with_films, subtract_far_field
from ecume.models.floating.setup.hydrodynamic_interaction import GasWarning, ReynoldsWarning
from ecume.models.floating.setup.scene_parameters import memory_estimate
from ecume.models.floating.time_integration.integration import forces_at
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

# `ecume validate hydrodynamics` runs compiled code; each combination of parts is compiled by itself.
pytestmark = pytest.mark.uncompiled

FLOATING = MODELS["floating"]
RADIUS = 3e-4
SYRUP = WATER.replace('"1 mPa*s"', '"20 mPa*s"')
MOTION = '[integration]\nintegrator = "overdamped"\n[hydrodynamics]\ninteraction = "rotne-prager"\n'
ALONE = '[interaction]\nlaw = "none"\n'


def beads(places, *, angle=0.5 * math.pi, density=1050.0, more="", around="", **times):
    listed = np.asarray(places).tolist()
    floats = f"[[particles]]\nradius = {RADIUS}\ndensity = {density}\ncontact_angle = {angle}\npositions = {listed}\n"
    return scene_of(f"{SYRUP}{around}{floats}{MOTION}{more}", **times)


@pytest.mark.parametrize("count", [7, 19])
def test_a_raft_at_a_wall_moves_as_fast_as_rotne_and_prager_say(count):
    """The wall pulls each float of a rigid raft; a single float moves as fast as its own force and drag say."""
    raft = RADIUS * compact_raft(count) + [0.006, 0.0]
    wall = '[dish]\nsize = [0.02, 0.06]\ncontact_angle = "91 deg"\n'
    parameters, state, workspace = begun(beads(raft, around=wall, density=1300.0))
    force = forces_at(parameters, state.position, workspace).copy()
    assert FLOATING.advance(parameters, state, workspace, 2) == 0
    single = force.sum(axis=0) * parameters.kick.gain[0] / count
    assert abs(single[0]) > 10.0 * abs(single[1])
    speeds = state.velocity[:, 0] / single[0]
    assert np.ptp(speeds) < 0.02 * raft_speed_factor(count)
    assert speeds.mean() == pytest.approx(raft_speed_factor(count), rel=0.02)


def test_the_matrix_of_a_run_is_that_of_the_law():
    dice = np.random.default_rng(2)
    position, radius = dice.normal(0.0, 2.0, (9, 2)), dice.uniform(0.3, 1.5, 9)
    mobility = np.empty((18, 18))
    fill_mobility(MobilityMatrix(mobility), CoupledKicks(radius, np.zeros(0), 0.7, 0.0), position)
    assert mobility == pytest.approx(surface_mobility(position, radius, 0.7), rel=1e-12, abs=1e-16)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("part", range(10))
def test_the_matrix_with_spins_is_symmetric_and_positive_definite_in_a_thousand_packings(part):
    dice = np.random.default_rng(part)
    for _ in range(100):
        count = int(dice.integers(2, 9))
        radius = np.exp(dice.normal(0.0, 0.8, count))
        position = dice.normal(0.0, 10.0 ** dice.uniform(-1.5, 1.5), (count, 2))
        spin = np.zeros(count) if dice.random() < 0.7 else np.zeros(0)
        mobility = np.empty((2 * count + len(spin), 2 * count + len(spin)))
        fill_mobility(MobilityMatrix(mobility), CoupledKicks(radius, spin, 1.0, 0.0), position)
        assert mobility == pytest.approx(mobility.T, rel=1e-13)
        scale = np.sqrt(np.diag(mobility))
        assert np.linalg.eigvalsh(mobility / np.outer(scale, scale)).min() > 1e-4


@pytest.mark.parametrize("spins", [0, 5])
def test_the_drift_is_the_divergence_of_the_matrix(spins):
    """By differences: sum over j of dM_ij/dx_j, for separate, overlapping and enclosed spheres."""
    position = np.array([[0.0, 0.0], [2.1, 0.3], [1.0, 1.6], [-4.0, 2.0], [0.1, 0.2]])
    part = CoupledKicks(np.array([1.0, 0.7, 0.9, 1.3, 0.3]), np.zeros(spins), 0.7, 2.5)
    size, step = 10 + spins, 1e-6
    expected, sides = np.zeros(size), np.empty((2, size, size))
    for axis in range(10):
        for side, way in zip(sides, (step, -step), strict=True):
            moved = position.copy()
            moved.flat[axis] += way
            fill_mobility(MobilityMatrix(side), part, moved)
        expected += 2.5 * (sides[0] - sides[1])[:, axis] / (2.0 * step)
    found = np.zeros(size)
    add_divergence((), part, position, found)
    assert found == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())


def test_the_step_follows_the_speed_of_rafts_within_the_range_of_the_forces():
    """In a dish of many rafts the step is shorter than without the interaction, but not by all floats' number."""
    found = {}
    for count in (19, 91, 400):
        places = RADIUS * compact_raft(count)
        coupled = beads(places, around="[dish]\nradius = 0.02\n", duration=10.0, frame_every=10.0)
        alone = MOTION.replace("rotne-prager", "none")
        body = f"[[particles]]\nradius = {RADIUS}\ndensity = 1050.0\ncontact_angle = {0.5 * math.pi}\n"
        body += f"positions = {places.tolist()}\n[dish]\nradius = 0.02\n{alone}"
        single = scene_of(SYRUP + body, duration=10.0, frame_every=10.0)
        found[count] = FLOATING.parameters(single).time_step / FLOATING.parameters(coupled).time_step
    assert 0.9 * raft_speed_factor(19) < found[19] < 2.0 * raft_speed_factor(19)
    assert 1.1 * found[91] > found[400] > found[19]


def test_the_memory_of_the_matrix_is_counted():
    small, large = (beads(3.0 * RADIUS * compact_raft(count)) for count in (100, 400))
    one, other = (memory_estimate(FLOATING.parameters(scene)) for scene in (small, large))
    assert other - 4.0 * one > 8 * (800**2 - 4 * 200**2)


def test_the_spin_by_a_force_is_half_the_rotation_of_its_flow():
    """Rigid rotation: a far force turns a float as half the curl of a point force's flow says, and in its sense."""
    mobility = np.empty((6, 6))
    part = CoupledKicks(np.array([1.0, 0.5]), np.zeros(2), 1.0, 0.0)
    fill_mobility(MobilityMatrix(mobility), part, np.array([[0.0, 0.0], [3.0, 4.0]]))
    # A force along y on the first float; the second is to its right, where the flow turns clockwise.
    assert mobility[5, 1] == pytest.approx(-2.0 * 3.0 / (8.0 * math.pi * 125.0), rel=1e-12)
    assert mobility[5, 0] == pytest.approx(2.0 * 4.0 / (8.0 * math.pi * 125.0), rel=1e-12)


def test_two_distant_floats_approach_more_slowly_by_the_flow_of_each_other():
    distance = 6.0 * RADIUS
    parameters, state, workspace = begun(beads([(0.0, 0.0), (distance, 0.0)]))
    force = forces_at(parameters, state.position, workspace).copy()
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    slowness = force[0, 0] * parameters.kick.gain[0] / state.velocity[0, 0]
    assert slowness == pytest.approx(pair_factor(6.0), rel=0.01)
    assert state.velocity[1] == pytest.approx(-state.velocity[0], rel=1e-9)


@pytest.mark.parametrize(
    ("angle", "gap"),
    [(math.pi / 2, gap) for gap in (1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 3.0, 4.5, 10.0)]
    + [(angle, gap) for angle in (math.pi / 3, 2.0 * math.pi / 3) for gap in (1e-3, 0.1, 0.5)],
)
def test_films_complete_the_resistance_of_approaching_floats(angle, gap):
    """Against the exact series for half-immersed spheres, at any gap; for other depths near contact, by a product that
    was measured.
    """
    places = [(0.0, 0.0), ((2.0 + gap) * RADIUS, 0.0)]
    films = "lubrication = { roughness = 1e-8 }\n"
    parameters, state, workspace = begun(beads(places, angle=angle, more=films))
    force = forces_at(parameters, state.position, workspace).copy()
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    slowness = force[0, 0] * parameters.kick.gain[0] / state.velocity[0, 0]
    assert slowness == pytest.approx(pair_factor(2.0 + gap), rel=0.01 if angle == math.pi / 2 else 0.06)


def test_films_leave_the_speed_of_rigid_rafts_and_add_no_force():
    parameters, state, workspace = begun(
        beads(2.002 / 2.0 * RADIUS * compact_raft(7), more="lubrication = { roughness = 1e-8 }\n")
    )
    own, films = workspace.scratch.integrator, parameters.parts.resistances[0]
    fill_mobility(own.mobility, parameters.parts.integrator, state.position)
    pairs = find_films(films.films, parameters, state.position, workspace.lists)
    subtract_far_field(films, parameters, state.position, pairs)
    assert pairs.friction.min() >= 0.0 < pairs.friction.max()
    together, own.load[:] = np.tile([3e-3, -1e-3], 7), 0.0
    own.motion[:] = together
    solve_with_films(own.mobility, pairs, own.motion, own.load)
    assert own.motion == pytest.approx(together, rel=1e-9)
    own.motion[:] = given = 1e-3 * np.random.default_rng(1).normal(size=14)
    solve_with_films(own.mobility, pairs, own.motion, own.load)
    assert np.abs(own.load.reshape(7, 2).sum(axis=0)).max() < 1e-12 * np.abs(own.load).max()
    assert own.motion == pytest.approx(given + own.mobility.matrix @ own.load, rel=1e-9)
    assert own.load @ own.motion < 0.0
    closing = [closing_of(own.mobility, pairs, row) for row in range(len(pairs.friction))]
    assert min(closing) > 0.0


@pytest.mark.parametrize("flow", ["velocity = [2e-3, -1e-3]", "rotation_rate = 0.4"])
def test_the_current_at_the_middle_of_a_step_adds_to_the_velocities(flow):
    places = [(0.0, 0.0), (2.2 * RADIUS, 0.0), (0.0, 2.5 * RADIUS)]
    found = []
    for around in ("", f"[flow]\n{flow}\n"):
        parameters, state, workspace = begun(beads(places, around=around))
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        found.append(state.velocity.copy())
    current = np.tile([2e-3, -1e-3], (3, 1))
    if "rotation" in flow:
        turn = np.array([[0.0, 0.4], [-0.4, 0.0]])
        ahead = 0.5 * parameters.time_step * (found[0] + np.array(places) @ turn)
        current = (np.array(places) + ahead) @ turn
    assert found[1] - found[0] == pytest.approx(current, rel=1e-9, abs=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("contacts", ["", "[contacts]\nfriction = 0.4\n"])
def test_touching_floats_do_not_overlap_and_the_energy_budget_of_a_current_closes(contacts):
    """A converging flow presses a raft together; the contacts conserve its momentum, and friction turns the floats."""
    dice = np.random.default_rng(4)
    places = 1.04 * RADIUS * compact_raft(7) + 0.015 * RADIUS * dice.normal(size=(7, 2))
    flow = "[flow]\nextension_rate = 0.025\n"
    scene = beads(places, around=flow, more=contacts, density=1300.0, duration=4.0, frame_every=4.0)
    parameters, state, workspace = begun(scene)
    before = FLOATING.observe(parameters, state, workspace).numbers
    assert FLOATING.advance(parameters, state, workspace, 60) == 0
    after = FLOATING.observe(parameters, state, workspace).numbers
    assert after["deepest_overlap"] < parameters.slop
    assert after["contacts"] >= 9
    assert after["unconverged_steps"] == 0
    # The work of the current is lost in part: never more energy than before and what was injected.
    gained = after["total_energy"] - before["total_energy"]
    assert gained < after["injected_work"] + 1e-6 * abs(gained)
    load = workspace.scratch.integrator.load[:14].reshape(7, 2)
    assert np.abs(load.sum(axis=0)).max() < 1e-9 * np.abs(workspace.force).max()
    if contacts:
        assert np.abs(state.turning[:, 1]).max() > 0.0


def test_a_current_along_a_force_takes_its_work():
    """A float that a wall pulls drifts faster with the current: the energy falls by more than drag dissipates."""
    around = '[dish]\nsize = [0.02, 0.06]\ncontact_angle = "100 deg"\n[flow]\nvelocity = [1e-3, 0.0]\n'
    parameters, state, workspace = begun(beads([(0.006, 0.0)], around=around, density=1300.0))
    pull = forces_at(parameters, state.position, workspace)[0, 0]
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    injected = FLOATING.observe(parameters, state, workspace).numbers["injected_work"]
    mean = 0.5 * (pull + forces_at(parameters, state.position, workspace)[0, 0])
    assert injected == pytest.approx(-mean * 1e-3 * parameters.time_step, rel=1e-9, abs=0.0)
    assert pull > 0.0


def test_a_sticking_pair_turns_as_one_body():
    """With strong friction two floats that are sheared against each other roll together: no sliding at the contact."""
    places = [(0.0, 0.0), (2.0 * RADIUS, 0.0)]
    scene = beads(
        places,
        around="[flow]\nshear_rate = 0.2\nrotation_rate = 0.1\n",
        more="[contacts]\nfriction = 5.0\n",
        density=1300.0,
    )
    parameters, state, workspace = begun(scene)
    assert FLOATING.advance(parameters, state, workspace, 3) == 0
    apart = state.position[1] - state.position[0]
    normal = apart / np.hypot(*apart)
    tangent, spin = np.array([-normal[1], normal[0]]), state.turning[:, 1]
    sliding = tangent @ (state.velocity[1] - state.velocity[0]) - RADIUS * spin.sum()
    assert abs(sliding) < 1e-4 * np.abs(RADIUS * spin).max()
    assert np.abs(spin).min() > 0.0


def test_a_warning_has_the_reynolds_number_of_fast_floats():
    body = f"[[particles]]\nradius = 1e-3\ndensity = 1300.0\ncontact_angle = 1.5\n{MOTION}"
    with pytest.warns(ReynoldsWarning, match="Reynolds number of [0-9]+"):
        FLOATING.parameters(scene_of(WATER + body))


def test_a_liquid_above_the_liquid_is_a_warning_with_the_factor_of_the_drag():
    text = WATER.replace("[liquid]\n", "[liquid]\ngas_density = 770.0\n", 1)
    body = "[[particles]]\nradius = 1e-4\ndensity = 1050.0\ncontact_angle = 1.5\n"
    with pytest.warns(GasWarning, match=r"gas_density: got 770 .* in liquid\.gas_viscosity"):
        FLOATING.parameters(scene_of(text + body))


@pytest.mark.parametrize(
    ("more", "around", "reason"),
    [
        ("", "[cell]\nsize = [0.05, 0.05]\n", "decays as 1/r only"),
        ('[contacts]\nlaw = "spring-dashpot"\nstiffness = 1.0\n', "", "the force of a contact moves all floats"),
    ],
)
def test_what_cannot_be_combined_is_refused_with_the_physical_reason(more, around, reason):
    with pytest.raises(SceneError, match=reason):
        FLOATING.parameters(beads([(0.01, 0.0), (0.02, 0.0)], more=more, around=around))


def test_inertia_is_refused():
    fast = MOTION.replace("overdamped", "velocity-verlet")
    body = f"[[particles]]\nradius = {RADIUS}\ndensity = 1050.0\ncontact_angle = 1.5\n{fast}"
    with pytest.raises(SceneError, match="creeping flow, which follows the forces at once"):
        FLOATING.parameters(scene_of(WATER + body))


def test_floats_that_cannot_meet_in_a_step_are_no_contacts():
    parameters, state, workspace = begun(beads([[0.0, 0.0], [2.1 * RADIUS, 0.0]]))
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    assert workspace.contacts.total[0] == 0
