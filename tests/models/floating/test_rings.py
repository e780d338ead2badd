"""Ring-shaped dishes: the meniscus between two round walls, contacts with both, and what is refused."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from ecume.analysis.structure import lens, pair_distribution, region_in
from ecume.engine.walls import rings, surfaces
from ecume.errors import BadInput, SceneError
from ecume.laws.flotation import Liquid
from ecume.laws.meniscus import dish_height, wall_amplitude
from ecume.laws.ring_meniscus import inner_wall_amplitude, ring_amplitudes, ring_height
from ecume.models import MODELS
from ecume.models.floating.dishes import field_of, wall_stiffness, walls_of
from ecume.models.floating.forces.pair_forces import add_wall_forces
from ecume.show.play.bowl import Bowl
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
LIQUID = Liquid(density=1000.0, surface_tension=0.0728, viscosity=1e-3)
LENGTH = LIQUID.capillary_length
FLOAT = "[[particles]]\nradius = 1e-3\ndensity = 600.0\ncontact_angle = 1.2\n"


def ring(keys="", *, floats="count = 12\n", body="", **times):
    """Floats in a ring of 20 mm around an inner wall of 5 mm."""
    dish = f"[dish]\nradius = 0.02\ninner_radius = 0.005\n{keys}\n"
    return scene_of(f"{WATER}{FLOAT}{floats}{dish}{body}\n", **times)


def at(places):
    return f"positions = {[list(map(float, place)) for place in places]}\n"


def forces_in(scene, places):
    """The forces of the walls on the only float of a scene at several places."""
    parameters, found = FLOATING.parameters(scene), np.zeros((len(places), 1, 2))
    for place, force in zip(np.array(places, dtype=float), found, strict=True):
        add_wall_forces(parameters, place[None], force)
    return found[:, 0]


@pytest.mark.parametrize("angles", [(0.9, 0.9), (1.3, 1.9), (2.2, 1.0)])
@pytest.mark.parametrize("radii", [(8.0, 2.0), (6.0, 0.5)])
def test_far_from_the_walls_the_surface_is_the_exact_one(radii, angles):
    """Young's and Laplace's equation between both walls, by collocation: heights in the middle agree to 3 % of the
    largest there.
    """
    (a, b), (outer, inner) = radii, angles

    def growth(r, y):
        return np.stack([np.tan(y[1]), (y[0] - np.sin(y[1]) / r) / np.cos(y[1])])

    def ends(left, right):
        return np.array([left[1] - (inner - 0.5 * math.pi), right[1] - (0.5 * math.pi - outer)])

    r = np.linspace(b, a, 400)
    exact = solve_bvp(growth, ends, r, np.zeros((2, len(r))), tol=1e-8, max_nodes=50_000)
    assert exact.success
    middle = np.linspace(b + 0.35 * (a - b), a - 0.35 * (a - b), 9)
    found = np.asarray(ring_height(middle * LENGTH, (a * LENGTH, b * LENGTH), angles, LIQUID)) / LENGTH
    assert found == pytest.approx(exact.sol(middle)[0], abs=0.03 * np.abs(exact.sol(middle)[0]).max())


def test_the_slopes_at_both_walls_are_those_of_each_wall_alone():
    radii, angles, fine = (0.012, 0.008), (0.8, 2.0), 1e-8
    for wall, way, amplitude in (
        (radii[0], -1.0, wall_amplitude(0.8, LIQUID)), (radii[1], 1.0, inner_wall_amplitude(radii[1], 2.0, LIQUID))
    ):  # fmt: skip
        heights = [float(ring_height(wall + way * step * fine, radii, angles, LIQUID)) for step in (0.0, 1.0)]
        assert (heights[0] - heights[1]) / fine == pytest.approx(amplitude / LENGTH, rel=1e-4)


def test_an_inner_wall_that_vanishes_leaves_a_round_dish():
    r = np.linspace(0.004, 0.02, 5)
    for radius in (1e-4, 1e-6):
        found = ring_height(r, (0.02, radius), (0.8, 0.8), LIQUID)
        assert found == pytest.approx(np.asarray(dish_height(r, 0.02, 0.8, LIQUID)), rel=1e-9, abs=0.2 * radius)
    outer, inner = ring_amplitudes((0.02, 1e-6), (0.8, 0.8), LIQUID)
    assert outer == pytest.approx(wall_amplitude(0.8, LIQUID), rel=1e-3)
    assert inner == pytest.approx(LENGTH * math.cos(0.8), rel=1e-3)


def test_a_narrow_ring_of_large_radii_is_a_gap_between_two_planes():
    width, far = 0.006, 2.0
    found = ring_height(np.linspace(far, far + width, 4), (far + width, far), (0.8, 0.8), LIQUID)
    x = np.linspace(0.0, width, 4)
    alone = wall_amplitude(0.8, LIQUID)
    planes = alone / math.sinh(0.5 * width / LENGTH) * np.cosh((x - 0.5 * width) / LENGTH)
    assert found == pytest.approx(planes, rel=2e-3)


@pytest.mark.parametrize("seed", range(4))
def test_random_rings_push_floats_along_the_radius_down_the_slope_of_the_height(seed):
    rng = np.random.default_rng(seed)
    radius, inner = rng.uniform(0.015, 0.03), rng.uniform(0.0005, 0.01)
    keys = f"radius = {radius}\ninner_radius = {inner}\ncontact_angle = {rng.uniform(0.3, 2.8)}\n"
    keys += f"inner_contact_angle = {rng.uniform(0.3, 2.8)}\n"
    r, phi = rng.uniform(inner + 1.1e-3, radius - 1.1e-3, 6), rng.uniform(0.0, 6.0, 6)
    unit = np.stack([np.cos(phi), np.sin(phi)], axis=1)
    places = r[:, None] * unit
    scene = scene_of(f"{WATER}{FLOAT}{at(places[:1])}[dish]\n{keys}")
    charge, fine = float(FLOATING.parameters(scene).floats.charge[0]), 1e-7
    for force, direction, distance in zip(forces_in(scene, places), unit, r, strict=True):
        near = [field_height(scene, distance + way * fine) for way in (1.0, -1.0)]
        slope = (near[0] - near[1]) / (2.0 * fine)
        expected = -2.0 * math.pi * LIQUID.surface_tension * charge * slope * direction
        assert force == pytest.approx(expected, rel=1e-5, abs=1e-15)


def field_height(scene, r):
    dish = scene.dish
    angles = dish.contact_angle, dish.inner_contact_angle
    return float(ring_height(r, (dish.radius, dish.inner_radius), angles, LIQUID))


def test_pictures_have_the_height_of_the_ring():
    scene = ring("inner_contact_angle = 2.0")
    x = np.array([0.006, 0.012, 0.019])
    shown = field_of(scene.dish, LIQUID, x, np.array([0.0]))[0]
    expected = ring_height(x, (0.02, 0.005), (math.pi / 4.0, 2.0), LIQUID)
    assert shown == pytest.approx(np.asarray(expected), rel=1e-3, abs=1e-9)


def test_the_stiffness_bounds_the_slope_of_the_force():
    for inner in (0.0003, 0.004):
        scene = scene_of(f"{WATER}{FLOAT}{at([(0.01, 0.0)])}[dish]\nradius = 0.02\ninner_radius = {inner}\n")
        r = np.linspace(inner + 1e-3, 0.019, 400)
        slopes = np.gradient(forces_in(scene, np.stack([r, 0.0 * r], axis=1))[:, 0], r)
        bound = wall_stiffness(FLOATING.parameters(scene))
        assert 0.3 * bound < np.abs(slopes).max() < bound


@pytest.mark.long
@pytest.mark.compiled  # thousands of collisions
def test_elastic_floats_in_a_ring_keep_energy_and_touch_both_walls():
    rest = '[interaction]\nlaw = "none"\n[hydrodynamics]\ndrag = "none"\n[contacts]\nlaw = "none"\n'
    scene = ring('law = "none"\nrestitution = 1.0', floats="count = 20\nvelocity = [0.1, 0.04]\n", body=rest,
                 duration=2.0, frame_every=0.05)  # fmt: skip
    frames = list(simulate(scene))
    energy = [frame.numbers["kinetic_energy"] for frame in frames]
    assert energy == pytest.approx([energy[0]] * len(energy), rel=1e-9)
    r = np.hypot(*np.concatenate([frame.arrays["position"] for frame in frames]).T)
    assert 0.006 * (1.0 - 1e-3) < r.min() < 0.0065
    assert 0.0185 < r.max() < 0.019 * (1.0 + 1e-4)
    assert frames[-1].numbers["collisions"] > 0


@pytest.mark.parametrize("integration", ['integrator = "overdamped"', 'integrator = "velocity-verlet"'])
def test_a_float_between_two_walls_moves_down_in_energy_to_the_wall_that_wets(integration):
    """Light floats climb the wetting inner wall, and leave the outer one, which does not wet."""
    scene = ring('contact_angle = "110 deg"\ninner_contact_angle = "30 deg"\nrestitution = 0.0',
                 floats=at([(0.0075, 0.0)]), body=f"[integration]\n{integration}\n", duration=0.4,
                 frame_every=0.04)  # fmt: skip
    frames = list(simulate(scene))
    assert np.hypot(*frames[-1].arrays["position"][0]) == pytest.approx(0.006, rel=1e-3)
    energy = [frame.numbers["total_energy"] for frame in frames]
    assert all(after <= before + 1e-15 for before, after in itertools.pairwise(energy))


@pytest.mark.long
@pytest.mark.compiled  # thousands of steps
def test_brownian_floats_stay_between_both_walls():
    body = '[hydrodynamics]\nbrownian = true\n[integration]\nintegrator = "overdamped"\n[contacts]\nlaw = "none"\n'
    text = f"{WATER}[[particles]]\nradius = 1e-6\ndensity = 1100.0\ncontact_angle = 1.2\ncount = 8\n[dish]\n"
    text += f'radius = 6e-6\ninner_radius = 2e-6\nlaw = "none"\n[interaction]\nlaw = "none"\n{body}'
    frames = list(simulate(scene_of(text, duration=1.0, frame_every=0.1)))
    r = np.concatenate([np.hypot(*frame.arrays["position"].T) for frame in frames])
    assert r.min() > 3e-6 * (1.0 - 1e-3)
    assert r.max() < 5e-6 * (1.0 + 1e-3)
    assert r[8:].mean() == pytest.approx(4.083e-6, rel=0.06)  # uniform over the area


def test_the_area_and_the_bounds_of_a_ring():
    walls = walls_of(ring().dish)
    assert rings.area(walls) == pytest.approx(math.pi * (0.02**2 - 0.005**2))
    assert rings.bounds(walls) == ((-0.02, -0.02), (0.02, 0.02))
    assert rings.inner_radius_of(rings.shrunk(walls, 1e-3)) == pytest.approx(0.006)
    box = surfaces.enclosed_by(surfaces.box((-1.0, -2.0), (1.0, 2.0)))
    assert rings.outer_walls(rings.ring(box, 0.5)).offset.tolist() == box.offset.tolist()
    with pytest.raises(BadInput, match="expected one between 0 and 1 m"):
        rings.ring(box, 1.5)


def test_random_points_in_a_ring_have_a_pair_distribution_of_one():
    region = region_in(walls_of(ring().dish))
    rng = np.random.default_rng(2)
    r, phi = np.sqrt(rng.uniform(0.005**2, 0.02**2, (60, 200))), rng.uniform(0.0, 2.0 * np.pi, (60, 200))
    frames = [
        Frame(0.0, {"position": np.stack([a * np.cos(b), a * np.sin(b)], axis=1)}, {}, {})
        for a, b in zip(r, phi, strict=True)
    ]
    edges = np.linspace(0.0, 0.04, 9)
    assert pair_distribution(frames, edges, region)[:-1] == pytest.approx(np.ones(7), abs=0.02)
    assert float(lens(np.array(0.0), 2.0, 1.0)) == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("keys", "body", "why"),
    [
        ("image = 'pinned'", "", "got 'pinned' in a ring"),
        ("law = 'profile'", "", "'profile', which is not known"),
        ("tilt = { angle = 0.1 }", "", "got a tilted ring"),
        ("law = 'none'\nbarrier = { side = 'all', velocity = 0.001 }", "", "a barrier would run into it"),
        ("shape = 'round'", "", "got a dish of the shape 'round'"),
        ("", '[interaction]\nmethod = "multipole"\n', "multipole"),
        ("law = 'none'", FLOAT + 'shape = { kind = "needle", width = 5e-4 }\n', "bulges toward it"),
    ],
)  # fmt: skip
def test_what_is_not_known_in_a_ring_is_refused(keys, body, why):
    with pytest.raises((SceneError, BadInput), match=why):
        FLOATING.parameters(ring(keys, body=body))


def test_rings_without_an_inner_wall_that_fits_are_refused():
    for keys, why in (
        ("radius = 0.02\ninner_radius = 0.02", "less than the radius"),
        ("radius = 0.02\nshape = 'ring'", "inner_radius: is missing"),
        ("size = [0.03, 0.03]\ninner_radius = 0.01", "expected a ring, with radius"),
        ("radius = 0.02\ninner_contact_angle = 1.0", "expected inner_radius, too"),
    ):
        with pytest.raises(SceneError, match=why):
            scene_of(f"{WATER}{FLOAT}[dish]\n{keys}\n")
    with pytest.raises(SceneError, match="not inside the dish"):
        list(simulate(ring(floats=at([(0.0055, 0.0)]))))
    with pytest.raises(BadInput, match="got a ring"):
        Bowl(ring())


def test_check_states_the_width_of_the_channel():
    rows = {name: (value, remark) for name, value, remark in FLOATING.summary(ring())}
    assert rows["channel of the ring"] == ("15 mm", "5.51 capillary lengths: each wall has its own meniscus")
    bare = {name: remark for name, _, remark in FLOATING.summary(ring("law = 'none'"))}
    assert bare["channel of the ring"] == "5.51 capillary lengths: its walls have no menisci"


@pytest.mark.parametrize("seed", range(4))
def test_half_a_run_and_half_a_run_in_random_rings_and_tilted_dishes_are_a_run(seed):
    """Bit for bit. Walls around the origin without friction change no angular momentum, those of a tilted dish do."""
    rng = np.random.default_rng(seed)
    places = 0.011 * np.stack([np.cos(angles := np.array([0.1, 0.4, 2.0, 4.0])), np.sin(angles)], axis=1)
    keys = f"radius = 0.0125\ncontact_angle = {rng.uniform(0.9, 2.0)}\nrestitution = 0.5\n"
    inner = f"inner_radius = 0.0095\ninner_contact_angle = {rng.uniform(0.3, 2.8)}\n"
    tilt = f"tilt = {{ angle = {rng.uniform(0.1, 0.5)}, direction = {rng.uniform(-3.0, 3.0)} }}\n"
    integrator = ("velocity-verlet", "semi-implicit-euler")[seed // 2]
    body = f'[hydrodynamics]\ndrag = "none"\n[integration]\nintegrator = "{integrator}"\n'
    floats = f"{at(places)}velocity = [{rng.uniform(0.1, 0.3)}, {rng.uniform(-0.3, 0.3)}]\n"
    scene = scene_of(f"{WATER}{FLOAT}{floats}[dish]\n{keys}{tilt if seed % 2 else inner}{body}")
    parameters, ends, spins = FLOATING.parameters(scene), [], []
    for parts in ((60,), (37, 23)):
        state = FLOATING.start(scene, parameters)
        spins.append(spin_of(state))
        for steps in parts:
            assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), steps) == 0
        ends.append(np.concatenate([state.position, state.velocity]))
        spins.append(spin_of(state))
    assert np.array_equal(*ends)
    assert np.abs(ends[0][:4] - places).max() > 1e-3
    same = spins[1] == pytest.approx(spins[0], rel=1e-10)
    assert same == (seed % 2 == 0)


def spin_of(state):
    """The angular momentum of equal floats about the origin, over their mass."""
    (x, y), (u, v) = state.position.T, state.velocity.T
    return float(np.sum(x * v - y * u))
