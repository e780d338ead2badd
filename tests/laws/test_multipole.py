"""Many bodies on one surface: limits, symmetries, conservation laws, and the walls around them."""

import math

import numpy as np
import pytest
from scipy.special import k0, k1

from ecume.errors import BadInput, FloaterSinks
from ecume.laws import contact_lines, flotation, multipole
from ecume.laws.multipole.closures import excess_tilt, righted
from ecume.laws.multipole.many import images
from ecume.laws.multipole.solving import make_rims

pytestmark = pytest.mark.sampled(2)

# Capillary length 1 m, surface tension 1 N/m.
LIQUID = flotation.Liquid(density=1000.0, surface_tension=1.0, viscosity=1e-3, gravity=1e-3)
WATER = flotation.Liquid(1000.0, 0.0728, 1e-3)
BALL = flotation.Sphere(1e-3, 1300.0, 1.4)
STEEL = flotation.Sphere(2e-3, 7800.0, 1.4)
DISC = flotation.Disc(0.5, 0.1)
CROWD = [
    DISC,
    flotation.Disc(0.3, -0.05, tilting=False),
    flotation.Sphere(0.4, 1500.0, 1.2),
    multipole.Undulated(flotation.Disc(0.4, 0.02, stability=0.01), ((2, 0.02, 0.3), (3, 0.01, 1.1))),
    righted(flotation.Disc(0.3, 0.04, stability=0.1), LIQUID),
]
PLACES = np.array([[0.0, 0.0], [1.2, 0.3], [0.4, 1.3], [-1.0, 0.9], [0.9, -0.6]])


def charge(disc):
    a = disc.radius
    return disc.load / (math.pi * a * a * k0(a) + 2.0 * math.pi * a * k1(a))


def pair(body, apart, order=20, **options):
    return multipole.solve([[0.0, 0.0], [apart, 0.0]], [body, body], LIQUID, order, **options)


def test_far_apart_two_bodies_pull_as_superposition_says():
    expected = 2.0 * math.pi * charge(DISC) ** 2 * k1(14.0)
    assert pair(DISC, 14.0).forces[0, 0] == pytest.approx(expected, rel=1e-6)


def test_one_alone_sits_as_deep_as_its_charge_says_and_feels_nothing():
    found = multipole.solve([[0.3, -0.2]], [DISC], LIQUID)
    assert found.heights[0] == pytest.approx(-charge(DISC) * k0(0.5), rel=1e-13)
    assert found.energy == pytest.approx(0.5 * DISC.load * found.heights[0], rel=1e-13)
    assert not found.forces.any()
    assert not found.tilts.any()


def test_a_neutral_body_is_drawn_to_a_loaded_one_by_what_that_makes_of_it():
    disc = flotation.Disc(0.1, 0.01)
    sphere, neutral = (flotation.Sphere(0.1, density, math.pi / 2) for density in (1500.0, 500.0))
    lone = charge(disc) ** 2 * 2.0 * math.pi * k1(0.204)
    tilting = multipole.solve([[0.0, 0.0], [0.204, 0.0]], [disc, flotation.Disc(0.1, 0.0)], LIQUID, 40).forces[0, 0]
    level = flotation.Disc(0.1, 0.0, tilting=False)
    stiff = multipole.solve([[0.0, 0.0], [0.204, 0.0]], [disc, level], LIQUID, 40).forces[0, 0]
    assert tilting / lone == pytest.approx(0.17, abs=0.005)
    assert stiff < 0.0  # it stiffens the surface, and is pushed away
    weight = flotation.closed_form_charge(0.01, 1.5, math.pi / 2) * 0.1
    found = multipole.solve([[0.0, 0.0], [0.204, 0.0]], [sphere, neutral], LIQUID, 40).forces[0, 0]
    assert found / (2.0 * math.pi * weight**2 * k1(0.204)) == pytest.approx(0.037, abs=0.002)


def test_leaning_is_towards_the_neighbor_and_weighs_in_the_energy():
    found = pair(DISC, 1.2)
    assert found.tilts[0, 0] < 0.0 < found.tilts[1, 0]
    assert found.tilts[:, 1] == pytest.approx(0.0, abs=1e-15)
    top_heavy = pair(flotation.Disc(0.5, 0.1, stability=0.2), 1.2)
    assert abs(top_heavy.tilts[0, 0]) > abs(found.tilts[0, 0])
    assert top_heavy.forces[0, 0] > found.forces[0, 0]


