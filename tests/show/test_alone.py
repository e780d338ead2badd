"""A page that simulates by itself moves floats as ecume does, by the same laws, and refuses what it cannot."""

import base64
import dataclasses
import json
import math
import re
import resource
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ecume.analysis.clusters import components
from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.floating.dishes import wall_strengths
from ecume.models.floating.parameters import Floats, make_state
from ecume.models.floating.time_integration.step_size import kick_of
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play import alone as pages
from ecume.show.play import offered as numbers
from ecume.show.play.alone import alone, refusal, save_alone
from ecume.show.play.memory import bowl_arguments, slots, types_of
from ecume.show.play.offered import (
    AS_GIVEN,
    COARSE,
    FINE,
    Grid,
    dishes_of,
    in_liquid,
    offered,
    parameters_in,
    species_of,
    steps_in,
)
from ecume.show.play.pages import Written
from ecume.show.view.page import ALONE, bundled, policy_of

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]
FLOATING = MODELS["floating"]
GRID = Grid((0.75, 1.0), (1.0, 20.0), (0.0, 30.0))
WORKER = Path(__file__).with_name("worker.mjs")
with_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def scene_of(*changes):
    return load_scene((folder() / "cereal-bowl.toml").read_text(encoding="utf-8"), list(changes))


@pytest.fixture(scope="module")
def few():
    """Fewer kinds to choose from, which takes less time."""
    patch = pytest.MonkeyPatch()
    patch.setattr(numbers, "FINE", GRID)
    patch.setattr(numbers, "COARSE", Grid((1.0,), (1.0,), (0.0,)))
    patch.setattr(numbers, "LIQUIDS", ("water",))
    patch.setattr(pages, "GALLERY", ("wall-climbing",))
    yield
    patch.undo()


@pytest.fixture(scope="module")
def page(few, tmp_path_factory):
    written = tmp_path_factory.mktemp("page") / "bowl.html"
    written.write_text(alone(scene_of()), encoding="utf-8")
    return written


