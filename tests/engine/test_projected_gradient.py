"""Contacts solved by products with the mobility, compared with sweeps over contacts."""

import numpy as np
import pytest
from tests.engine.test_contacts import a_raft, gathered, round_wall

from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers, mobility_contacts
from ecume.engine.contact.contacts import DiscMotion
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.walls import no_walls, wall_count


@pytest.mark.parametrize("walls", [no_walls(), round_wall(6.8)])
def test_projected_gradients_find_the_velocities_of_gauss_seidel(walls):
    position, velocity = a_raft()
    velocity = np.add(velocity, [0.4, 0.0])
    mobility = np.concatenate([np.linspace(0.5, 2.0, len(position)), np.zeros(wall_count(walls))])
    velocity = np.concatenate([velocity, np.zeros((len(mobility) - len(position), 2))])
    goal = Tolerance(1e-9, 1e-9)
    contacts = gathered(position, np.ones(len(position)), walls, mobility)
    touching.normal_velocities(contacts, velocity, contacts.scratch)
    contacts.bound[: contacts.total[0]] = -np.maximum(contacts.gap[: contacts.total[0]], 0.0)
    expected = velocity.copy()
    impulse_solvers.solve(contacts, DiscMotion(expected, mobility), goal)
    contacts.impulse[:] = 0.0
    found = velocity.copy()
    products = mobility_contacts.solve_by_products(contacts, found, lambda force: mobility[:, None] * force, *goal)
    assert products <= mobility_contacts.MOST_PRODUCTS
    assert found == pytest.approx(expected, abs=1e-7)
    assert np.all(contacts.impulse[: contacts.total[0]] >= 0.0)
    # From the solution one product is enough.
    again = velocity.copy()
    assert mobility_contacts.solve_by_products(contacts, again, lambda force: mobility[:, None] * force, *goal) == 1