@pytest.mark.parametrize(
    "walls",
    [
        None,
        pytest.param(multipole.Basin(24.0, 23.0, 0.8), marks=pytest.mark.compiled),
        pytest.param(multipole.Dish(3.0, 0.8), marks=pytest.mark.compiled),
        pytest.param(multipole.Dish(3.0, pinned=True), marks=pytest.mark.compiled),
    ],
)
def test_forces_are_what_the_energy_falls_by(walls):
    found = multipole.solve(PLACES, CROWD, LIQUID, 6, walls=walls)
    fine = 1e-3
    for i, axis in ((0, 0), (2, 1), (3, 0)):
        step = np.zeros_like(PLACES)
        step[i, axis] = fine
        at = [multipole.solve(PLACES + k * step, CROWD, LIQUID, 6, walls=walls).energy for k in (-2, -1, 1, 2)]
        slope = (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * fine)
        assert found.forces[i, axis] == pytest.approx(-slope, rel=1e-8, abs=1e-10 * abs(found.forces).max())


def test_torques_are_what_the_energy_falls_by_when_a_body_turns():
    def turned(angle):
        undulated = multipole.Undulated(CROWD[3].disc, ((2, 0.02, 0.3 + angle), (3, 0.01, 1.1 + angle)))
        bodies = [*CROWD[:3], undulated, CROWD[4]]
        return multipole.solve(PLACES, bodies, LIQUID, 8)

    slope = (turned(1e-4).energy - turned(-1e-4).energy) / 2e-4
    found = turned(0.0)
    assert found.torques[3] == pytest.approx(-slope, rel=1e-6)
    assert found.torques[:3] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("order", [3, 20])
def test_forces_and_torques_balance_at_any_order(order):
    found = multipole.solve(PLACES, CROWD, LIQUID, order)
    size = np.abs(found.forces).sum()
    moments = PLACES[:, 0] * found.forces[:, 1] - PLACES[:, 1] * found.forces[:, 0] + found.torques
    assert np.abs(found.forces.sum(axis=0)).max() < 1e-12 * size
    assert abs(moments.sum()) < 1e-12 * size


def leaning(load, stability=0.0, radius=1e-3, right=True):
    """The tilt of a disc beside a large one, over the slope of the surface that the large one alone has there."""
    small = flotation.Disc(radius, load, stability=stability)
    beside, at = righted(small, LIQUID) if right else small, [0.9, 0.0]
    found = multipole.solve([[0.0, 0.0], at], [DISC, beside], LIQUID, 8)
    alone = multipole.solve([[0.0, 0.0]], [DISC], LIQUID, 8)
    left, right_of_it = multipole.height(alone, [0.9 - 1e-4, 0.9 + 1e-4], [0.0, 0.0])
    return found.tilts[1, 0] / ((right_of_it - left) / 2e-4)


def test_a_small_disc_without_mass_lies_in_the_surface_when_the_tension_rights_it():
    """By symmetry: it is a piece of the surface, and the moment of its own tension is what keeps it there."""
    assert leaning(0.0) == pytest.approx(1.0, abs=1e-5)
    assert leaning(0.0, right=False) == pytest.approx(2.0, abs=1e-4)
    assert leaning(1e-7) == pytest.approx(1.0, abs=1e-3)


def test_the_moment_of_the_tension_is_pi_gamma_square_of_radius_times_the_tilt():
    """A stability of pi a^2 undoes it; one of pi a^2 or more above that topples small discs only without it."""
    undone = leaning(0.0, stability=math.pi * 1e-6)
    assert undone == pytest.approx(leaning(0.0, right=False), rel=1e-6)
    with pytest.raises(BadInput, match="topples"):
        leaning(0.0, stability=1.001 * math.pi * 1e-6, right=False)
    assert leaning(0.0, stability=1.001 * math.pi * 1e-6) == pytest.approx(2.0, rel=2e-3)


def test_large_discs_hardly_feel_the_moment_of_the_tension():
    excess = [excess_tilt(flotation.Disc(a, 0.1), LIQUID) for a in (0.01, 0.5, 1.0, 4.0, 20.0)]
    assert excess == sorted(excess, reverse=True)
    assert excess[0] == pytest.approx(1.0, abs=1e-3)
    assert excess[-1] == pytest.approx(2.0 / (2.0 * 20.0 + 0.5 * 20.0**2), rel=0.02)  # where K_1'/K_1 is near -1


