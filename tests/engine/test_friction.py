import math

import numpy as np
import pytest
from tests.engine.test_contacts import a_raft, all_candidates

from ecume.engine.cells import no_periods
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction as rough
from ecume.engine.contact import impulse_solvers
from ecume.engine.contact.contacts import Bodies, DiscMotion, Memory
from ecume.engine.contact.friction import FrictionalContacts, Motion
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.walls import box, enclosed_by, no_walls

DISC = 0.5
"""Moment of inertia over m R^2."""


def pressed(position, motion, radius, friction, walls, reach=1e-6):
    """The contacts of these bodies, prepared for the solver."""
    contacts = touching.make_contacts(8 * len(position) + 16)
    bodies = Bodies(radius, walls, motion.mobility, no_periods(2))
    assert touching.gather(contacts, all_candidates(position), position, bodies, reach)
    touching.set_effective_masses(contacts, motion.mobility)
    rubbing = rough.make_friction_rows(len(contacts.gap))
    rough.prepare(FrictionalContacts(contacts, rubbing), radius, ((friction, friction), (0.0, 0.0)), motion)
    return contacts, rubbing


def shaken_raft(count=37, seed=0, spread=0.3):
    """Discs in contact with different masses and radii near one, with gaps, disordered velocities toward each other,
    and spins.
    """
    position, velocity = a_raft(count, seed)
    chance = np.random.default_rng([seed, 1])
    mass = 10.0 ** chance.uniform(-spread, spread, count)
    velocity = velocity + 0.3 * chance.normal(size=velocity.shape)
    motion = Motion(velocity, chance.normal(size=count), 1.0 / mass, 1.0 / (DISC * mass))
    return position, mass, motion


def sliding(contacts, rubbing, motion):
    """The relative tangential velocity of the two surfaces of each contact."""
    rows = slice(contacts.total[0])
    i, j, arm = contacts.first[rows], contacts.second[rows], rubbing.arm[rows]
    apart, normal = motion.velocity[j] - motion.velocity[i], contacts.normal[rows]
    along = normal[:, 0] * apart[:, 1] - normal[:, 1] * apart[:, 0]
    return along - arm[:, 0] * motion.spin[i] - arm[:, 1] * motion.spin[j]


def energy(mass, motion):
    return 0.5 * np.sum(mass * np.sum(motion.velocity**2, axis=1)) + 0.5 * np.sum(DISC * mass * motion.spin**2)


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5, 2.0])
def test_impulses_stay_inside_their_cone_and_what_slides_is_braked(friction):
    position, _, motion = shaken_raft()
    contacts, rubbing = pressed(position, motion, np.ones(len(position)), friction, no_walls())
    assert (
        impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(1e-10, 0.0))
        <= impulse_solvers.MOST_SWEEPS
    )
    rows = contacts.total[0]
    p, q, s = contacts.impulse[:rows], rubbing.impulse[:rows], sliding(contacts, rubbing, motion)
    assert np.all(np.abs(q) <= friction * p)
    slides = (p > 1e-9) & (np.abs(s) > 1e-9)
    assert np.allclose(q[slides], -friction * p[slides] * np.sign(s[slides]), atol=1e-9)
    sticks = (p > 1e-9) & (np.abs(q) < friction * p * (1.0 - 1e-6))
    assert np.max(np.abs(s[sticks]), initial=0.0) < 1e-9
    assert np.any(slides) if friction == 0.1 else friction == 0.0 or np.any(sticks)


def test_a_solve_that_no_longer_improves_ends_where_it_is_acceptable():
    """Rounding keeps the residual above zero."""
    position, _, motion = shaken_raft(7)
    contacts, rubbing = pressed(position, motion, np.ones(len(position)), 0.3, no_walls())
    most = impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(0.0, 1e-6))
    assert most % impulse_solvers.PATIENCE == 0
    assert most < impulse_solvers.MOST_SWEEPS


@pytest.mark.long
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(each, marks=[pytest.mark.compiled, pytest.mark.long]) for each in (1, 2, 3))]
)
def test_friction_keeps_momentum_and_angular_momentum_and_adds_no_energy(seed):
    position, mass, motion = shaken_raft(19, seed, spread=1.0)
    position = position + 1e-3 * np.random.default_rng(seed).uniform(size=position.shape)
    momentum, before = mass @ motion.velocity, energy(mass, motion)

    def turning():
        x, v = position, motion.velocity
        return np.sum(mass * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) + DISC * mass * motion.spin)

    scale, turned = np.sum(mass * np.abs(motion.velocity).sum(axis=1)), turning()
    contacts, rubbing = pressed(position, motion, np.ones(len(position)), 0.4, no_walls(), reach=0.01)
    contacts.bound[:] = -np.maximum(contacts.gap, 0.0)
    impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(1e-9, 0.0))
    assert np.count_nonzero(rubbing.impulse) > 10
    assert mass @ motion.velocity == pytest.approx(momentum, abs=1e-13 * scale)
    assert turning() == pytest.approx(turned, abs=1e-12 * scale)
    assert energy(mass, motion) < before


def test_without_friction_the_solution_is_that_of_smooth_contacts():
    position, _, motion = shaken_raft()
    smooth = motion.velocity.copy()
    contacts, rubbing = pressed(position, motion, np.ones(len(position)), 0.0, no_walls())
    spin = motion.spin.copy()
    impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(1e-11, 0.0))
    contacts.impulse[:] = 0.0
    impulse_solvers.solve(contacts, DiscMotion(smooth, motion.mobility), Tolerance(1e-11, 0.0))
    assert motion.velocity == pytest.approx(smooth, abs=1e-9)
    assert np.array_equal(motion.spin, spin)


