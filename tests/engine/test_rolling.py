"""Contacts with rolling resistance."""

import numpy as np
import pytest
from tests.engine.test_friction import DISC, energy, pressed, shaken_raft

from ecume.engine.contact import impulse_solvers, rolling
from ecume.engine.contact.friction import FrictionalContacts
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.contact.rolling import RollingContacts
from ecume.engine.walls import no_walls

pytestmark = pytest.mark.uncompiled
"""Compiled, these solvers are those of floats that roll: `tests.models.floating.test_rolling_friction`."""


def solved(position, motion, radius, coefficient, *, friction=0.5, reach=1e-6):
    """The contacts of discs after a solve, with their rows and the number of sweeps."""
    contacts, rubbing = pressed(position, motion, radius, friction, no_walls(), reach)
    contacts.bound[:] = -np.maximum(contacts.gap, 0.0)
    rows = rolling.make_rolling_rows(len(contacts.gap))
    system = RollingContacts(FrictionalContacts(contacts, rubbing), rows)
    rolling.prepare(system, radius, ((friction, friction), (coefficient, coefficient)), motion)
    return contacts, rubbing, rows, impulse_solvers.solve(system, motion, Tolerance(1e-10, 0.0))


@pytest.mark.parametrize("coefficient", [0.0, 0.05, 0.3, 2.0])
def test_couples_stay_within_their_limit_and_oppose_what_turns(coefficient):
    position, _, motion = shaken_raft()
    contacts, _, rows, most = solved(position, motion, np.ones(len(position)), coefficient, friction=0.1)
    assert most <= impulse_solvers.MOST_SWEEPS
    these = slice(contacts.total[0])
    p, r = contacts.impulse[these], rows.impulse[these]
    turning = 0.5 * (motion.spin[contacts.second[these]] - motion.spin[contacts.first[these]])
    assert np.all(np.abs(r) <= coefficient * p)
    turns = (p > 1e-9) & (np.abs(turning) > 1e-9)
    assert np.allclose(r[turns], -coefficient * p[turns] * np.sign(turning[turns]), atol=1e-9)
    holds = (p > 1e-9) & (np.abs(r) < coefficient * p * (1.0 - 1e-6))
    assert np.max(np.abs(turning[holds]), initial=0.0) < 1e-9
    assert np.any(turns) if coefficient < 2.0 else np.any(holds)


@pytest.mark.parametrize("seed", range(4))
def test_couples_keep_both_momenta_and_add_no_energy(seed):
    position, mass, motion = shaken_raft(7, seed, spread=1.0)
    dice = np.random.default_rng(seed)
    position = position + 1e-3 * dice.uniform(size=position.shape)
    radius = 1.0 - 1e-3 * dice.uniform(size=len(position))
    momentum, before = mass @ motion.velocity, energy(mass, motion)

    def turning():
        x, v = position, motion.velocity
        return np.sum(mass * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) + DISC * mass * motion.spin)

    scale, turned = np.sum(mass * np.abs(motion.velocity).sum(axis=1)), turning()
    *_, rows, _ = solved(position, motion, radius, 0.2, friction=0.4, reach=0.01)
    assert np.count_nonzero(rows.impulse) > 5
    assert mass @ motion.velocity == pytest.approx(momentum, abs=1e-13 * scale)
    assert turning() == pytest.approx(turned, abs=1e-12 * scale)
    assert energy(mass, motion) < before


@pytest.mark.long
def test_without_a_coefficient_the_solution_is_that_of_friction():
    position, _, motion = shaken_raft()
    plain = motion._replace(velocity=motion.velocity.copy(), spin=motion.spin.copy())
    solved(position, motion, np.ones(len(position)), 0.0, friction=0.2)
    contacts, rubbing = pressed(position, plain, np.ones(len(position)), 0.2, no_walls())
    contacts.bound[:] = -np.maximum(contacts.gap, 0.0)
    impulse_solvers.solve(FrictionalContacts(contacts, rubbing), plain, Tolerance(1e-10, 0.0))
    assert motion.velocity == pytest.approx(plain.velocity, abs=1e-8)
    assert motion.spin == pytest.approx(plain.spin, abs=1e-8)
