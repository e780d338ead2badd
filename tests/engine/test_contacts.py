import numpy as np
import pytest

from ecume.engine.cells import no_periods
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers
from ecume.engine.contact.contacts import Bodies, DiscMotion, Memory
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.placement import place_on_lattice
from ecume.engine.walls import disc, enclosed_by, no_walls


def round_wall(radius):
    return enclosed_by(disc((0.0, 0.0), radius))


def all_candidates(position):
    count = len(position)
    candidates = touching.make_candidates(count, count * count)
    partners = [list(range(i + 1, count)) for i in range(count)]
    candidates.first[1:] = np.cumsum([len(row) for row in partners])
    candidates.partner[: candidates.first[-1]] = [j for row in partners for j in row]
    return candidates


def gathered(position, radius, walls, mobility, reach=1e-6):
    contacts = touching.make_contacts(8 * len(position) + 16)
    bodies = Bodies(radius, walls, mobility, no_periods(2))
    assert touching.gather(contacts, all_candidates(position), position, bodies, reach)
    touching.set_effective_masses(contacts, mobility)
    return contacts


def a_raft(count=37, seed=0):
    """A raft that is compressed by slightly disordered velocities."""
    position = place_on_lattice(count, 2.0, (0.0, 0.0))
    velocity = -0.3 * position + 0.05 * np.random.default_rng(seed).normal(size=position.shape)
    return position, velocity


def test_solved_contacts_neither_overlap_nor_pull():
    position, velocity = a_raft()
    mobility = np.random.default_rng(1).uniform(0.5, 2.0, len(position))
    contacts = gathered(position, np.ones(len(position)), no_walls(), mobility)
    impulse_solvers.solve(contacts, DiscMotion(velocity, mobility), Tolerance(1e-10, 0.0))
    speed, rows = np.zeros(len(contacts.gap)), contacts.total[0]
    touching.normal_velocities(contacts, velocity, speed)
    assert np.min(speed[:rows]) > -1e-10
    assert np.min(contacts.impulse[:rows]) >= 0.0
    assert np.max(contacts.impulse[:rows] * speed[:rows]) < 1e-9


def test_impulses_conserve_momentum_to_rounding_however_unlike_the_masses():
    position, velocity = a_raft(12)
    mass = 10.0 ** np.random.default_rng(2).uniform(-2, 2, len(position))
    before = mass @ velocity
    contacts = gathered(position, np.ones(len(position)), no_walls(), 1.0 / mass)
    impulse_solvers.solve(contacts, DiscMotion(velocity, 1.0 / mass), Tolerance(1e-9, 0.0))
    assert mass @ velocity == pytest.approx(before, abs=1e-13 * np.sum(mass * np.abs(velocity[:, 0])))


def test_plastic_contacts_never_add_kinetic_energy():
    position, velocity = a_raft()
    before = np.sum(velocity**2)
    contacts = gathered(position, np.ones(len(position)), no_walls(), np.ones(len(position)))
    impulse_solvers.solve(contacts, DiscMotion(velocity, np.ones(len(position))), Tolerance(1e-10, 0.0))
    assert np.sum(velocity**2) < before


def test_the_solution_is_that_of_a_general_quadratic_solver():
    from scipy.optimize import nnls

    position, velocity = a_raft(7)
    mobility = np.ones(7)
    contacts = gathered(position, np.ones(7), no_walls(), mobility)
    rows = contacts.total[0]
    jacobian = np.zeros((rows, 14))
    for row in range(rows):
        i, j = contacts.first[row], contacts.second[row]
        jacobian[row, 2 * i : 2 * i + 2] -= contacts.normal[row]
        jacobian[row, 2 * j : 2 * j + 2] += contacts.normal[row]
    impulses, _ = nnls(jacobian.T, -velocity.ravel(), maxiter=1000)
    expected = velocity.ravel() + jacobian.T @ impulses
    impulse_solvers.solve(contacts, DiscMotion(velocity, mobility), Tolerance(1e-12, 0.0))
    assert velocity.ravel() == pytest.approx(expected, abs=1e-9)


