"""Tangential laws and tension laws: the energy of closed paths of deflections, and the range of definite stiffness."""

import itertools
import math

import numpy as np
import pytest

from ecume.laws.soft_contacts import (
    DEFINITE,
    TANGENTIAL,
    TENSION,
    cavitated_draw,
    cavitation_limit,
    gap_widening,
    whole_bending,
)
from ecume.laws.surfaces import Body
from ecume.models.soft.contacts.contact import contact_energy, elastic_of
from tests.models.soft.clusters import contacts

BODY, GAP = Body(2.0, 0.5, 1.0, 0.0, 0.0), 0.003
LOOPS, CORNERS, POINTS = 10_000, 4, 12
LAWS = [(tangential, tension) for tangential in TANGENTIAL for tension in TENSION]
each_law = pytest.mark.parametrize(("tangential", "tension"), LAWS)


def forces(normal, shear, tangential, tension):
    """Both forces for arrays of deflections of two unit spheres, from the formulas of the documentation."""
    widening = np.minimum(normal, 0.0) if tension == "gap" else normal
    bend = np.hypot(widening, shear) if tangential == "potential" else np.abs(widening)
    rest, bent = np.sqrt(GAP + np.abs(widening)), np.sqrt(GAP + bend)
    tensile = (normal > 0.0) & (tension == "gap")
    return np.where(tensile, rest, bent) * normal, bent * shear


@each_law
def test_the_formulas_of_the_loops_are_those_of_contacts(tangential, tension):
    given = contacts(tangential_law=tangential, tension_law=tension)
    for normal, shear in np.random.default_rng(2).uniform(-0.1, 0.1, (20, 2)):
        found = elastic_of(given, BODY, GAP, normal, shear)
        expected = forces(normal, shear, tangential, tension)
        assert (found.normal * normal, found.tangential * shear) == pytest.approx(expected, rel=1e-12)


