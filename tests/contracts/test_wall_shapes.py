"""Properties of every shape of a dish: in the model, in pictures, on the page and in games."""

import dataclasses
import itertools
import math
import re

import numpy as np
import pytest
from tests.contracts.test_laws import ROOT
from tests.models.floating.bowls import WATER, scene_of

from ecume.engine.walls import rings, wall_count
from ecume.engine.walls.rings import wall_distance
from ecume.errors import BadInput, SceneError
from ecume.models import MODELS
from ecume.models.floating import dishes
from ecume.models.floating.dishes import BETWEEN_ROUND, FACING, OVAL, ROUND, SHAPES, outline_of, walls_of
from ecume.models.floating.forces.pair_forces import add_wall_forces, sum_of_wall_energies
from ecume.show.figures import FIGURES
from ecume.show.movies import FILMS
from ecume.show.picture import Size
from ecume.show.play.bowl import Bowl as Game
from ecume.show.play.pages import BowlPage
from ecume.show.view.scenery import STAGES
from ecume.simulation import simulate

FLOATING = MODELS["floating"]
SIZES = {"radius": "0.02", "size": "[0.04, 0.03]", "vertices": "[[-0.02, -0.015], [0.025, -0.015], [-0.01, 0.025]]"}
"""A dish of each key."""
MORE = {"ring": "inner_radius = 0.002\n"}
"""Further keys that a shape needs."""
RADIUS = 1e-3
KNOWN = [name for name, row in SHAPES.items() if row.meniscus is not None]
LAWS = [(name, law) for name in KNOWN for law in SHAPES[name].meniscus.laws if law not in ("none", "two-point-legacy")]
PLACES = [(0.0028, -0.0004), (0.004, 0.003), (-0.009, 0.002), (0.001, -0.011), (0.0113, 0.0011)]

each_shape = pytest.mark.parametrize("name", SHAPES)


def scene_in(name, floats, *, dish='law = "none"', hydrodynamics='drag = "none"', **times):
    """Floats without mutual forces in a dish of this shape."""
    size = f'shape = "{name}"\n{SHAPES[name].key} = {SIZES[SHAPES[name].key]}\n{MORE.get(name, "")}'
    spec = f"[[particles]]\nradius = {RADIUS}\ndensity = 600.0\ncontact_angle = 1.2\n{floats}\n"
    rest = f'[interaction]\nlaw = "none"\n[hydrodynamics]\n{hydrodynamics}\n[contacts]\nrestitution = 1.0\n'
    return scene_of(f"{WATER}{spec}[dish]\n{size}{dish}\n{rest}", **times)


def inside(walls, count=20, seed=3):
    """Points inside, at some distance from walls."""
    chance = np.random.default_rng(seed)
    low, high = rings.bounds(walls)
    points = chance.uniform(low, high, (40 * count, 2))
    return [point for point in points if min(rings.clearances(walls, point)) > RADIUS][:count]


@each_shape
def test_the_normal_is_the_gradient_of_the_distance(name):
    walls, fine = FLOATING.parameters(scene_in(name, "count = 1")).walls, 1e-7
    for x, y in inside(walls):
        for number in range(wall_count(walls)):
            slopes = [
                wall_distance(walls, number, x + dx, y + dy)[0] - wall_distance(walls, number, x - dx, y - dy)[0]
                for dx, dy in ((fine, 0.0), (0.0, fine))
            ]
            normal = wall_distance(walls, number, x, y)[1:]
            assert np.array(slopes) / (2.0 * fine) == pytest.approx(normal, abs=1e-6)
            assert math.hypot(*normal) == pytest.approx(1.0, abs=1e-14)


@each_shape
def test_floats_start_inside_and_a_start_in_a_wall_is_refused(name):
    scene = scene_in(name, "count = 40")
    walls = walls_of(scene.dish)
    for place in next(simulate(scene)).arrays["position"]:
        assert min(rings.clearances(walls, place)) >= RADIUS
    far = 0.999 * outline_of(scene.dish)[0]
    with pytest.raises(SceneError, match="not inside the dish"):
        list(simulate(scene_in(name, f"positions = [{far.tolist()}]")))


