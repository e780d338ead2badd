"""Surfaces of bubbles, mobile interfaces, and friction between rough surfaces."""

import inspect
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe, ellipk, jv

from ecume.laws.friction import holding_force, limit_slope, sliding_force, sliding_slope, touching, touching_power
from ecume.laws.interfaces import INTERFACES, drop_factor, drop_power, mobility
from ecume.laws.soft_pair import entrained_force, reduced_radius, shear_friction
from ecume.laws.surfaces import (
    Body,
    bubble_energy,
    bubble_force,
    bubble_gap_energy,
    bubble_stiffness,
    flattened,
    flattening_length,
    softness,
    stiffening,
)

PAIRS = {"equal": (2.0, 0.5), "unequal": (1.3, reduced_radius(0.4, 0.9)), "wall": (0.7, 0.7)}
each_pair = pytest.mark.parametrize("body", PAIRS.values(), ids=PAIRS)


def slope(function, at, by=1e-6):
    return (function(at * (1 + by)) - function(at * (1 - by))) / (2 * by * at)


@each_pair
@pytest.mark.parametrize("compression", [1e-6, 1e-3, 0.05, 0.4])
@pytest.mark.parametrize("film_area", [1e-9, 1e-3, 0.4])
def test_a_bubbles_force_is_the_slope_of_its_energy(body, film_area, compression):
    energy = slope(lambda x: bubble_energy(x, film_area, *body, 0.7), compression)
    force = bubble_force(compression, film_area, *body, 0.7)
    assert force == pytest.approx(energy, rel=1e-7)
    assert bubble_force(-compression, film_area, *body, 0.7) == -force
    assert bubble_energy(-compression, film_area, *body, 0.7) > 0.0


@each_pair
@pytest.mark.parametrize("compression", [-0.05, 0.4])
@pytest.mark.parametrize("film_area", [1e-3, 0.4])
def test_what_a_film_does_to_the_energy_of_a_held_bubble_is_its_slope(body, film_area, compression):
    by_area = slope(lambda area: bubble_energy(compression, area, *body, 0.7), film_area, 1e-4)
    assert bubble_gap_energy(compression, film_area, *body, 0.7) == pytest.approx(by_area * film_area, rel=1e-5)


@each_pair
def test_a_facet_bears_the_force_at_the_pressure_in_it(body):
    inside = {"equal": 2 * 0.7, "unequal": 0.7 * (1 / 0.4 + 1 / 0.9), "wall": 2 * 0.7 / 0.7}
    (name,) = (name for name, found in PAIRS.items() if found == body)
    force = bubble_force(0.02, 1e-4, *body, 0.7)
    assert force == pytest.approx(math.pi * flattened(0.02, 1e-4, *body) * inside[name], rel=1e-12)


def test_a_point_force_on_a_round_surface_gives_the_logarithm():
    """Laplace and Young's linear equation on a sphere, solved by harmonics: the referee of the constant -5/6."""
    small = 1e-2
    cosine = math.cos(small)
    before, now = 1.0, cosine
    center = edge = 0.0
    for order in range(2, 40_000):
        after = ((2 * order - 1) * cosine * now - (order - 1) * before) / order
        # The cap's moment of P_l: (P_(l-1) - P_(l+1))/(2l + 1) over its area.
        later = ((2 * order + 1) * cosine * after - order * now) / (order + 1)
        moment = (now - later) / (2 * order + 1) / (1 - cosine)
        part = (2 * order + 1) / (4 * math.pi) * moment / ((order - 1) * (order + 2))
        center, edge = center + part, edge + part * after
        before, now = now, after
    # The sphere lies lower at the edge of the cap: flat is what the force pi a^2 2 gamma/R makes of it.
    assert 2 * math.pi * small**2 * (center - edge) == pytest.approx(small**2 / 2, rel=1e-3)
    theory = softness(small**2, 1.0, 1.0) / (4 * math.pi)
    assert center == pytest.approx(theory, rel=1e-3)


@each_pair
def test_bubbles_grow_stiffer_with_every_push_and_softer_than_any_spring_without(body):
    forces = [bubble_force(x, 1e-12, *body, 1.0) for x in np.linspace(1e-4, 0.5, 60)]
    assert np.all(np.diff(forces, 2) > 0)
    secants = [bubble_stiffness(area, *body, 1.0) for area in (1e-4, 1e-8, 1e-16)]
    assert secants[0] > secants[1] > secants[2]
    area = 0.02
    assert stiffening(area, *body) == pytest.approx(-slope(lambda s: softness(s, *body), area) * area, rel=1e-8)