@pytest.mark.parametrize(("friction", "slide"), [(0.05, True), (0.4, False)])
def test_an_oblique_collision_slides_or_sticks_as_coulomb_says(friction, slide):
    # Two equal discs; the reduced tangential mass is 1/6 of one's mass, the normal one half of it.
    motion = Motion(np.array([[1.0, 0.5], [-1.0, 0.0]]), np.array([0.3, 0.0]), np.ones(2), np.full(2, 1.0 / DISC))
    contacts, rubbing = pressed(np.array([[0.0, 0.0], [2.0, 0.0]]), motion, np.ones(2), friction, no_walls())
    impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(1e-13, 0.0))
    sticking = (0.5 + 0.3) / 6.0
    assert (friction * 1.0 < sticking) == slide
    pushed = min(sticking, friction * 1.0)
    assert motion.velocity == pytest.approx(np.array([[0.0, 0.5 - pushed], [0.0, pushed]]), abs=1e-12)
    assert motion.spin == pytest.approx(np.array([0.3 - pushed / DISC, -pushed / DISC]), abs=1e-12)


def on_a_slope(angle, friction, ease, steps=100):
    """The speed and spin of a disc on a wall below it, after a time of one, for gravity inclined by an angle."""
    motion = Motion(np.zeros((2, 2)), np.zeros(2), np.array([1.0, 0.0]), np.array([ease, 0.0]))
    floor = enclosed_by(box((-9.0, 0.0), (9.0, 9.0)))
    floor = floor._replace(normal=floor.normal[1:2], offset=floor.offset[1:2])
    for _ in range(steps):
        motion.velocity[0, 0] += math.sin(angle) / steps
        motion.velocity[0, 1] -= math.cos(angle) / steps
        contacts, rubbing = pressed(np.array([[0.0, 1.0]]), motion, np.ones(1), friction, floor)
        impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(1e-13, 0.0))
    return motion.velocity[0, 0], motion.spin[0]


@pytest.mark.parametrize("angle", [0.2, 0.5])
def test_a_block_on_a_slope_slides_only_beyond_the_angle_of_friction(angle):
    held, _ = on_a_slope(angle, 1.01 * math.tan(angle), ease=0.0)
    sliding, _ = on_a_slope(angle, 0.5 * math.tan(angle), ease=0.0)
    assert held == pytest.approx(0.0, abs=1e-12)
    assert sliding == pytest.approx(0.5 * math.sin(angle), rel=1e-12)


def test_a_disc_on_a_slope_rolls_up_to_three_times_the_tangent_and_slips_beyond():
    angle = 0.4
    rolling, spin = on_a_slope(angle, 1.01 * math.tan(angle) / 3.0, ease=1.0 / DISC)
    assert rolling == pytest.approx(2.0 / 3.0 * math.sin(angle), rel=1e-12)
    assert spin == pytest.approx(-rolling, rel=1e-12)
    slipping, spin = on_a_slope(angle, 0.5 * math.tan(angle) / 3.0, ease=1.0 / DISC)
    assert slipping == pytest.approx(math.sin(angle) * (1.0 - 0.5 / 3.0), rel=1e-12)
    assert abs(spin) < slipping


def test_tangential_impulses_are_recalled_for_the_pairs_they_belong_to():
    position, _, motion = shaken_raft()
    contacts, rubbing = pressed(position, motion, np.ones(len(position)), 0.4, no_walls())
    memory = Memory(np.zeros(1, np.int64), np.zeros((300, 2), np.int64), np.zeros(300))
    cold = motion._replace(velocity=motion.velocity.copy(), spin=motion.spin.copy())
    tangential_impulse = np.zeros(300)
    first = impulse_solvers.solve(FrictionalContacts(contacts, rubbing), cold, Tolerance(1e-9, 0.0))
    found = rubbing.impulse.copy()
    touching.remember(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    rough.remember(FrictionalContacts(contacts, rubbing), memory, tangential_impulse)
    contacts.impulse[:], rubbing.impulse[:] = 0.0, 0.0
    touching.recall(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    rough.recall(FrictionalContacts(contacts, rubbing), memory, tangential_impulse)
    assert np.array_equal(rubbing.impulse, found)
    assert impulse_solvers.solve(FrictionalContacts(contacts, rubbing), motion, Tolerance(1e-8, 0.0)) < 0.2 * first


@pytest.mark.long
def test_rough_islands_are_solved_as_if_there_were_no_others():
    motions, places, size = [], [], 19
    for seed in range(4):
        position, _, motion = shaken_raft(size, seed)
        places.append(position + np.array([200.0 * seed, 0.0]))
        motions.append(motion)
    whole = Motion(*(np.concatenate(parts) for parts in zip(*motions, strict=True)))
    contacts, rubbing = pressed(np.concatenate(places), whole, np.ones(4 * size), 0.3, no_walls())
    assert contacts.total[0] > impulse_solvers.LEAST_FOR_ISLANDS
    impulse_solvers.solve(FrictionalContacts(contacts, rubbing), whole, Tolerance(1e-11, 0.0))
    for k, (place, alone) in enumerate(zip(places, motions, strict=True)):
        few = FrictionalContacts(*pressed(place, alone, np.ones(size), 0.3, no_walls()))
        impulse_solvers.solve(few, alone, Tolerance(1e-11, 0.0))
        own = slice(k * size, (k + 1) * size)
        assert whole.velocity[own] == pytest.approx(alone.velocity, abs=1e-8)
        assert whole.spin[own] == pytest.approx(alone.spin, abs=1e-8)