def test_rafts_of_small_righted_discs_pull_as_superposition_says():
    """Seven touching ones; 5.8 times as strongly without the moment [capillary.md, section 2]."""
    around = [(math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)) for k in range(6)]
    places, small = 0.204 * np.array([(0.0, 0.0), *around]), flotation.Disc(0.1, 0.01)
    apart = 0.204 * np.array([1.0, 1.0, math.sqrt(3.0), math.sqrt(3.0), 2.0, 1.0])
    cosine = np.array([0.5, 0.5, 0.5 * math.sqrt(3.0), 0.5 * math.sqrt(3.0), 1.0, 1.0])
    expected = 2.0 * math.pi * charge(small) ** 2 * float((k1(apart) * cosine).sum())
    pulls = [
        -multipole.solve(places, [one] * 7, LIQUID, 12).forces[1, 0] / expected
        for one in (small, righted(small, LIQUID))
    ]
    assert pulls == pytest.approx([5.753, 0.992], abs=2e-3)


def test_errors_fall_exponentially_with_the_order():
    exact = pair(DISC, 1.2, 60).forces[0, 0]
    for order, most in ((4, 2e-4), (8, 2e-6), (12, 3e-8), (16, 2e-10), (24, 1e-14)):
        assert abs(pair(DISC, 1.2, order).forces[0, 0] / exact - 1.0) < most


def test_turning_and_relabeling_bodies_turns_and_relabels_their_forces():
    crowd = [*CROWD[:3], DISC, CROWD[4]]
    found = multipole.solve(PLACES, crowd, LIQUID, 10)
    c, s = math.cos(0.7), math.sin(0.7)
    turn = np.array([[c, s], [-s, c]])
    order = [2, 0, 3, 1, 4]
    bodies = [crowd[k] for k in order]
    again = multipole.solve(PLACES[order] @ turn + [0.3, -2.0], bodies, LIQUID, 10)
    assert again.forces == pytest.approx(found.forces[order] @ turn, rel=1e-11, abs=1e-15)
    assert again.tilts == pytest.approx(found.tilts[order] @ turn, rel=1e-11, abs=1e-15)
    assert again.energy == pytest.approx(found.energy, rel=1e-12)


@pytest.mark.long
@pytest.mark.compiled
def test_iteration_finds_what_elimination_finds_and_leaves_it_as_it_is():
    places = 1.03 * np.array([(i + 0.5 * j, j * math.sqrt(0.75)) for i in range(4) for j in range(3)])
    walls = multipole.Dish(7.0, 1.0)
    dense = multipole.solve(places, [DISC] * 12, LIQUID, 8, walls=walls, method="dense")
    found = multipole.solve(places, [DISC] * 12, LIQUID, 8, walls=walls, method="iterative")
    assert found.iterations > 0 == dense.iterations
    assert found.forces == pytest.approx(dense.forces, rel=1e-9, abs=1e-14)
    again = multipole.solve(places, [DISC] * 12, LIQUID, 8, walls=walls, method="iterative", start=found.amplitudes)
    assert again.iterations == 0
    assert np.array_equal(again.forces, found.forces)


@pytest.mark.parametrize("pinned", [False, True])
def test_a_wall_that_keeps_its_angle_attracts_and_one_that_pins_repels_whatever_the_sign(pinned):
    for load in (0.001, -0.001):
        disc = flotation.Disc(0.01, load)
        expected = 2.0 * math.pi * charge(disc) ** 2 * k1(2.0)
        flat = multipole.solve([[29.0, 0.0]], [disc], LIQUID, 3, walls=multipole.Basin(60.0, 60.0, pinned=pinned))
        curved = multipole.solve([[29.0, 0.0]], [disc], LIQUID, 3, walls=multipole.Dish(30.0, pinned=pinned))
        sign = -1.0 if pinned else 1.0
        assert flat.forces[0, 0] == pytest.approx(sign * expected, rel=1e-3)
        assert curved.forces[0, 0] == pytest.approx(sign * expected, rel=0.05)


