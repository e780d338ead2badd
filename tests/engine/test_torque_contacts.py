"""Impulses with lever arms: momentum, angular momentum, energy, and bodies in extended contact."""

import math

import numpy as np
import pytest
from tests.engine.test_outlines import needle, outlines, square

from ecume.engine.contact import contacts, impulse_solvers
from ecume.engine.contact import torque_contacts as touching
from ecume.engine.contact.contacts import Memory, deepest_overlap, make_candidates
from ecume.engine.contact.impulse_solvers import LEAST_FOR_ISLANDS, MOST_SWEEPS, PATIENCE, Tolerance
from ecume.engine.contact.separation import separate
from ecume.engine.outlines import Stance
from ecume.engine.walls import box, enclosed_by, no_walls

pytestmark = pytest.mark.uncompiled
"""Compiled, these solvers are those of floats that have outlines: `tests.models.floating.test_shapes`."""
GOAL = Tolerance(1e-12, 1e-9)


def party(bodies, mass=1.0, inertia=0.8, walls=None):
    shapes = outlines(*bodies)
    mobility = np.tile([1.0 / mass, 1.0 / mass, 1.0 / inertia], (len(bodies), 1))
    return touching.OutlinedBodies(shapes, np.full(len(bodies), 3.0), no_walls() if walls is None else walls, mobility)


