"""Tilted dishes: the cut of the walls by the level surface, the menisci around them, and what is refused."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import i1, ivp

from ecume.engine.walls import surfaces
from ecume.errors import BadInput, SceneError
from ecume.laws.flotation import Liquid
from ecume.laws.meniscus import inclined_amplitude, plane_wall_height
from ecume.models import MODELS
from ecume.models.floating.dishes import field_of, walls_of
from ecume.models.floating.forces.pair_forces import add_wall_forces, sum_of_wall_energies
from ecume.show.play.bowl import Bowl
from ecume.simulation import simulate
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
LIQUID = Liquid(density=1000.0, surface_tension=0.0728, viscosity=1e-3)
LENGTH = LIQUID.capillary_length
PLACES = [(0.0, 0.0), (0.011, 0.002), (-0.004, 0.009), (0.001, -0.0109)]


def tilted(keys, tilt="", *, places=PLACES, body="", **times):
    """Light floats without mutual forces in a dish with this tilt."""
    floats = (
        f"[[particles]]\nradius = 1e-3\ndensity = 600.0\ncontact_angle = 1.2\npositions = {[list(p) for p in places]}\n"
    )
    more = f"[dish.tilt]\n{tilt}\n" if tilt else ""
    rest = f'[interaction]\nlaw = "none"\n{body}\n'
    return scene_of(f"{WATER}{floats}[dish]\ncontact_angle = 0.7\n{keys}\n{more}{rest}", **times)


def forces_in(scene, places=PLACES):
    found = np.zeros((len(places), 2))
    add_wall_forces(FLOATING.parameters(scene), np.array(places, dtype=float), found)
    return found


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points) @ np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("degrees", [-40.0, -15.0, 0.0, 20.0, 45.0])
@pytest.mark.parametrize("contact_angle", [0.75, 1.5, 2.3])
def test_the_profile_with_the_amplitude_meets_the_inclined_wall_at_the_contact_angle(contact_angle, degrees):
    """The exact profile is integrated from far away to the wall through the origin, by the arc length."""
    lean = math.radians(degrees)
    amplitude = inclined_amplitude(contact_angle, lean, LIQUID) / LENGTH
    far = 16.0
    height = amplitude * math.exp(-far)

    def growth(_, surface):
        return -math.cos(surface[2]), math.sin(surface[2]), surface[1]

    def at_wall(_, surface):
        return surface[0] * math.cos(lean) + surface[1] * math.sin(lean)

    at_wall.terminal = True
    found = solve_ivp(growth, (0.0, 40.0), (far, height, height), "DOP853", events=at_wall, rtol=1e-12, atol=1e-18)
    meets = 0.5 * math.pi - found.y[2, -1] - lean
    assert meets == pytest.approx(contact_angle, abs=2e-6)
    assert found.y[1, -1] == pytest.approx(plane_wall_height(contact_angle + lean), abs=2e-6)


def test_an_upright_dish_is_the_limit_of_a_tilted_one():
    round_one = forces_in(tilted("radius = 0.014"))
    assert forces_in(tilted("radius = 0.014", "angle = 0.0")) == pytest.approx(round_one, rel=1e-6, abs=1e-15)
    box = forces_in(tilted("size = [0.026, 0.024]"))
    assert forces_in(tilted("size = [0.026, 0.024]", "angle = 0.0")) == pytest.approx(box, rel=1e-12, abs=1e-20)


def test_a_small_tilt_adds_the_mode_of_one_period_around_the_wall():
    """It is b A_1 I1(r/L)/I1'(a/L) cos(phi), with the tilt b and A_1 = dA/db at the wall."""
    small, radius = 1e-4, 0.014
    scenes = [tilted(f"radius = {radius}", f"angle = {small}\ndirection = {way}") for way in (0.0, math.pi)]
    x = np.linspace(-0.012, 0.012, 7)
    high, low = (field_of(scene.dish, LIQUID, x, np.array([0.0, 0.004])) for scene in scenes)
    ends = [inclined_amplitude(0.7, way * small, LIQUID) for way in (1.0, -1.0)]
    first = (ends[0] - ends[1]) / (2.0 * small)
    r = np.hypot(x, np.array([[0.0], [0.004]]))
    mode = first * i1(r / LENGTH) / ivp(1, radius / LENGTH) * x / np.maximum(r, 1e-12)
    assert (high - low) / (2.0 * small) == pytest.approx(mode, rel=1e-5, abs=1e-5 * abs(first))
    assert first < 0.0  # lower where the wall leans away


@pytest.mark.parametrize("angle", [0.2, 0.9])
def test_the_walls_are_the_cut_of_a_cylinder_by_the_level_surface(angle):
    scene = tilted("radius = 0.014", f"angle = {angle}\ndirection = 0.6", places=[(0.0, 0.0)])
    walls = walls_of(scene.dish)
    assert surfaces.area(walls) == pytest.approx(math.pi * 0.014**2 / math.cos(angle), rel=2e-3)
    x, y = turned(surfaces.outline(walls), -0.6).T
    assert np.hypot(x * math.cos(angle), y) == pytest.approx(np.full(len(x), 0.014), rel=1.3e-3)