@pytest.mark.parametrize(
    ("brim", "inwards", "fixed", "pinned"),
    [(20.0, 0.5, 3.87359612761, -3.78581433183), (5.0, 1.0, 1.03973873087, -0.913502066342)],
)
def test_a_point_near_a_round_wall_feels_its_published_image(brim, inwards, fixed, pinned):
    disc = flotation.Disc(1e-3, 0.001, tilting=False)
    at = [(brim - inwards) * np.array([0.6, 0.8])]
    for held, expected in ((False, fixed), (True, pinned)):
        found = multipole.solve(at, [disc], LIQUID, 2, walls=multipole.Dish(brim, pinned=held))
        assert found.forces[0] @ [0.6, 0.8] / charge(disc) ** 2 == pytest.approx(expected, rel=3e-6)


@pytest.mark.parametrize(
    "walls",
    [
        pytest.param(multipole.Basin(6.0, 24.0), marks=pytest.mark.compiled),
        multipole.Dish(3.0),
        pytest.param(multipole.Dish(3.0, pinned=True), marks=pytest.mark.compiled),
    ],
)
def test_the_surface_meets_walls_and_rims_as_it_should(walls):
    found = multipole.solve(PLACES, CROWD, LIQUID, 16, walls=walls)
    angle = np.linspace(0.0, 2.0 * math.pi, 9)
    ring = multipole.height(found, 0.5000001 * np.cos(angle), 0.5000001 * np.sin(angle))
    plane = found.heights[0] + 0.5 * (found.tilts[0, 0] * np.cos(angle) + found.tilts[0, 1] * np.sin(angle))
    assert ring == pytest.approx(plane, rel=1e-4)
    near = multipole.height(found, np.array([2.5, 2.9998, 3.0]), np.zeros(3))
    if walls.pinned:
        assert abs(near[2]) < 1e-6 * abs(near[0])
    else:
        assert abs(near[2] - near[1]) / 2e-4 < 1e-3 * abs(near[0])


@pytest.mark.compiled
def test_high_orders_and_small_or_large_bodies_do_not_overflow():
    for radius in (1e-4, 5.0, 60.0):
        found = pair(flotation.Disc(radius, 1e-6), 2.1 * radius, 90)
        assert np.isfinite(found.forces).all()
        assert found.forces[0, 0] > 0.0
        assert found.forces[0, 0] == pytest.approx(
            pair(flotation.Disc(radius, 1e-6), 2.1 * radius, 40).forces[0, 0], rel=1e-5
        )


def test_images_of_a_basin_are_each_other_s_mirrors():
    mirrors = images(multipole.Basin(80.0, 70.0, pinned=True), LIQUID)
    assert len(mirrors) == 9
    assert mirrors[0].tolist() == [1.0, 0.0, 1.0, 0.0, 1.0]
    assert mirrors[:, 4] == pytest.approx(mirrors[:, 0] * mirrors[:, 2])


def test_what_cannot_be_solved_is_refused_with_a_way_out():
    with pytest.raises(BadInput, match="overlap by"):
        pair(DISC, 0.9)
    with pytest.raises(BadInput, match="order is 0"):
        pair(DISC, 2.0, 0)
    with pytest.raises(BadInput, match="topples; its surface holds it upright below"):
        pair(flotation.Disc(0.5, 0.1, stability=5.0), 2.0)
    with pytest.raises(BadInput, match="shape"):
        multipole.solve([0.0, 0.0], [DISC], LIQUID)
    with pytest.raises(BadInput, match="multipoles: got 'cork'; expected one of"):
        multipole.solve([[0.0, 0.0]], ["cork"], LIQUID)
    with pytest.raises(BadInput, match="into a wall"):
        multipole.solve([[1.8, 0.0]], [DISC], LIQUID, walls=multipole.Dish(2.0))
    with pytest.raises(BadInput, match="got method 'guess'"):
        pair(DISC, 2.0, method="guess")
    with pytest.raises(BadInput, match="mode of an undulated rim"):
        multipole.Undulated(DISC, ((1, 0.1, 0.0),))