def paths():
    """Corners (L, K, 2) of closed paths of (delta_n, delta_t), that cross delta_n = 0 or lie on either side of it."""
    random = np.random.default_rng(19)
    corners = random.uniform(-0.1, 0.1, (LOOPS, CORNERS, 2))
    corners[: LOOPS // 4, :, 0] = -np.abs(corners[: LOOPS // 4, :, 0])
    corners[LOOPS // 4 : LOOPS // 2, :, 0] *= 0.02
    return corners


def given_work(corners, tangential, tension):
    """The work done on a contact along each closed path, by quadrature; sides are cut where a deflection is zero."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    # Nodes gather at both ends of a part: forces have kinks and steep roots where a deflection vanishes.
    nodes, weights = 0.5 * (1.0 + np.sin(0.5 * np.pi * nodes)), 0.25 * np.pi * np.cos(0.5 * np.pi * nodes) * weights
    begin, end = corners, np.roll(corners, -1, axis=1)
    change = end - begin
    turns = [np.clip(-begin[..., k] / np.where(change[..., k] == 0.0, 1.0, change[..., k]), 0.0, 1.0) for k in range(2)]
    nearest = np.clip(-(begin * change).sum(-1) / np.maximum((change**2).sum(-1), 1e-300), 0.0, 1.0)
    cuts = np.sort(np.stack([np.zeros_like(nearest), *turns, nearest, np.ones_like(nearest)]), axis=0)
    total = np.zeros(len(corners))
    for low, high in itertools.pairwise(cuts):
        part = low[..., None] + (high - low)[..., None] * nodes
        normal, shear = (begin[..., k, None] + part * change[..., k, None] for k in range(2))
        pulls = forces(normal, shear, tangential, tension)
        work = sum(pull * change[..., k, None] for k, pull in enumerate(pulls))
        total += ((work * weights).sum(-1) * (high - low)).sum(-1)
    return total


@pytest.mark.parametrize(("tangential", "tension"), [law for law in LAWS if law[1] != "cavitation"])
def test_a_contact_never_returns_more_energy_than_it_was_given(tangential, tension):
    """The paper's tangential law does, by a tenth of the largest stored energy."""
    work = given_work(paths(), tangential, tension)
    stored = np.sqrt(GAP + 0.1) * 0.01
    if tangential == "potential":
        assert np.abs(work).max() < 1e-7 * stored
    else:
        assert work.min() < -0.05 * stored


@pytest.mark.parametrize("tension", TENSION)
def test_unloading_at_a_held_tangential_force_returns_no_energy(tension):
    """Compress, shear, decompress while the tangential force stays, release: from the energies of contacts."""
    given = contacts(tension_law=tension)
    start, held = (-0.05, 0.0), 0.008
    corners = [start, (-0.05, _sheared(-0.05, held, tension))]
    corners += [(normal, _sheared(normal, held, tension)) for normal in np.linspace(-0.05, 0.01, 400)[1:]]
    corners += [(0.01, 0.0)]
    work = given_work(np.array([corners]), "potential", tension)[0]
    stored = [contact_energy(given, BODY, GAP, normal, shear**2) for normal, shear in corners]
    assert abs(work) < 1e-7 * max(stored)
    assert corners[-2][1] > 1.2 * corners[1][1]


def _sheared(normal, force, tension):
    """The tangential deflection under a force, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if forces(normal, middle, "potential", tension)[1] < force else (low, middle)
    return low


def stiffness(normal, shear, tangential):
    """The stiffness matrix of a contact in the plane of its normal and its shear."""
    found = elastic_of(contacts(tangential_law=tangential), BODY, 1e-9, normal, shear)
    bend = np.array([[found.normal_by_stretch, found.normal_by_shear], [found.tangential_by_stretch,
                     found.tangential_by_shear]])  # fmt: skip
    pull = np.array([found.normal * normal, found.tangential * shear])
    return np.diag([found.normal, found.tangential]) + pull[:, None] * bend


@pytest.mark.parametrize("normal", [-0.05, 0.05])
def test_the_law_of_one_potential_is_definite_where_that_of_the_paper_is_not(normal):
    for ratio, definite in ((0.99 * DEFINITE, True), (1.02 * DEFINITE, False)):
        secant = stiffness(normal, ratio * abs(normal), "secant")
        assert (np.linalg.eigvalsh(0.5 * (secant + secant.T)).min() > 0.0) == definite
        potential = stiffness(normal, ratio * abs(normal), "potential")
        assert potential == pytest.approx(potential.T, rel=1e-12)
        assert np.linalg.eigvalsh(potential).min() > 0.1 * np.linalg.eigvalsh(potential).max()


def test_small_shear_is_that_of_the_paper():
    for shear in (1e-3, 1e-2):
        bend, expected = whole_bending(-0.1, shear, 1.0).deflection, 0.1 * (1.0 + 0.5 * (shear / 0.1) ** 2)
        assert bend == pytest.approx(expected, rel=2e-5)


def test_tension_does_not_widen_a_contact_by_the_gap_alone():
    assert gap_widening(0.3).deflection == 0.0
    contact = elastic_of(contacts(tension_law="gap"), BODY, GAP, 0.1, 0.0)
    assert contact.size == pytest.approx(math.sqrt(GAP))
    assert elastic_of(contacts(tension_law="symmetric"), BODY, GAP, 0.1, 0.0).size == pytest.approx(
        math.sqrt(GAP + 0.1)
    )


def test_a_film_cavitates_above_its_limit_without_a_jump():
    limit = cavitation_limit(0.1, 3.0)
    for tension in (-limit, 0.999 * limit):
        assert cavitated_draw(tension, 0.1, 3.0) == (tension, 1.0, 0.0)
    fine = 1e-7 * limit
    for tension in (1.01 * limit, 1.02 * limit + 2 * fine, 1.5 * limit):
        at = cavitated_draw(tension, 0.1, 3.0)
        ends = [cavitated_draw(tension + way * fine, 0.1, 3.0).tension for way in (-1, 1)]
        assert at.by_tension == pytest.approx((ends[1] - ends[0]) / (2 * fine), rel=1e-5)
        sizes = [cavitated_draw(tension, 0.1 * math.exp(way), 3.0).tension for way in (1e-7, -1e-7)]
        assert at.by_size == pytest.approx((sizes[0] - sizes[1]) / 2e-7, rel=1e-5)
    assert cavitated_draw(1.1 * limit, 0.1, 3.0).tension > 5 * limit