def test_a_wall_stops_what_leans_on_it_through_others():
    position = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]])
    velocity = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    mobility = np.array([1.0, 1.0, 1.0, 0.0])
    contacts = gathered(position, np.ones(3), round_wall(5.0), mobility)
    impulse_solvers.solve(contacts, DiscMotion(velocity, mobility), Tolerance(1e-12, 0.0))
    assert velocity[:, 0] == pytest.approx(np.zeros(4), abs=1e-11)


def test_a_warm_start_from_the_solution_needs_one_sweep():
    position, velocity = a_raft()
    mobility = np.ones(len(position))
    contacts = gathered(position, np.ones(len(position)), no_walls(), mobility)
    memory = Memory(np.zeros(1, np.int64), np.zeros((300, 2), np.int64), np.zeros(300))
    cold = impulse_solvers.solve(contacts, DiscMotion(velocity.copy(), mobility), Tolerance(1e-9, 0.0))
    touching.remember(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    contacts.impulse[:] = 0.0
    touching.recall(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    assert impulse_solvers.solve(contacts, DiscMotion(velocity.copy(), mobility), Tolerance(1e-9, 0.0)) == 1 < cold


def test_impulses_are_recalled_for_the_pairs_they_belong_to():
    position, _ = a_raft()
    contacts = gathered(position, np.ones(len(position)), no_walls(), np.ones(len(position)))
    memory = Memory(np.zeros(1, np.int64), np.zeros((300, 2), np.int64), np.zeros(300))
    rows = contacts.total[0]
    contacts.impulse[:rows] = 100.0 * contacts.first[:rows] + contacts.second[:rows]
    touching.remember(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    fewer = np.delete(np.arange(rows), np.arange(0, rows, 3))
    contacts.first[: len(fewer)], contacts.second[: len(fewer)] = contacts.first[fewer], contacts.second[fewer]
    contacts.total[0] = len(fewer)
    touching.recall(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    expected = 100.0 * contacts.first[: len(fewer)] + contacts.second[: len(fewer)]
    assert np.array_equal(contacts.impulse[: len(fewer)], expected)


def test_overlaps_are_undone_without_moving_the_center_of_mass():
    position = 0.95 * place_on_lattice(19, 2.0, (0.0, 0.0))
    mobility = np.random.default_rng(4).uniform(0.5, 2.0, 19)
    before = position.T @ (1.0 / mobility)
    contacts = gathered(position, np.ones(19), no_walls(), mobility, reach=0.5)
    touching.separate(contacts, position, Bodies(np.ones(19), no_walls(), mobility, no_periods(2)), 1e-6)
    apart = gathered(position, np.ones(19), no_walls(), mobility, reach=0.5)
    assert np.min(apart.gap[: apart.total[0]]) > -1e-6
    assert position.T @ (1.0 / mobility) == pytest.approx(before, abs=1e-12)


def test_undone_overlaps_move_angular_momentum_by_no_more_than_distances_change():
    position = np.array([[-0.99, 0.0], [0.99, 0.0]])
    velocity = np.array([[0.3, -0.4], [-0.2, 0.7]])
    mobility = np.array([0.5, 2.0])

    def turning():
        return float(np.sum((position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]) / mobility))

    before = turning()
    contacts = gathered(position, np.ones(2), no_walls(), mobility)
    touching.separate(contacts, position, Bodies(np.ones(2), no_walls(), mobility, no_periods(2)), 1e-6)
    # What the two have about their center of mass is the reduced mass, 0.4, times 1.98 times how fast they slide.
    assert turning() - before == pytest.approx(0.02 / 1.98 * 0.4 * 1.98 * 1.1, rel=1e-3)


def test_two_centers_in_one_place_are_moved_apart_all_the_same():
    position = np.zeros((2, 2))
    contacts = gathered(position, np.ones(2), no_walls(), np.ones(2))
    touching.separate(contacts, position, Bodies(np.ones(2), no_walls(), np.ones(2), no_periods(2)), 1e-6)
    assert np.hypot(*(position[1] - position[0])) == pytest.approx(2.0, abs=1e-6)


def test_contacts_without_room_say_so():
    position, _ = a_raft()
    contacts = touching.make_contacts(3)
    bodies = Bodies(np.ones(len(position)), no_walls(), np.ones(len(position)), no_periods(2))
    assert not touching.gather(contacts, all_candidates(position), position, bodies, 1e-6)


def many_pairs(pairs=70):
    """Pairs in contact next to each other; the last ones touch a wall and each other."""
    x = np.repeat(5.0 * np.arange(pairs), 2)
    y = np.tile([0.0, 2.0], pairs)
    return np.column_stack([x - x.mean(), y])


@pytest.mark.parametrize("colliding", [(), (3,), (3, 4, 40), tuple(range(70))])
def test_each_island_is_solved_as_if_it_were_alone(colliding):
    position = many_pairs()
    dish = round_wall(float(np.hypot(*position.T).max()) + 1.0)
    mobility = np.append(np.random.default_rng(2).uniform(0.5, 2.0, len(position)), 0.0)
    velocity = np.zeros((len(position) + 1, 2))
    velocity[3:-2:2, 1] = 0.1  # all but those at the wall part
    for pair in colliding:
        velocity[2 * pair : 2 * pair + 2] = [[0.1, 1.0], [0.2, -1.0 - 0.1 * pair]]
    contacts = gathered(position, np.ones(len(position)), dish, mobility)
    assert contacts.total[0] >= impulse_solvers.LEAST_FOR_ISLANDS
    together = velocity.copy()
    impulse_solvers.solve(contacts, DiscMotion(together, mobility), Tolerance(1e-12, 0.0))
    assert (contacts.impulse > 0.0).any() == bool(colliding)
    for pair in range(len(position) // 2):
        both = [2 * pair, 2 * pair + 1]
        alone = np.vstack([velocity[both], np.zeros((1, 2))])
        rows = gathered(position[both], np.ones(2), dish, np.append(mobility[both], 0.0))
        impulse_solvers.solve(rows, DiscMotion(alone, np.append(mobility[both], 0.0)), Tolerance(1e-12, 0.0))
        assert np.array_equal(together[both], alone[:2])
    assert not together[-1].any()


def two_rows_of_forty():
    """Contacts of floats side by side, with a gap in the middle and walls at both ends."""
    position = np.column_stack([2.0 * np.arange(80.0), np.zeros(80)])
    position[40:, 0] += 1.0
    position -= position.mean(axis=0)
    mobility = np.append(np.ones(80), 0.0)
    return gathered(position, np.ones(80), round_wall(float(np.abs(position).max()) + 1.0), mobility), mobility


def test_islands_hang_together_by_floats_and_not_by_walls():
    contacts, mobility = two_rows_of_forty()
    assert (contacts.second[: contacts.total[0]] == 80).sum() == 2
    assert len(islands_of(contacts, mobility).rows) == 0, "no contact has an impulse"
    contacts.impulse[1] = 1.0  # between the second and the third
    one = islands_of(contacts, mobility)
    assert len(one.first) == 2
    assert set(contacts.first[one.rows]) | set(contacts.second[one.rows]) == {*range(40), 80}
    assert (np.diff(one.rows) > 0).all()
    contacts.change[contacts.total[0] - 1] = -1.0
    both = islands_of(contacts, mobility)
    assert list(both.first) == [0, 40, 80]
    assert sorted(both.rows) == list(range(80))


def test_a_float_that_is_pinned_parts_islands():
    contacts, mobility = two_rows_of_forty()
    contacts.impulse[:] = 1.0
    mobility[20] = 0.0
    assert [len(part) for part in parts_of(islands_of(contacts, mobility))] == [21, 19, 40]


def islands_of(contacts, mobility):
    return touching.islands(contacts, DiscMotion(np.zeros((len(mobility), 2)), mobility))


def parts_of(islands):
    return np.split(islands.rows, islands.first[1:-1])