@each_shape
def test_a_float_thrown_at_each_wall_stays_inside_and_keeps_its_energy(name):
    walls = walls_of(scene_in(name, "count = 1").dish)
    angles = np.linspace(0.3, 2.0 * math.pi + 0.3, 8, endpoint=False)
    for angle in angles:
        velocity = [0.2 * math.cos(angle), 0.2 * math.sin(angle)]
        floats = f"positions = [[0.003, -0.004]]\nvelocity = {velocity}"
        dish = 'law = "none"\nrestitution = 1.0'
        frames = list(simulate(scene_in(name, floats, dish=dish, duration=0.4, frame_every=0.02)))
        energy = [frame.numbers["kinetic_energy"] for frame in frames]
        assert energy == pytest.approx([energy[0]] * len(energy), rel=1e-9)
        deepest = min(min(rings.clearances(walls, frame.arrays["position"][0])) for frame in frames)
        assert deepest > (1.0 - 1e-3) * RADIUS
        assert sum(frame.numbers["collisions"] for frame in frames) >= 2


@pytest.mark.parametrize(
    ("name", "law", "image"),
    [(*one, "none") for one in LAWS] + [(*one, "pinned") for one in LAWS if SHAPES[one[0]].meniscus.mirrors],
)
def test_the_force_of_a_meniscus_is_minus_the_slope_of_its_energy(name, law, image):
    positions = f"positions = {[list(place) for place in PLACES]}"
    dish = f'law = "{law}"\nimage = "{image}"\ncontact_angle = 0.8'
    parameters = FLOATING.parameters(scene_in(name, positions, dish=dish))
    position, force, fine = np.array(PLACES), np.zeros((len(PLACES), 2)), 1e-7
    add_wall_forces(parameters, position, force)
    assert np.abs(force).max() > 0.0
    for i, axis in np.ndindex(force.shape):
        shift = np.zeros_like(position)
        shift[i, axis] = fine
        ends = [sum_of_wall_energies(parameters, position + way * shift) for way in (1.0, -1.0)]
        assert force[i, axis] == pytest.approx(
            -(ends[0] - ends[1]) / (2.0 * fine), rel=1e-5, abs=1e-5 * np.abs(force).max()
        )


@each_shape
@pytest.mark.parametrize("asked", ['law = "meniscus"', 'law = "none"\nimage = "pinned"'])
def test_a_meniscus_that_is_not_known_is_refused_with_the_reason(name, asked):
    row = SHAPES[name]
    scene = scene_in(name, "count = 1", dish=asked)
    if row.meniscus is not None and not row.meniscus.mirrors and "image" in asked:
        with pytest.raises(SceneError, match="no image at its wall is known"):
            FLOATING.parameters(scene)
        return
    if row.meniscus is not None:
        assert len(FLOATING.parameters(scene).wall_strength) == wall_count(walls_of(scene.dish))
        return
    assert len(row.no_meniscus.split()) > 5
    with pytest.raises(SceneError, match=re.escape(row.no_meniscus)):
        FLOATING.parameters(scene)


def test_the_kinds_of_menisci_are_those_of_the_rows():
    kinds = {"round": ROUND, "ring": BETWEEN_ROUND, "rectangle": FACING, "ellipse": OVAL}
    assert {name: SHAPES[name].meniscus for name in kinds} == kinds


@each_shape
def test_movies_plots_and_the_page_draw_it(name):
    scene = scene_in(name, "count = 30", duration=0.1, frame_every=0.05, hydrodynamics="")
    frames = list(simulate(scene))
    picture = FILMS["floating"](scene, frames, Size(320, 240))
    assert np.ptp(picture.pixels(frames[-1])[..., :3]) > 100
    outline = outline_of(scene.dish)
    for corner in outline:
        assert picture.view.left < corner[0] < picture.view.right
        assert picture.view.bottom < corner[1] < picture.view.top
    for what in ("paths", "pair-distribution", "bowl"):
        assert FIGURES["floating"][what](frames, scene).axes
    stage = STAGES["floating"](scene, frames)
    assert stage.lines[0].points == pytest.approx(outline)
    walls = walls_of(scene.dish)
    inner = rings.inner_outline(walls)
    assert len(stage.surface.walls) + (stage.surface.round > 0.0) + len(inner) == wall_count(walls)
    assert len(stage.lines) == 1 + len(inner)
    shown = stage.heights(frames[-1])
    assert shown.shape == (stage.surface.rows, stage.surface.columns)
    assert np.isfinite(shown).all()