def asked(page, *questions):
    done = subprocess.run(
        ["node", str(WORKER), str(page)], input=json.dumps(questions), capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return [one.get("answer") for one in json.loads(done.stdout)]


def test_the_compiled_bowl_takes_what_ecume_has_now():
    assert types_of(bowl_arguments(scene_of())) == bundled("bowl.types"), "run `sh scripts/web`"


def test_numbers_and_arrays_are_in_the_order_of_the_arguments():
    found = {name: (kind, shape) for name, kind, shape, _ in slots(bowl_arguments(scene_of("particles[0].count=2")))}
    assert found["state.position"] == ("float64 2", [2, 2])
    assert found["parameters.kick.mobility"] == ("float64 1", [3])
    assert found["parameters.scheme.inertia"] == ("bool", None)
    assert list(found)[-1] == "steps"


@pytest.fixture(scope="module")
def native(few):
    """The bowl of the page in ecume: parameters, state and workspace."""
    scene = scene_of()
    every = offered(species_of(scene), GRID)
    made = in_liquid(scene, every, GRID.usual)
    dishes = [dataclasses.replace(scene, dish=dish) for dish in dishes_of(scene.dish).values()]
    bowl = parameters_in(scene, made)
    step = steps_in([(one, parameters_in(one, made)) for one in dishes], made)[0]
    kind = next(k for k, one in enumerate(every) if one.choice == GRID.usual)
    floats = Floats(*(np.repeat(values[kind : kind + 1], 60) for values in made.floats))
    kick, walls = kick_of(bowl.scheme, step, floats, 1), wall_strengths(scene, floats)
    parameters = bowl._replace(time_step=step, floats=floats, kick=kick, wall_strength=walls)
    start = FLOATING.start(scene, FLOATING.parameters(scene)).position
    state = make_state(start, np.zeros_like(start))
    return parameters, state, FLOATING.workspace(parameters, state, 2.0)


def rafts_of(place, radius):
    """The sizes of rafts, the smallest first, and the number of contacts."""
    near = np.array(sorted(cKDTree(place).query_pairs(2.02 * radius)), np.int64).reshape(-1, 2)
    return sorted(components(near, len(place)).sizes.tolist()), len(near)


@pytest.mark.long
@with_node
def test_a_page_moves_sixty_floats_as_the_processor_does(page, native):
    parameters, state, workspace = native
    start, radius = state.position.copy(), float(parameters.floats.radius[0])
    steps = (100, 1900, 18_000)
    smooth, rough, late = asked(page, *(one for each in steps for one in (["go", {"steps": each}], ["places"])))[1::2]
    assert FLOATING.advance(parameters, state, workspace, 100) == 0
    assert np.array(smooth) == pytest.approx(state.position.ravel(), rel=0.0, abs=1e-14)
    assert FLOATING.advance(parameters, state, workspace, 1900) == 0
    assert state.tally[0] > 10
    assert np.array(rough) == pytest.approx(state.position.ravel(), rel=0.0, abs=1e-12)
    assert np.abs(state.position - start).max() > 1e-3
    # Later collisions amplify what is left of rounding; the rafts are of the same statistics.
    assert FLOATING.advance(parameters, state, workspace, 18_000) == 0
    (theirs, touching), (ours, contacts) = (
        rafts_of(state.position, radius),
        rafts_of(np.array(late).reshape(-1, 2), radius),
    )
    assert len(theirs) < 30
    assert abs(len(ours) - len(theirs)) <= 2
    assert ours[-1] == pytest.approx(theirs[-1], rel=0.2)
    assert contacts == pytest.approx(touching, rel=0.05)


@with_node
def test_what_is_dropped_is_saved_as_a_scene_that_ecume_takes(page):
    before, said, beyond, after, text, liquid = asked(
        page, ["now"], ["drop", {"name": "bead", "x": 0.0, "y": 0.0}], ["drop", {"name": "bead", "x": 1.0, "y": 0.0}],
        ["now"], ["scene"], ["liquid", {"name": "water"}],
    )  # fmt: skip
    assert (said, beyond) == ("", "There is no room here.")
    scene = load_scene(text)
    count = sum(species.count for species in scene.particles)
    assert count == len(after["x"]) >= len(before["x"])
    assert [species.name for species in scene.particles][:1] == ["cereal"]
    start = FLOATING.start(scene, FLOATING.parameters(scene))
    assert start.position[:60, 0] == pytest.approx(np.array(after["x"])[:60], abs=1e-12)
    assert [species.name for species in scene.particles] == ["cereal", "bead"]
    assert liquid == ""


@with_node
def test_kinds_that_sink_are_refused_and_change_nothing(page):
    said, now = asked(page, ["kind", {"species": 0, "factor": 1, "value": 1}], ["now"])
    assert said == "A cereal of this kind sinks in this liquid."
    assert now["kinds"][0]["density"] == 300.0


def fragment(*numbers):
    return base64.urlsafe_b64encode(bytes(numbers)).decode().rstrip("=")


USUAL = GRID.usual * 3
FAR = (255, 255, 255, 255, 128, 128)
HOSTILE = [
    "", "x", "null", "[]", "%7B%7D", "<script>alert(1)</script>", "\u0000", "ä" * 2000, "A" * 1_000_000,
    fragment(0, 0, 0, 0, *USUAL), fragment(1), fragment(1, 9, 0, 0, *USUAL), fragment(1, 0, 9, 0, *USUAL),
    fragment(1, 0, 0, 9, *USUAL), fragment(1, 0, 0, 0, 9, 9, 9, *USUAL[3:]), fragment(1, 0, 0, 0, *USUAL, 0),
    fragment(1, 0, 0, 0, *USUAL, 7, *FAR), fragment(1, 0, 0, 0, *USUAL, *(0, *FAR) * 121),
    fragment(1, 0, 0, 0, 1, 1, 0, *USUAL[3:], 0, 128, 0, 128, 0, 128, 128),
]  # fmt: skip


@with_node
def test_hostile_links_end_in_a_sentence(page):
    *said, now = asked(page, *(["bring", {"fragment": one}] for one in HOSTILE), ["now"])
    assert all(re.fullmatch(r"The link describes? .+\.|The link does not describe .+\.", one) for one in said), said
    assert len(now["x"]) == 60


@with_node
def test_a_link_brings_back_what_it_was_made_of(page):
    _, _, link = asked(page, ["go", {"steps": 200}], ["dish", {"name": "square"}], ["link"])
    before, said, again, after = asked(page, ["now"], ["bring", {"fragment": link}], ["link"], ["now"])
    assert said == ""
    assert again == link
    assert after["choice"] == {**before["choice"], "dish": "square"}
    assert len(link) < 700


@with_node
def test_a_link_brings_floats_back_to_the_micrometer(page):
    _, link, before = asked(page, ["go", {"steps": 200}], ["link"], ["now"])
    _, after = asked(page, ["bring", {"fragment": link}], ["now"])
    for axis in "xy":
        assert after[axis] == pytest.approx(before[axis], rel=0.0, abs=2e-6)


@with_node
def test_every_dish_keeps_its_floats_and_becomes_a_scene(page):
    for name in ("square", "long"):
        said, _, now, text = asked(page, ["dish", {"name": name}], ["go", {"steps": 300}], ["now"], ["scene"])
        assert said == ""
        scene = load_scene(text)
        half = 0.5 * np.array(scene.dish.size)
        assert np.all(np.abs(np.array([now["x"], now["y"]])) <= half[:, None])
        assert half[0] * half[1] * 4 == pytest.approx(math.pi * 0.04**2)
        assert FLOATING.start(scene, FLOATING.parameters(scene)).position.shape == (60, 2)


@with_node
def test_another_scene_of_the_gallery_begins_and_the_first_one_again(page):
    _, other, text, unknown, _, first = asked(
        page, ["anew", {"chapter": 1}], ["now"], ["scene"], ["anew", {"chapter": 7}], ["anew", {"chapter": 0}], ["now"]
    )
    assert {kind["name"] for kind in other["kinds"]} == {one.name for one in load_scene(text).particles}
    assert unknown == "There is no such scene."
    assert len(first["x"]) == 60
    assert first["time"] < 0.1


@with_node
def test_floats_drift_in_an_ellipse_to_its_wall(few, tmp_path):
    """Each of its walls has a strength of its own, of which a page has only shares in the largest one."""
    text = (folder() / "cereal-bowl.toml").read_text(encoding="utf-8")
    scene = load_scene(text.replace('radius = "4 cm"', 'shape = "ellipse"\nsize = ["9 cm", "7 cm"]'))
    ellipse = tmp_path / "ellipse.html"
    assert save_alone(scene, ellipse, 1.0) < 500_000
    _, now = asked(ellipse, ["go", {"steps": 3000}], ["now"])
    x, y = np.array(now["x"]), np.array(now["y"])
    assert np.all((x / 0.045) ** 2 + (y / 0.035) ** 2 < 1.0)
    made = in_liquid(scene, offered(species_of(scene), GRID), GRID.usual)
    each, found = wall_strengths(scene, made.floats), numbers._strengths(wall_strengths(scene, made.floats))
    there = np.array([value is not None for value in found["strength"]])
    product = np.outer(found["shares"], np.array(found["strength"], float)[there])
    assert product == pytest.approx(each[:, there], rel=1e-14)
    assert np.ptp(found["shares"]) > 0.1


@with_node
def test_a_dish_can_be_emptied_and_filled(page):
    _, none, _, one = asked(page, ["empty"], ["now"], ["drop", {"name": "bubble", "x": 0.0, "y": 0.0}], ["now"])
    assert none["x"] == []
    assert len(one["x"]) == 1


@with_node
def test_sizes_change_the_time_step_and_the_floats(page):
    said, now, text = asked(page, ["kind", {"species": 0, "factor": 0, "value": 0}], ["now"], ["scene"])
    assert said == ""
    assert now["kinds"][0]["radius"] == pytest.approx(0.75 * 1.5e-3)
    assert load_scene(text).particles[0].radius == now["kinds"][0]["radius"]


@with_node
def test_a_dish_that_is_tilted_and_a_float_that_is_dragged(page):
    _, _, left, _, _, held = asked(
        page, ["tilt", {"x": 0.1, "y": 0.0}], ["go", {"steps": 500}], ["now"],
        ["grasp", {"one": 3, "x": 0.0, "y": 0.0}], ["go", {"steps": 300}], ["now"],
    )  # fmt: skip
    assert left["slope"][0] != 0.0
    assert math.hypot(held["x"][3], held["y"][3]) < math.hypot(left["x"][3], left["y"][3])


@with_node
def test_a_tilted_dish_that_begins_again_is_level_and_stays_so(page):
    _, _, tilted, _, _, again = asked(
        page,
        ["tilt", {"x": 0.1, "y": -0.05}],
        ["go", {"steps": 100}],
        ["now"],
        ["anew"],
        ["go", {"steps": 100}],
        ["now"],
    )
    assert tilted["slope"][1] < 0.0 < tilted["slope"][0]
    assert again["slope"] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("particles[0].count=121", "room for 120 floats"),
        ('integration.integrator="explicit-euler"', ""),
        ('contacts.law="spring-dashpot"', "not compiled into pages"),
    ],
)
def test_it_says_what_it_cannot_simulate(change, why):
    scene = scene_of("dish.radius='8 cm'", change)
    found = refusal(scene)
    assert why in found
    if why:
        with pytest.raises(BadInput, match=re.escape(found)):
            alone(scene)


