"""A page that simulates by itself moves floats as ecume does, by the same laws, and refuses what it cannot."""

import json
import math
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.floating.parameters import Floats, make_state
from ecume.models.floating.time_integration.step_size import kick_of
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play import alone as pages
from ecume.show.play.alone import USUAL, alone, in_liquid, offered, refusal, species_of
from ecume.show.play.memory import bowl_arguments, slots, types_of
from ecume.show.view.page import ALONE, bundled, policy_of

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]
FLOATING = MODELS["floating"]
WORKER = Path(__file__).with_name("worker.mjs")
with_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def scene_of(*changes):
    return load_scene((folder() / "cereal-bowl.toml").read_text(encoding="utf-8"), list(changes))


@pytest.fixture(scope="module")
def few():
    """Fewer kinds to choose from, which takes less time."""
    patch = pytest.MonkeyPatch()
    patch.setattr(pages, "SIZES", (0.75, 1.0))
    patch.setattr(pages, "DENSITIES", (1.0, 20.0))
    patch.setattr(pages, "ANGLES", (0.0, 30.0))
    patch.setattr(pages, "LIQUIDS", ("water",))
    patch.setattr(pages, "USUAL", (1, 0, 0))
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


@with_node
def test_a_page_moves_sixty_floats_as_the_processor_does(page):
    scene = scene_of()
    every = offered(species_of(scene))
    made = in_liquid(scene, every)
    kind = next(k for k, one in enumerate(every) if one.choice == pages.USUAL)
    floats = Floats(*(np.repeat(values[kind : kind + 1], 60) for values in made.floats))
    step, walls = made.steps[0], np.repeat(made.wall_strength[:, kind : kind + 1], 60, axis=1)
    kick = kick_of(made.parameters.scheme, step, floats, 1)
    parameters = made.parameters._replace(time_step=step, floats=floats, kick=kick, wall_strength=walls)
    start = FLOATING.start(scene, FLOATING.parameters(scene)).position
    state = make_state(start, np.zeros_like(start))
    workspace = FLOATING.workspace(parameters, state, 2.0)
    smooth, rough = asked(page, ["go", {"steps": 100}], ["places"], ["go", {"steps": 1900}], ["places"])[1::2]
    assert FLOATING.advance(parameters, state, workspace, 100) == 0
    assert np.array(smooth) == pytest.approx(state.position.ravel(), rel=0.0, abs=1e-14)
    assert FLOATING.advance(parameters, state, workspace, 1900) == 0
    assert state.tally[0] > 10
    assert np.array(rough) == pytest.approx(state.position.ravel(), rel=0.0, abs=1e-10)
    assert np.abs(state.position - start).max() > 1e-3


@with_node
def test_what_is_dropped_is_saved_as_a_scene_that_ecume_takes(page):
    before, said, again, after, text, liquid = asked(
        page, ["now"], ["drop", {"name": "bead", "x": 0.0, "y": 0.0}], ["drop", {"name": "bead", "x": 0.0, "y": 0.0}],
        ["now"], ["scene"], ["liquid", {"name": "water"}],
    )  # fmt: skip
    assert again == "There is no room here." or said == "There is no room here."
    scene = load_scene(text)
    count = sum(species.count for species in scene.particles)
    assert count == len(after["x"]) >= len(before["x"])
    assert [species.name for species in scene.particles][:1] == ["cereal"]
    start = FLOATING.start(scene, FLOATING.parameters(scene))
    assert start.position[:60, 0] == pytest.approx(np.array(after["x"])[:60], abs=1e-12)
    assert liquid == ""


@with_node
def test_kinds_that_sink_are_refused_and_change_nothing(page):
    said, now = asked(page, ["kind", {"species": 0, "factor": 1, "value": 1}], ["now"])
    assert said == "A cereal of this kind sinks in this liquid."
    assert now["kinds"][0]["density"] == 300.0


HOSTILE = [
    None, 1, "x", [], {}, {"liquid": "__proto__", "choices": [], "floats": []},
    {"liquid": "water", "choices": [[1, 0, 0]] * 3, "floats": [[0, 1e300, 0, 0, 0]]},
    {"liquid": "water", "choices": [[1, 0, 0]] * 3, "floats": [[0, 0, 0, 1e9, 0]]},
    {"liquid": "water", "choices": [[9, 9, 9]] * 3, "floats": []},
    {"liquid": "water", "choices": [[1, 0, 0]] * 3, "floats": [[0, 0, 0, 0, 0]] * 2},
    {"liquid": "water", "choices": [[1, 0, 0]] * 3, "floats": [[0, 0, 0, 0, 0]] * 100_000},
]  # fmt: skip


@with_node
def test_hostile_links_end_in_a_sentence(page):
    *said, now = asked(page, *(["bring", {"kept": kept}] for kept in HOSTILE), ["now"])
    assert all(re.fullmatch(r"The link describes? .+\.|The link does not describe .+\.", one) for one in said), said
    assert len(now["x"]) == 60


@with_node
def test_a_link_brings_back_what_it_was_made_of(page):
    kept = json.loads(asked(page, ["go", {"steps": 200}], ["keep"])[1])
    said, again = asked(page, ["bring", {"kept": kept}], ["keep"])
    assert said == ""
    assert json.loads(again) == kept


@with_node
def test_a_dish_that_is_tilted_and_a_float_that_is_dragged(page):
    _, _, left, _, _, held = asked(
        page, ["tilt", {"x": 0.1, "y": 0.0}], ["go", {"steps": 500}], ["now"],
        ["grasp", {"one": 3, "x": 0.0, "y": 0.0}], ["go", {"steps": 300}], ["now"],
    )  # fmt: skip
    assert left["slope"][0] != 0.0
    assert math.hypot(held["x"][3], held["y"][3]) < math.hypot(left["x"][3], left["y"][3])


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
    assert USUAL == (1, 1, 1)
