"""The linear response of a contact is the derivative of its behavior."""

import itertools
import math

import numpy as np
import pytest

from ecume.laws.interfaces import INTERFACES
from ecume.models.law_codes import code_of
from ecume.models.soft.integration.dirk_schemes import SCHEMES

from .clusters import LOPSIDED, PAPER, contacts, one_contact

WAYS = {
    "paper": contacts(PAPER),
    "lopsided": contacts(LOPSIDED, viscosity=0.3),
    "fading": contacts(LOPSIDED, fade_from=0.01, fade_to=0.2),
    "steric": contacts(PAPER, remote=1, strength=0.02, steric_length=0.3),
    "bubble": contacts(LOPSIDED, surface=1, surface_tension=0.7),
    "half-mobile": contacts(PAPER, interface=1),
    "mobile": contacts(LOPSIDED, interface=2),
    "drop": contacts(LOPSIDED, interface=3, viscosity_ratio=0.6),
    "elastohydrodynamic": contacts(LOPSIDED, interface=4),
    "elastohydrodynamic-rough": contacts(PAPER, interface=4, friction=1, coefficient=0.2, roughness=0.1),
    "sticking": contacts(LOPSIDED, friction=1, coefficient=50.0, roughness=0.1),
    "slipping": contacts(LOPSIDED, friction=1, coefficient=0.2, roughness=0.1),
    "critical": contacts(LOPSIDED, friction=2, coefficient=0.4, roughness=0.1, critical_load=0.02),
    "secant": contacts(LOPSIDED, tangential_law="secant"),
    "gap": contacts(LOPSIDED, tension_law="gap"),
    "gap-bubble": contacts(LOPSIDED, tension_law="gap", surface=1, surface_tension=0.7),
    "cavitating": contacts(PAPER, tension_law="cavitation", cavitation_pressure=0.2),
    "dlvo": contacts(PAPER, remote=2, hamaker=0.01, layer_strength=0.3, debye_length=0.05),
}
PLACES = {"layer": (np.array([1.31, 1.1]), np.array([1.0, 0.93])),
          "stretched": (np.array([1.5, 1.1]), np.array([1.0, 0.83])),
          "space": (np.array([1.0, 1.1, 0.9]), np.array([1.0, 0.98, 0.85])),
          "space-without-shear": (np.array([1.0, 0.9, 1.1]), np.array([1.0, 0.9, 1.1]))}  # fmt: skip
each_place = pytest.mark.parametrize(("between", "direction"), PLACES.values(), ids=PLACES)
# Without shear the elastohydrodynamic law has no slope that differences of 1e-6 could find.
SMOOTH = {
    f"{way}-{place}": (WAYS[way], *PLACES[place])
    for way, place in itertools.product(WAYS, PLACES)
    if not (place == "space-without-shear" and WAYS[way].interface == code_of(INTERFACES, "elastohydrodynamic"))
}
GAP = math.log(0.06)
SPAN = 0.4


def settled(given, between, start, span):
    """A contact solved over a span by Newton's method alone, at a place that is held."""
    log_gap, direction = float(start[0][0]), start[1][0].copy()
    for _ in range(40):
        found = one_contact(given, between, log_gap, direction[: len(between)], span, start)
        log_gap += found.shift[0, 0]
        direction = direction + found.shift[0, 1:]
        direction /= np.linalg.norm(direction)
    assert np.abs(found.shift).max() < 1e-13
    return found, log_gap, direction


def begun(direction):
    n = np.zeros((1, 3))
    n[0, : len(direction)] = direction / np.linalg.norm(direction)
    return np.array([GAP]), n


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("given", "between", "direction"), SMOOTH.values(), ids=SMOOTH)
@pytest.mark.parametrize("span", [0.0, SPAN, 5.0])
def test_stiffness_and_response_are_slopes_over_the_displacement(given, between, direction, span):
    start = begun(direction)
    at, _, _ = settled(given, between, start, span)
    size = len(between)
    for k, step in enumerate(1e-6 * np.eye(size)):
        there, back = (settled(given, between + sign * step, start, span) for sign in (1, -1))
        force = (there[0].force - back[0].force)[0] / 2e-6
        assert at.stiffness[0][:size, k] == pytest.approx(force[:size], rel=2e-6, abs=1e-7)
        assert at.response[0, 0, k] == pytest.approx((there[1] - back[1]) / 2e-6, rel=2e-6, abs=1e-7)
        turn = (there[2] - back[2])[:size] / 2e-6
        assert at.response[0, 1 : 1 + size, k] == pytest.approx(turn, rel=2e-6, abs=1e-7)


@each_place
def test_a_solved_contact_has_moved_by_its_own_rate(between, direction):
    start = begun(direction)
    found, log_gap, n = settled(WAYS["lopsided"], between, start, SPAN)
    assert log_gap - GAP == pytest.approx(SPAN * found.slope[0, 0], rel=1e-10)
    turned = start[1][0] + SPAN * found.slope[0, 1:]
    assert n == pytest.approx(turned / np.linalg.norm(turned), rel=1e-10)


def test_tension_opens_compression_closes_and_shear_turns_the_film_after_the_centers():
    along = np.array([1.0, 0.0])
    opening, closing = (one_contact(WAYS["paper"], np.array([x, 0.0]), GAP, along, 0.0) for x in (1.8, 1.7))
    assert opening.force[0, 0] > 0 < opening.slope[0, 0]
    assert closing.force[0, 0] < 0 > closing.slope[0, 0]
    sheared = one_contact(WAYS["paper"], np.array([1.76, 0.02]), GAP, along, 0.0)
    assert sheared.force[0, 1] > 0 < sheared.slope[0, 2]


def test_a_rotated_contact_answers_with_a_rotated_force():
    between, direction = PLACES["layer"]
    turn = np.array([[math.cos(1.0), -math.sin(1.0)], [math.sin(1.0), math.cos(1.0)]])
    one = one_contact(WAYS["lopsided"], between, GAP, direction, SPAN)
    other = one_contact(WAYS["lopsided"], turn @ between, GAP, turn @ direction, SPAN)
    assert other.force[0, :2] == pytest.approx(turn @ one.force[0, :2], rel=1e-12)
    assert other.stiffness[0][:2, :2] == pytest.approx(turn @ one.stiffness[0][:2, :2] @ turn.T, rel=1e-10)


@pytest.mark.parametrize("name", SCHEMES)
def test_a_scheme_has_the_order_it_claims_and_damps_what_is_stiff(name):
    scheme = SCHEMES[name].tableau
    whole = scheme.rows + scheme.diagonal * np.diag([0.0] + [1.0] * (len(scheme.times) - 1))
    b, c = whole[-1], scheme.times
    sums = {2: [(b @ c, 1 / 2)]}
    sums[4] = [*sums[2], (b @ c**2, 1 / 3), (b @ whole @ c, 1 / 6), (b @ c**3, 1 / 4), ((b * c) @ whole @ c, 1 / 8),
               (b @ whole @ c**2, 1 / 12), (b @ whole @ whole @ c, 1 / 24)]  # fmt: skip
    for found, wanted in [(b.sum(), 1.0), *sums[scheme.order]]:
        assert found == pytest.approx(wanted, abs=1e-14)
    for z in (-1e8, -1e8j, -3.0 + 40j):
        growth = 1 + z * b @ np.linalg.solve(np.eye(len(c)) - z * whole, np.ones(len(c)))
        assert abs(growth) < (1e-5 if abs(z) > 1e6 else 1.0)