def test_the_page_is_small_and_may_ask_nobody(page):
    text = page.read_text(encoding="utf-8")
    assert len(text.encode()) < 1e6
    policy = policy_of(ALONE, live=False)
    assert policy in text
    assert "'wasm-unsafe-eval'" in policy
    assert "connect-src 'none'" in policy


def spent(page, steps):
    """The processor time (s) of Node for so many steps, and to start."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    asked(page, ["go", {"steps": steps}])
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


@pytest.mark.long
@with_node
def test_sixty_floats_take_ten_thousand_steps_a_second(page):
    assert spent(page, 20_000) - spent(page, 1) < 2.0


@pytest.mark.long
def test_a_page_above_the_largest_size_is_not_written(few, tmp_path):
    with pytest.raises(BadInput, match=r"the page has 0\.\d\d MB; expected --max-size of that or more"):
        save_alone(scene_of(), tmp_path / "bowl.html", 0.05)
    assert not list(tmp_path.iterdir())


def test_the_table_of_what_is_offered():
    assert FINE.usual == (2, 1, 2)
    assert COARSE.usual == (1, 1, 1)
    assert list(dishes_of(scene_of().dish)) == [AS_GIVEN, "square", "long"]


def test_the_page_of_a_game_is_given_out_once_and_takes_no_orders():
    site = Written("<p>bowl</p>", ALONE)
    assert site.get("/", {}).content == b"<p>bowl</p>"
    assert site.get("/now", {}) is None
    assert site.post("/do", b"{}") is None
    assert "'wasm-unsafe-eval'" in site.policy