def test_a_tilted_box_has_the_slope_of_each_wall():
    scene = tilted("size = [0.012, 0.01]", 'angle = "15 deg"\ndirection = "180 deg"', places=[(0.0, 0.0)])
    half, fine = 0.006 / math.cos(math.radians(15.0)), 1e-7
    for way, lean in ((-1.0, 15.0), (1.0, -15.0)):  # the left wall leans away from the liquid
        x = way * np.array([half - 2.0 * fine, half])
        height = field_of(scene.dish, LIQUID, x, np.array([0.0]))[0]
        slope = inclined_amplitude(0.7, math.radians(lean), LIQUID) / LENGTH
        assert (height[1] - height[0]) / (2.0 * fine) == pytest.approx(slope, rel=1e-4)
    assert surfaces.area(walls_of(scene.dish)) == pytest.approx(0.012 * 0.01 / math.cos(math.radians(15.0)))


def random_dish(rng):
    angle, quarter = rng.uniform(0.0, 0.6), rng.integers(4)
    kind = rng.integers(3)
    direction = 0.5 * math.pi * quarter if kind == 1 else rng.uniform(-3.0, 3.0)
    side, other = rng.uniform(0.03, 0.06, 2)
    keys = (f"radius = {0.5 * side}", f"size = [{side}, {other}]", f'shape = "ellipse"\nsize = [{side}, {other}]')[kind]
    return keys, f"angle = {angle}\ndirection = {direction}"


@pytest.mark.parametrize("seed", range(6))
def test_random_tilted_dishes_have_forces_with_a_potential_and_the_symmetries_of_the_tilt(seed):
    rng = np.random.default_rng(seed)
    keys, tilt = random_dish(rng)
    scene = tilted(keys, tilt)
    parameters, force, fine = FLOATING.parameters(scene), forces_in(scene), 1e-7
    for i, axis in np.ndindex(force.shape):
        shift = np.zeros((len(PLACES), 2))
        shift[i, axis] = fine
        ends = [sum_of_wall_energies(parameters, np.array(PLACES) + way * shift) for way in (1.0, -1.0)]
        assert force[i, axis] == pytest.approx(
            (ends[1] - ends[0]) / (2.0 * fine), rel=1e-4, abs=1e-5 * abs(force).max()
        )
    # The opposite tilt is the dish turned by half a turn.
    reverse = tilted(keys, opposite(tilt))
    assert forces_in(reverse, -np.array(PLACES)) == pytest.approx(-force, rel=1e-6, abs=1e-6 * abs(force).max())


def opposite(tilt):
    angle, direction = (float(line.partition(" = ")[2]) for line in tilt.splitlines())
    return f"angle = {angle}\ndirection = {direction + math.pi}"


@pytest.mark.long
@pytest.mark.compiled  # hundreds of steps
def test_light_floats_collect_at_the_wall_that_leans_over_the_liquid():
    scene = tilted("radius = 0.008", 'angle = "20 deg"\ndirection = "90 deg"', places=[(0.003, 0.0), (-0.003, 0.0)],
                   body='[integration]\nintegrator = "overdamped"\n', duration=4.0, frame_every=0.2)  # fmt: skip
    frames = list(simulate(scene))
    assert frames[-1].arrays["position"][:, 1].max() < -0.004
    energy = [frame.numbers["total_energy"] for frame in frames]
    assert all(after <= before + 1e-18 for before, after in itertools.pairwise(energy))


@pytest.mark.parametrize(
    ("keys", "tilt", "why"),
    [
        ("radius = 0.014\nimage = 'pinned'", "angle = 0.1", "a tilted dish"),
        ("radius = 0.014\nlaw = 'profile'", "angle = 0.1", "'profile', which is not known"),
        ("radius = 0.014", "angle = 0.8", "expected a sum from 0 to 180"),
        ("size = [0.03, 0.03]", "angle = 0.1\ndirection = 0.5", r"^scene: dish\.tilt\.direction: .* of 90 deg"),
        ("size = [0.03, 0.03]\nlaw = 'none'\nbarrier = { velocity = 0.001 }", "angle = 0.1", "lean with its walls"),
        ("vertices = [[-0.03, -0.02], [0.03, -0.02], [0.0, 0.04]]", "angle = 0.1", "right angles only"),
        ("radius = 0.014", "angle = 1.2", r"dish\.tilt\.angle"),
    ],
)
def test_what_is_not_known_of_tilted_dishes_is_refused(keys, tilt, why):
    with pytest.raises((SceneError, BadInput), match=why):
        FLOATING.parameters(tilted(keys, tilt))


def test_tilted_dishes_without_menisci_have_any_shape_and_direction():
    for keys in ("size = [0.03, 0.03]", "vertices = [[-0.03, -0.02], [0.03, -0.02], [0.0, 0.04]]"):
        scene = tilted(f"{keys}\nlaw = 'none'", "angle = 0.5\ndirection = 0.4")
        upright = surfaces.area(walls_of(tilted(f"{keys}\nlaw = 'none'").dish))
        assert surfaces.area(FLOATING.parameters(scene).walls) == pytest.approx(upright / math.cos(0.5), rel=1e-9)


def test_check_states_the_tilt_and_games_refuse_it():
    scene = tilted("radius = 0.014", 'angle = "10 deg"')
    rows = {name: (value, remark) for name, value, remark in FLOATING.summary(scene)}
    assert rows["tilt of the dish"][0] == "10 deg"
    assert "from 30.11 to 50.11 deg" in rows["tilt of the dish"][1]
    bare = {name: remark for name, _, remark in FLOATING.summary(tilted("radius = 0.014\nlaw = 'none'", "angle = 0.1"))}
    assert bare["tilt of the dish"] == "at rest, without sloshing; its walls have no menisci"
    with pytest.raises(BadInput, match=r"expected no dish\.tilt"):
        Bowl(scene)