def test_quadrupoles_pull_tip_to_tip_and_turn_until_they_are():
    strength = contact_lines.quadrupole_strength(1.0, 1e-3, 1e-3)
    assert contact_lines.quadrupole_force(1.0, 0.0, strength) < 0.0
    assert contact_lines.quadrupole_force(1.0, math.pi / 2, strength) > 0.0
    fine = 1e-5
    for law, given in (("force", (1.3, 0.4)), ("torque", (1.3, 0.4))):
        ahead = [given[0] + (law == "force") * k * fine for k in (1, -1)]
        turned = [given[1] + (law == "torque") * k * fine for k in (1, -1)]
        slope = (
            contact_lines.quadrupole_energy(ahead[0], turned[0], strength)
            - contact_lines.quadrupole_energy(ahead[1], turned[1], strength)
        ) / (2 * fine)
        found = getattr(contact_lines, f"quadrupole_{law}")(*given, strength)
        assert found == pytest.approx(-slope, rel=1e-8)


def test_bodies_far_away_in_order_are_left_out_of_a_pair_alike_for_both():
    rims = make_rims([multipole.CLOSURES[flotation.Disc](DISC, LIQUID, 20)] * 2, 45.0)
    assert rims.straight.shape == (22, 21)
    found = pair(DISC, 20.0, 20)
    assert found.forces[0, 0] == -found.forces[1, 0]


@pytest.mark.parametrize("angles", [(0.0, 0.0), (math.pi / 2, math.pi / 2)])
def test_polarization_weakens_touching_quadrupoles_by_the_documented_share(angles):
    """Against the law of two rims that do not respond; the same whichever parts of them touch."""
    radius, height = 0.004, 0.0004  # of a capillary length
    disc = flotation.Disc(radius, 0.0)
    rims = [multipole.Undulated(disc, ((2, height, angle),)) for angle in angles]
    shares = []
    for distance in (2.0002 * radius, 4.0 * radius):
        near, far = (
            multipole.solve([[0.0, 0.0], [apart, 0.0]], rims, LIQUID, 16) for apart in (distance, 200.0 * radius)
        )
        law = -12.0 * math.pi * height**2 * radius**4 / distance**4
        shares += [(near.energy - far.energy) / law, near.forces[0, 0] * distance / (-4.0 * law)]
    assert shares == pytest.approx([0.85, 0.61, 1.03, 1.036], abs=0.005)


def test_multipoles_refuse_bodies_that_sink_or_overlap():
    with pytest.raises(FloaterSinks):
        multipole.solve([[0.0, 0.0], [5e-3, 0.0]], [STEEL, STEEL], WATER)
    wetted = flotation.Sphere(1e-3, 900.0, 0.3)  # its contact line is far inside
    with pytest.raises(BadInput, match=r"bodies 0 and 1 overlap by 200 µm"):
        multipole.solve([[0.0, 0.0], [1.8e-3, 0.0]], [wetted, wetted], WATER)
    assert np.isfinite(multipole.solve([[0.0, 0.0], [2e-3, 0.0]], [wetted, wetted], WATER).forces).all()


def test_multipoles_take_numpy_integers_and_refuse_what_is_no_place():
    apart = [[0.0, 0.0], [3e-3, 0.0]]
    one, other = (multipole.solve(apart, [BALL, BALL], WATER, order).forces for order in (6, np.int64(6)))
    assert (one == other).all()
    for order in (6.0, "6", None, 0):
        with pytest.raises(BadInput, match="the order is"):
            multipole.solve(apart, [BALL, BALL], WATER, order)
    for places in ("here", [[0.0, 0.0], None], [[0.0, math.nan], [1.0, 0.0]]):
        with pytest.raises(BadInput, match="positions"):
            multipole.solve(places, [BALL, BALL], WATER)


@pytest.mark.parametrize("degrees", [10.0, 60.0, 100.0, 150.0])
def test_the_multipoles_of_a_cylinder_have_its_charge(degrees):
    """Far away the force is that of two charges, for a thin cylinder at any slope of the surface."""
    radius, length = 1e-6, WATER.capillary_length
    rod = flotation.VerticalCylinder(radius, 5e-3, 990.0, math.radians(degrees))
    charge = -radius * math.cos(math.radians(degrees))  # 2 pi gamma R sin(psi) over 2 pi gamma
    found = multipole.solve([[0.0, 0.0], [length, 0.0]], [rod, rod], WATER).forces[0, 0]
    expected = 2.0 * math.pi * WATER.surface_tension * charge**2 / length * 0.601907230197  # K1(1)
    assert found == pytest.approx(expected, rel=1e-4)
    assert multipole.closures.cylinder_closure(rod, WATER, 2).source[0].real != 0.0
