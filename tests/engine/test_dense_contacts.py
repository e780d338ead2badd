"""Contacts with a full mobility matrix, against the solver for single mobilities and against the conditions."""

import numpy as np
import pytest

from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers, mobility_contacts
from ecume.engine.contact.contacts import DiscMotion
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.contact.mobility_contacts import CoupledContacts, make_dense_rows, row_speed

GOAL = Tolerance(1e-10, 1e-8)


def chain(dice, count):
    """Contacts of a chain of bodies, with random normals and bounds; the rows of the dense solver."""
    contacts = touching.make_contacts(count - 1)
    contacts.total[0] = count - 1
    rows = make_dense_rows(count - 1, count - 1, 2 * count)
    for row in range(count - 1):
        angle = dice.uniform(0.0, 2.0 * np.pi)
        normal = np.array([np.cos(angle), np.sin(angle)])
        contacts.first[row], contacts.second[row], contacts.normal[row] = row, row + 1, normal
        contacts.bound[row] = rows.bound[row] = -abs(dice.normal())
        rows.place[row, :4] = np.arange(2 * row, 2 * row + 4)
        rows.value[row, :4] = [*-normal, *normal]
    return contacts, rows


def test_a_diagonal_mobility_gives_the_velocities_of_the_other_solver():
    dice = np.random.default_rng(5)
    contacts, rows = chain(dice, 12)
    mobility, velocity = dice.uniform(0.5, 2.0, 12), 3.0 * dice.normal(size=(12, 2))
    motion = velocity.ravel().copy()
    impulse_solvers.solve(CoupledContacts(rows, np.diag(np.repeat(mobility, 2))), motion, GOAL)
    touching.set_effective_masses(contacts, mobility)
    impulse_solvers.solve(contacts, DiscMotion(velocity, mobility), GOAL)
    assert motion == pytest.approx(velocity.ravel(), abs=1e-8)
    assert np.count_nonzero(contacts.impulse > 0.0) >= 3


@pytest.mark.parametrize("friction", [False, True])
def test_the_conditions_hold_with_a_full_matrix(friction):
    dice = np.random.default_rng(8)
    smooth = chain(dice, 9)[1]
    size, total = 18, 8
    rows = make_dense_rows(2 * total, total, size) if friction else smooth
    rows.bound[:], rows.place[:total], rows.value[:total] = smooth.bound, smooth.place, smooth.value
    if friction:
        rows.friction[:] = 0.5
        rows.place[total:] = smooth.place
        # Across the normal: (x, y) becomes (-y, x).
        rows.value[total:, 0:4:2], rows.value[total:, 1:4:2] = -smooth.value[:, 1:4:2], smooth.value[:, 0:4:2]
    half = dice.normal(size=(size, size))
    mobility, given = half @ half.T / size + np.eye(size), 3.0 * dice.normal(size=size)
    motion = given.copy()
    system = CoupledContacts(rows, mobility)
    assert impulse_solvers.solve(system, motion, GOAL) < 2000
    assert impulse_solvers.residual(system, motion, np.arange(total)) <= GOAL.target
    jacobian = np.zeros((len(rows.impulse), size))
    for row in range(len(jacobian)):
        for entry in range(mobility_contacts.ENTRIES):
            jacobian[row, rows.place[row, entry]] += rows.value[row, entry]
    assert motion == pytest.approx(given + mobility @ jacobian.T @ rows.impulse, abs=1e-9)
    speed, p = jacobian @ motion, rows.impulse[:total]
    assert np.all(speed[:total] >= rows.bound - 1e-9)
    assert p @ np.maximum(speed[:total] - rows.bound, 0.0) < 1e-7
    assert row_speed(rows.place, rows.value, 3, motion) == pytest.approx(speed[3])
    if friction:
        q = rows.impulse[total:]
        assert np.all(np.abs(q) <= 0.5 * p + 1e-12)
        sliding = np.abs(speed[total:]) > 1e-7
        assert np.any(sliding & (p > 0.0))
        assert q[sliding] == pytest.approx(-0.5 * p[sliding] * np.sign(speed[total:][sliding]), abs=1e-9)