@each_shape
def test_one_can_play_with_it(name):
    scene = scene_in(name, "count = 3", duration=0.1, frame_every=0.05, hydrodynamics="")
    if name in MORE:
        with pytest.raises(BadInput, match="without an inner wall"):
            Game(scene)
        return
    game = Game(scene)
    game.drop("bead", 0.0, 0.0)
    game.tilt = (0.1, 0.0)
    game.play(0.02)
    assert len(game.frame.arrays["radius"]) == 4
    page = BowlPage(game)
    page.paint(1.0)
    assert page.header()["outline"] == outline_of(scene.dish).tolist()
    assert page.now()["surface"]


@pytest.mark.parametrize("name", [name for name in SHAPES if name not in MORE])
def test_a_size_under_another_key_is_refused(name):
    scene = scene_in(name, "count = 1")
    key = next(key for key in SIZES if key != SHAPES[name].key)
    wrong = {"radius": None, "size": None, "vertices": None, key: 0.02 if key == "radius" else (0.04, 0.03)}
    dish = dataclasses.replace(scene.dish, **wrong)
    with pytest.raises(SceneError, match=f"takes '{SHAPES[name].key}'"):
        FLOATING.parameters(dataclasses.replace(scene, dish=dish))


@pytest.mark.parametrize(
    ("vertices", "why"),
    [
        ([[0.01, 0.01], [0.03, 0.01], [0.02, 0.03]], "origin"),
        ([[-0.03, -0.02], [0.03, -0.02], [0.0, 0.01], [0.0, 0.04]], "not convex"),
    ],
)
def test_a_polygon_that_holds_no_raft_is_refused(vertices, why):
    scene = scene_in("polygon", "count = 1")
    dish = dataclasses.replace(scene.dish, vertices=vertices)
    with pytest.raises(SceneError, match=rf"dish\.vertices: .*{why}"):
        FLOATING.parameters(dataclasses.replace(scene, dish=dish))


@pytest.mark.compiled  # thousands of steps; one float does the same as plain Python above
def test_floats_in_a_triangle_keep_their_energy_and_stay_inside():
    """With short steps, since in a sharp corner a second collision within a step is plastic."""
    frames = {}
    for step in (1e-3, 5e-3):
        scene = scene_in("polygon", "count = 12\nvelocity = [0.04, 0.03]", duration=3.0, frame_every=0.5,
                         dish='law = "none"\nrestitution = 1.0')  # fmt: skip
        frames[step] = list(simulate(scene.replace("integration.time_step", step)))
        walls = walls_of(scene.dish)
        for frame in frames[step]:
            nearest = min(min(rings.clearances(walls, place)) for place in frame.arrays["position"])
            assert nearest > RADIUS * (1.0 - 1e-3)
    fine, coarse = ([frame.numbers["kinetic_energy"] for frame in each] for each in frames.values())
    assert frames[1e-3][-1].numbers["collisions"] > 100
    assert fine == pytest.approx([fine[0]] * len(fine), rel=1e-12)
    assert all(after <= before * (1.0 + 1e-12) for before, after in itertools.pairwise(coarse))


def test_a_shape_that_does_not_exist_is_refused():
    scene = scene_in("round", "count = 1")
    with pytest.raises(SceneError, match="expected one of 'round'"):
        FLOATING.parameters(dataclasses.replace(scene, dish=dataclasses.replace(scene.dish, shape="star")))


def test_a_new_row_does_not_change_dishes_without_a_name(monkeypatch):
    first = {"other": SHAPES["round"]._replace(meniscus=None)} | SHAPES
    monkeypatch.setattr(dishes, "SHAPES", first)
    for key, shape in (("radius", "round"), ("size", "rectangle"), ("vertices", "polygon")):
        scene = scene_of(f"{WATER}[[particles]]\nradius = 1e-3\ndensity = 600.0\ncontact_angle = 1.2\n[dish]\n"
                         f"{key} = {SIZES[key]}\n")  # fmt: skip
        assert dishes.name_of(scene.dish) == shape


@each_shape
def test_the_documentation_names_a_shape(name):
    pages = (ROOT / "docs" / "physics").glob("floating*.md")
    assert any(f"`{name}`" in page.read_text(encoding="utf-8") for page in pages)