def crowd(count, chance):
    """Shapes of all kinds in a loose packing."""
    kinds = [(1.2, 0.5), square(0.2), needle(0.2), (0.9, 0.9)]
    side = math.ceil(math.sqrt(count))
    places = np.array([(3.1 * (k % side), 3.1 * (k // side)) for k in range(count)])
    bodies = [kinds[k % 4] for k in range(count)]
    stance = Stance(places, chance.uniform(0.0, 7.0, count), np.zeros_like(outlines(*bodies).corner))
    return bodies, stance


def all_pairs(count):
    candidates = make_candidates(count, count * count)
    pairs = [list(range(i + 1, count)) for i in range(count)]
    candidates.first[:] = np.cumsum([0, *map(len, pairs)])
    candidates.partner[: count * (count - 1) // 2] = [j for row in pairs for j in row]
    return candidates


def gathered(who, stance, reach=1.0):
    levers = touching.make_torque_contacts(400, 100)
    assert touching.gather(levers, all_pairs(len(stance.angle)), stance, who, reach)
    return levers


def totals(stance, velocity, mass=1.0, inertia=0.8):
    """Momentum, angular momentum about the origin, kinetic energy."""
    momentum = mass * velocity[:, :2].sum(axis=0)
    about = mass * (stance.position[:, 0] @ velocity[:, 1] - stance.position[:, 1] @ velocity[:, 0])
    energy = 0.5 * mass * np.sum(velocity[:, :2] ** 2) + 0.5 * inertia * np.sum(velocity[:, 2] ** 2)
    return *momentum, about + inertia * velocity[:, 2].sum(), energy


@pytest.mark.parametrize("seed", range(3))
def test_a_solve_keeps_both_momenta_and_takes_energy(seed):
    chance = np.random.default_rng(seed)
    bodies, stance = crowd(9, chance)
    levers, velocity = gathered(party(bodies), stance), chance.normal(size=(9, 3))
    before = totals(stance, velocity)
    levers.bound[:] = 0.0
    impulse_solvers.solve(levers, velocity, GOAL)
    after = totals(stance, velocity)
    assert levers.total[0] > 4
    assert after[:3] == pytest.approx(before[:3], abs=1e-12)
    assert after[3] < before[3]
    assert impulse_solvers.residual(levers, velocity, np.arange(levers.total[0])) < 1e-9


def test_a_solve_that_no_longer_improves_ends_where_it_is_acceptable():
    """All bodies fly fast in one direction, so that rounding keeps the residual above the goal."""
    chance = np.random.default_rng(0)
    bodies, stance = crowd(9, chance)
    levers, velocity = gathered(party(bodies), stance), chance.normal(size=(9, 3))
    velocity[:, :2] += 1e6
    levers.bound[:] = 0.0
    most = impulse_solvers.solve(levers, velocity, Tolerance(1e-14, 1e-6))
    assert PATIENCE < most < MOST_SWEEPS
    assert most % PATIENCE == 0
    assert impulse_solvers.residual(levers, velocity, np.arange(levers.total[0])) < 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_the_exact_solution_is_that_of_the_sweeps(seed):
    chance = np.random.default_rng(seed)
    bodies, stance = crowd(9, chance)
    inside = party(bodies, walls=enclosed_by(box((-1.0, -1.0), (7.0, 7.0))))
    inside.mobility[:] *= chance.uniform(0.5, 2.0, (9, 3))
    levers, given = gathered(inside, stance), chance.normal(size=(13, 3))
    given[9:] = 0.0
    levers.bound[:] = -np.maximum(levers.gap, 0.0)
    swept, every = given.copy(), np.arange(levers.total[0])
    impulse_solvers.solve(levers, swept, GOAL)
    levers.impulse[:] = 0.0
    exact = given.copy()
    assert impulse_solvers.solve_exactly(levers, exact, every, GOAL) == 1
    assert exact == pytest.approx(swept, abs=1e-9)
    assert np.count_nonzero(levers.impulse) > 2
    # Without a solution nothing changes.
    kept, exact[levers.first[0]] = levers.impulse.copy(), math.nan
    assert impulse_solvers.solve_exactly(levers, exact, every, GOAL) == 0
    assert np.array_equal(levers.impulse, kept)


def test_islands_are_solved_as_if_there_were_no_others():
    """The islands are far from each other, so that the contacts of each are those of it alone."""
    chance, parts = np.random.default_rng(3), 10
    groups = [crowd(9, chance) for _ in range(parts)]
    speeds = [chance.normal(size=(9, 3)) for _ in range(parts)]
    places = [one.position + np.array([100.0 * k, 0.0]) for k, (_, one) in enumerate(groups)]
    angles, bodies = [one.angle for _, one in groups], [body for all_of, _ in groups for body in all_of]
    stance = Stance(np.concatenate(places), np.concatenate(angles), np.zeros_like(outlines(*bodies).corner))
    levers, velocity = gathered(party(bodies), stance), np.concatenate(speeds)
    assert levers.total[0] > LEAST_FOR_ISLANDS
    impulse_solvers.solve(levers, velocity, GOAL)
    for k, (own, alone) in enumerate(groups):
        alone.position[:] = places[k]
        few = gathered(party(own), alone)
        impulse_solvers.solve(few, speeds[k], GOAL)
        assert velocity[9 * k : 9 * k + 9] == pytest.approx(speeds[k], abs=1e-9)


def test_contacts_never_pull_and_separating_ones_have_no_impulse():
    stance = Stance(np.array([(0.0, 0.0), (2.0, 0.0)]), np.zeros(2), np.zeros((0, 2)))
    levers = gathered(party([(1.0, 1.0), (1.0, 1.0)]), stance)
    velocity = np.array([(-1.0, 0.0, 0.3), (1.0, 0.0, -0.2)])
    impulse_solvers.solve(levers, velocity, GOAL)
    assert velocity.tolist() == [[-1.0, 0.0, 0.3], [1.0, 0.0, -0.2]]


def test_a_blow_beside_the_middle_turns_what_is_hit():
    """Impulse at the tip of a needle: J = 2 v / (1/m + 1/m + r^2/I), by Newton's laws."""
    stance = Stance(np.array([(0.0, 0.0), (2.0, 1.3)]), np.array([0.0, 0.0]), np.zeros((2, 2)))
    levers = gathered(party([needle(0.3), (1.0, 1.0)], mass=2.0, inertia=5.0), stance, reach=0.01)
    velocity = np.array([(0.0, 0.0, 0.0), (0.0, -1.0, 0.0)])
    impulse_solvers.solve(levers, velocity, GOAL)
    impulse = 1.0 / (0.5 + 0.5 + 2.0**2 / 5.0)
    assert velocity[0] == pytest.approx([0.0, -0.5 * impulse, -2.0 * impulse / 5.0], abs=1e-12)
    assert velocity[1] == pytest.approx([0.0, -1.0 + 0.5 * impulse, 0.0], abs=1e-12)


@pytest.mark.parametrize("aside", [0.0, 0.3])
def test_a_square_that_falls_flat_on_another_goes_on_with_it_as_one(aside):
    """Two ends stay in contact: both bodies stop, or rotate together with the conserved angular momentum, -aside."""
    stance = Stance(np.array([(0.0, 0.0), (aside, 2.4)]), np.zeros(2), np.zeros((8, 2)))
    levers = gathered(party([square(0.2), square(0.2)]), stance, reach=0.01)
    velocity = np.array([(0.0, 1.0, 0.0), (0.0, -1.0, 0.0)])
    impulse_solvers.solve(levers, velocity, GOAL)
    # Smooth edges glide: of the distance of the two centers only what lies along the edge is held.
    spin = -aside / (2.0 * 0.8 + 0.5 * aside**2)
    assert velocity[:, 2] == pytest.approx([spin, spin], abs=1e-9)
    assert velocity[:, 1] == pytest.approx([-0.5 * aside * spin, 0.5 * aside * spin], abs=1e-9)
    assert velocity[:, 0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_what_glides_along_itself_gives_way_along_itself():
    """With different mobilities along and across, a push on the flank moves it less than one on the tip."""
    mobility, lever, give, root = np.array([2.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.zeros(3), np.zeros(3)
    assert touching.impulse_response(mobility, 0.0, lever, give, root) == pytest.approx(2.0)
    assert touching.impulse_response(mobility, 0.5 * math.pi, lever, give, root) == pytest.approx(1.0)
    assert touching.impulse_response(mobility, 0.25 * math.pi, lever, give, root) == pytest.approx(1.5)
    assert give[:2] == pytest.approx([1.5, 0.5])
    assert root @ root == pytest.approx(1.5)


@pytest.mark.parametrize("seed", range(3))
def test_overlaps_are_undone_by_shifts_and_turns_about_one_center_of_mass(seed):
    chance = np.random.default_rng(seed)
    bodies, stance = crowd(6, chance)
    stance.position[:] *= 0.72
    who = party(bodies)
    levers, middle = gathered(who, stance), stance.position.mean(axis=0)
    assert deepest_overlap(levers.total, levers.gap) > 1e-2
    rounds = separate(levers, all_pairs(6), stance, who, 1e-4)
    assert rounds < 30
    apart = gathered(who, stance)
    assert deepest_overlap(apart.total, apart.gap) <= 1e-4
    assert stance.position.mean(axis=0) == pytest.approx(middle, abs=1e-9)


def test_walls_stop_tips_and_stay():
    who = party([needle(0.2)], walls=enclosed_by(box((-2.2, -5.0), (9.0, 5.0))))
    stance = Stance(np.array([(0.0, 0.0)]), np.zeros(1), np.zeros((2, 2)))
    levers = gathered(who, stance, reach=0.1)
    velocity = np.zeros((5, 3))
    velocity[0, 0] = -1.0
    impulse_solvers.solve(levers, velocity, GOAL)
    assert velocity == pytest.approx(np.zeros((5, 3)), abs=1e-12)


def test_impulses_are_found_again_by_pair_and_feature():
    stance = Stance(np.array([(0.0, 0.0), (0.3, 2.4)]), np.zeros(2), np.zeros((8, 2)))
    levers = gathered(party([square(0.2), square(0.2)]), stance, reach=0.01)
    memory = Memory(np.zeros(1, np.int64), np.zeros((8, 2), np.int64), np.zeros(8))
    kept = 1.0 + np.arange(levers.total[0])
    levers.impulse[: levers.total[0]] = kept
    contacts.remember(touching.contact_keys(levers), levers.impulse, memory, memory.impulse)
    levers.impulse[:] = 0.0
    contacts.recall(touching.contact_keys(levers), levers.impulse, memory, memory.impulse)
    assert levers.impulse[: levers.total[0]] == pytest.approx(kept)