def test_no_force_deflects_bubbles_by_more_than_their_size():
    assert flattened(0.99 * math.exp(-5 / 6) * 4, 1e-3, 2.0, 0.5) > 10.0
    assert flattened(1.01 * math.exp(-5 / 6) * 4, 1e-3, 2.0, 0.5) == math.inf
    assert flattening_length(2.0, 0.5) * 1.0 == 2.0


PLACE = {"contact_size": 0.3, "gap": 0.02, "viscosity": 0.7, "viscosity_ratio": 0.3, "film_prefactors": (4.0, 3.0),
         "compression": 0.4, "slip_force": 0.02, "body": Body(1.7, 0.41, 3.0), "gap_weight": 1.2}  # fmt: skip


def film_at(name, **changes):
    law, given = INTERFACES[name], PLACE | changes
    return law(**{one: given[one] for one in inspect.signature(law).parameters})


@pytest.mark.parametrize("name", INTERFACES)
def test_frictions_change_by_their_stated_powers(name):
    film = film_at(name)
    slopes = [
        (kind, at, key) for kind in ("squeeze", "shear") for at, key in (("size", "contact_size"), ("gap", "gap"))
    ]
    for kind, at, key in [*slopes, ("shear", "force", "slip_force"), ("shear", "load", "compression")]:
        sides = (film_at(name, **{key: PLACE[key] * factor}) for factor in (1 + 1e-6, 1 - 1e-6))
        above, below = (math.log(getattr(side, kind)) for side in sides)
        scale = PLACE[key] if at == "load" else 1.0
        assert scale * getattr(film, f"{kind}_by_{at}") == pytest.approx((above - below) / 2e-6, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("force", [0.02, 3.0, 1e4])
def test_elastohydrodynamic_friction_bears_the_root_of_the_speed_beside_a_slight_linear_force(force):
    gap, linear = 1e-5, 1e-3 * shear_friction(0.3, 1e-5, 0.7, 3.0)
    speed = force / film_at("elastohydrodynamic", gap=gap, slip_force=force).shear
    flat = 1.0 - 2.0 * 0.41 * 1.2 * gap / 0.3**2
    assert entrained_force(speed, 0.4 * flat, 0.3, 0.7) + linear * speed == pytest.approx(force, rel=1e-8)
    apart = film_at("elastohydrodynamic", gap=gap, slip_force=force, compression=-0.1)
    assert apart.shear == pytest.approx(linear)


def test_drops_go_from_rigid_to_freely_slipping_with_their_viscosity():
    films = {name: film_at(name, gap=0.002, viscosity_ratio=1e6) for name in INTERFACES}
    assert films["drop"].squeeze == pytest.approx(films["rigid"].squeeze, rel=1e-3)
    assert films["drop"].shear == pytest.approx(films["rigid"].shear, rel=1e-3)
    assert films["half-mobile"].squeeze == pytest.approx(films["rigid"].squeeze / 4)
    thin = INTERFACES["drop"](0.3, 0.002, 0.7, 1e-9, (4.0, 3.0))
    assert thin.squeeze == pytest.approx(films["mobile"].squeeze, rel=1e-4)
    assert thin.shear < 1e-6 * films["rigid"].shear
    frictions = [INTERFACES["drop"](0.3, 0.002, 0.7, ratio, (4.0, 3.0)) for ratio in np.geomspace(1e-4, 1e4, 9)]
    assert np.all(np.diff([film.squeeze for film in frictions]) > 0)
    assert np.all(np.diff([film.shear for film in frictions]) > 0)
    assert drop_power(mobility(0.3, 0.002, 1.0)) < 0


def test_a_mobile_film_is_squeezed_by_the_power_that_it_spends():
    """A plug flow that widens: rates (1, 1, -2) e/2 in a disc, and power 3 eta e^2 per volume."""
    speed, gap, size, viscosity = 0.3, 0.01, 0.2, 0.7
    rate = speed / gap
    spent = 2 * viscosity * (rate**2 + 2 * (rate / 2) ** 2) * math.pi * size**2 * gap
    assert INTERFACES["mobile"](size, gap, viscosity, 1.0, (4.0, 3.0)).squeeze * speed**2 == pytest.approx(spent)


def test_a_film_with_one_free_surface_is_squeezed_with_a_quarter_of_the_friction():
    def flux(free):
        """The flux per pressure gradient over viscosity; the velocity profile starts at the lower surface."""
        return quad(lambda z: z * (1.0 - z / 2) if free else z * (1 - z) / 2, 0, 1)[0]

    films = [INTERFACES[name](0.2, 0.01, 1.0, 1.0, (4.0, 3.0)).squeeze for name in ("half-mobile", "rigid")]
    assert films[0] / films[1] == pytest.approx(flux(False) / flux(True))


@pytest.mark.parametrize("limit", [0.0, 1.0, 2.5])
def test_contact_friction_never_drives_and_holds_up_to_its_limit(limit):
    for pull in np.linspace(-4, 4, 81):
        borne = sliding_force(pull, limit)
        held = pull - borne
        assert held * borne >= 0.0
        assert abs(held) <= 1.01 * limit * (1 + 1e-12)
        assert borne == 0.0 or abs(pull) > limit
        assert borne == -sliding_force(-pull, limit)


@pytest.mark.parametrize("pull", [0.5, 1.001, 1.01, 1.019, 1.2, 3.0])
def test_the_sliding_force_has_its_stated_slopes(pull):
    assert sliding_slope(pull, 1.0) == pytest.approx(slope(lambda t: sliding_force(t, 1.0), pull), rel=1e-6)
    assert limit_slope(pull, 1.0) == pytest.approx(slope(lambda x: sliding_force(pull, x), 1.0), rel=1e-6)


def test_only_what_presses_close_by_holds():
    assert holding_force(3.0, 0.2, 0.4, 1.0) == pytest.approx(1.2)
    assert holding_force(-3.0, 0.2, 0.4, 1.0) == holding_force(3.0, 1.5, 0.4, 1.0) == 0.0
    for gap in (0.55, 0.7, 0.95):
        assert touching_power(gap, 1.0) == pytest.approx(gap * slope(lambda h: touching(h, 1.0), gap), rel=1e-6)


def solved_drop_factor(mobility, cells):
    """F(m), by solving film and drops together: the film drags the drops' surfaces along; x is in sqrt(2 R* h).

    H t + 3 sqrt(2) m int K(x, x') t(x') x' dx' = x/H with H = 1 + x^2; K is that of Stokes's flow in half of space,
    with Legendre's Q_1/2, which grows as a logarithm where x and x' meet: there its mean over the cell stands.
    """
    share = (np.arange(cells) + 0.5) / cells
    x, width = share / (1.0 - share), 1.0 / (cells * (1.0 - share) ** 2)
    chi = (x[:, None] ** 2 + x**2) / (2.0 * x[:, None] * x)
    np.fill_diagonal(chi, 2.0)
    legendre = chi * np.sqrt(2.0 / (chi + 1.0)) * ellipk(2.0 / (chi + 1.0))
    legendre -= np.sqrt(2.0 * (chi + 1.0)) * ellipe(2.0 / (chi + 1.0))
    np.fill_diagonal(legendre, np.log(16.0 * x / width) - 1.0)
    kernel, height = legendre / (math.pi * np.sqrt(x[:, None] * x)), 1.0 + x**2
    system = np.diag(height) + 3.0 * math.sqrt(2.0) * mobility * kernel * (x * width)
    return float((4.0 * x**2 / height * width * np.linalg.solve(system, x / height)).sum())


@pytest.mark.parametrize(("mobility", "error"), [(1e-3, 3e-5), (0.1, 1e-3), (1.0, 2e-3), (10.0, 0.02), (300.0, 0.02)])
def test_the_published_fit_for_drops_is_the_solution_of_film_and_drops(mobility, error):
    exact = 2.0 * solved_drop_factor(mobility, 160) - solved_drop_factor(mobility, 80)
    assert drop_factor(mobility) == pytest.approx(exact, rel=error)


def wave(order, off):
    """The integral of sin(k) J(k off)/k over all k."""
    near = quad(lambda k: jv(order, k * off) * math.sin(k) / k, 0.0, 1.0)[0]
    return near + quad(lambda k: jv(order, k * off) / k, 1.0, math.inf, weight="sin", wvar=1.0, limlst=500)[0]


def test_a_disc_that_moves_edgewise_on_half_of_space_is_held_by_sixteen_thirds():
    # The traction c/sqrt(a^2 - r^2): its transform over 2 pi is c sin(k a)/k, and its sum 2 pi c a. Along k a wave of
    # traction moves the surface by 1/(2 eta k), across k by 1/(eta k): three quarters of 1/(eta k) in the mean.
    for off in (0.0, 0.4, 0.8):
        spread, turned = (wave(order, off) for order in (0, 2))
        assert 2.0 * math.pi / (0.75 * spread) == pytest.approx(16.0 / 3.0, rel=1e-6)
        # What varies around the disc is of the second order, and there is none of it.
        assert turned == pytest.approx(0.0, abs=1e-6)
