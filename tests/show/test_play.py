"""A bowl that is played with is the simulated one, whatever hands do to it, and can be saved as a scene."""

import json
import math
import threading
import time
import urllib.error
import urllib.request

import numpy as np
import pytest

import ecume
from ecume.errors import BadInput
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.scenes.writing import to_toml
from ecume.show.play import pages
from ecume.show.play.bowl import CALMED, DAMPING, FASTEST, PUT_BACK, SHELF, Bowl, Slosh, current, slosh_frequency, swung
from ecume.show.play.pages import game_of
from ecume.show.serving import served

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]


def scene_of(*changes):
    text = (folder() / "cereal-bowl.toml").read_text()
    return load_scene(text, ["particles[0].count=3", "particles[0].positions=[[0, 0], [0.02, 0], [0, 0.02]]", *changes])


@pytest.fixture
def bowl():
    return Bowl(scene_of())


def places(bowl):
    return bowl.frame.arrays["position"]


def test_left_alone_it_goes_as_the_simulation_does(bowl):
    for _ in range(30):
        bowl.play(0.05)
    step = bowl.integration.parameters.time_step
    steps = int(bowl.integration.state.step[0])
    scene = scene_of(f"integration.time_step={step}", f"duration={steps * step!r}", f"frame_every={steps * step!r}")
    last = list(ecume.simulate(scene))[-1]
    assert places(bowl) == pytest.approx(last.arrays["position"], abs=1e-15)
    assert bowl.time == pytest.approx(last.time)


@pytest.mark.long
def test_ten_that_are_dropped_meet(bowl):
    for number in range(10):
        name = list(SHELF)[number % 2 * 2]  # cereals and bubbles, which all attract one another
        bowl.drop(name, 0.004 * math.cos(number), 0.004 * math.sin(number))
    count = len(places(bowl))
    before = bowl.frame.numbers["clusters"]
    for _ in range(150):
        bowl.play(0.05)
    assert count == 13
    assert bowl.frame.numbers["clusters"] < before - 4
    assert bowl.frame.numbers["largest_overlap"] < 1e-3


def test_who_is_dropped_on_another_finds_room_beside_it(bowl):
    bowl.drop("bead", 0.0, 0.0)
    frame = bowl.frame
    apart = np.hypot(*(frame.arrays["position"][:3] - frame.arrays["position"][3]).T)
    assert apart.min() > 2.7e-3
    assert apart.min() < 8e-3
    assert [kind.name for kind in bowl.scene.kinds] == ["cereal", "bead"]


def test_where_there_is_no_room_nothing_is_dropped(bowl):
    with pytest.raises(BadInput, match="no room here"):
        bowl.drop("bead", 1.0, 0.0)
    with pytest.raises(BadInput, match="there is no 'brick' to drop; expected one of cereal, bead, bubble"):
        bowl.drop("brick", 0.0, 0.0)
    assert len(places(bowl)) == 3


def test_who_is_taken_out_is_gone_and_the_others_go_on(bowl):
    bowl.drop("bead", 0.01, 0.01)
    bowl.play(0.05)
    before, speeds = places(bowl).copy(), bowl.integration.state.velocity.copy()
    bowl.take(1)
    assert places(bowl) == pytest.approx(before[[0, 2, 3]])
    assert bowl.integration.state.velocity == pytest.approx(speeds[[0, 2, 3]])
    bowl.take(2)
    assert [kind.name for kind in bowl.scene.kinds] == ["cereal"]
    bowl.take(0)
    with pytest.raises(BadInput, match="the last float cannot be removed"):
        bowl.take(0)
    with pytest.raises(BadInput, match="there is no float 5"):
        bowl.take(5)


def test_a_hand_drags_and_throws(bowl):
    bowl.grasp(1, -0.02, 0.01)
    for _ in range(40):
        bowl.play(1 / 60)
    assert places(bowl)[1] == pytest.approx([-0.02, 0.01], abs=1e-3)
    bowl.grasp(1, 0.02, 0.01)
    bowl.play(1 / 60)
    bowl.release()
    assert 0.02 < np.hypot(*bowl.integration.state.velocity[1]) <= FASTEST
    before = places(bowl)[1, 0]
    bowl.play(1 / 60)
    assert places(bowl)[1, 0] > before
    with pytest.raises(BadInput, match="there is no float 3"):
        bowl.grasp(3, 0.0, 0.0)


def test_a_change_of_the_liquid_is_one_of_the_scene(bowl):
    charge = bowl.frame.arrays["charge"][0]
    bowl.change("liquid", "surface_tension", 0.06)
    assert bowl.scene.liquid.surface_tension == 0.06
    assert bowl.frame.arrays["charge"][0] != charge
    bowl.change("cereal", "contact_angle", 1.0)
    assert bowl.frame.arrays["contact_angle"] == pytest.approx(1.0)


def test_a_bowl_begins_again_where_it_began(bowl):
    start = places(bowl).copy()
    bowl.drop("bead", 0.01, 0.005)
    bowl.play(0.1)
    assert np.abs(bowl.forces()).max() > 0.0
    bowl.begin_again()
    assert places(bowl) == pytest.approx(start)
    assert bowl.time == 0.0


def test_a_tilted_bowl_that_begins_again_is_level_with_its_first_numbers(bowl):
    bowl.tilt = (0.1, -0.05)
    bowl.change("liquid", "surface_tension", 0.06)
    bowl.play(0.05)
    assert bowl.slosh.slope[0] > 0.0
    bowl.begin_again()
    bowl.play(0.05)
    assert bowl.slosh == Slosh()
    assert bowl.scene.liquid == bowl.first.liquid


def test_a_float_becomes_larger(bowl):
    bowl.change("cereal", "radius", 2e-3)
    assert bowl.frame.arrays["radius"] == pytest.approx(2e-3)


@pytest.mark.parametrize(
    ("part", "key", "value", "says"),
    [
        ("liquid", "surface_tension", -1.0, "surface_tension = -1: .*or more"),
        (
            "cereal",
            "density",
            9000.0,
            "density = 9000: (.*: )?this sphere would sink; take a smaller or lighter sphere, or",
        ),
        ("cereal", "positions", 1.0, "there is no cereal.positions to change"),
        ("milk", "viscosity", 1.0, "there is no milk.viscosity to change; expected liquid, dish, cereal"),
        ("dish", "surface_tension", 1.0, "dish.surface_tension = 1"),
    ],
)
def test_what_scenes_refuse_changes_nothing(bowl, part, key, value, says):
    before = bowl.scene
    with pytest.raises(BadInput, match=says):
        bowl.change(part, key, value)
    assert bowl.scene is before
    bowl.play(0.05)


def test_floats_that_diverge_are_brought_to_rest_and_then_put_back_to_the_last_change(bowl):
    bowl.drop("bead", 0.01, 0.005)
    dropped = places(bowl).copy()
    bowl.tilt = (0.1, 0.0)
    for _ in range(20):
        bowl.play(1 / 60)
    bowl.tilt, before, then = (0.0, 0.0), places(bowl).copy(), bowl.time
    bowl.integration.state.velocity[0] = np.nan
    bowl.play(1 / 60)
    assert bowl.news == [CALMED]
    assert places(bowl) == pytest.approx(before)
    assert not bowl.integration.state.velocity.any()
    assert bowl.time == then
    bowl.integration.state.velocity[0] = np.nan
    bowl.play(1 / 60)
    assert bowl.news == [CALMED, PUT_BACK]
    assert places(bowl) == pytest.approx(dropped)
    assert np.abs(before - dropped).max() > 1e-5
    for _ in range(20):
        bowl.play(1 / 60)
    assert len(bowl.news) == 2
    assert np.isfinite(places(bowl)).all()


def test_the_saved_scene_goes_on_from_here(bowl):
    bowl.drop("bead", 0.01, 0.005)
    bowl.grasp(0, 0.03, 0.0)
    bowl.play(0.05)
    bowl.release()
    scene = load_scene(to_toml(bowl.present()))
    first = next(iter(ecume.simulate(scene)))
    for name in ("position", "velocity", "radius", "charge", "species"):
        assert first.arrays[name] == pytest.approx(bowl.frame.arrays[name], abs=0), name
    assert [kind.name for kind in scene.kinds] == ["cereal", "bead"]


def test_only_bowls_are_played_with():
    with pytest.raises(BadInput, match=r"expected a scene of model 'floating' with a \[dish\]"):
        Bowl(load_scene((folder() / "two-spheres.toml").read_text()))
    with pytest.raises(BadInput, match="expected a scene of model 'floating'"):
        Bowl(load_scene((folder() / "settling.toml").read_text()))


def test_a_liquid_swings_about_the_tilt_and_comes_to_rest_there():
    scene = scene_of()
    omega, tilt = slosh_frequency(scene), (0.1, -0.05)
    small, whole = Slosh(), swung(Slosh(), tilt, scene, 0.3)
    for _ in range(300):
        small = swung(small, tilt, scene, 1e-3)
    assert small.slope == pytest.approx(whole.slope)
    assert small.rate == pytest.approx(whole.rate)
    half = math.pi / (omega * math.sqrt(1 - DAMPING**2))
    over = swung(Slosh(), tilt, scene, half)
    assert over.slope[0] == pytest.approx(0.1 * (1 + math.exp(-DAMPING * omega * half)))
    assert over.rate == pytest.approx((0.0, 0.0), abs=1e-12)
    assert swung(Slosh(), tilt, scene, 100.0).slope == pytest.approx(tilt)


def test_the_current_fills_the_side_that_rises():
    # The slope's rate times the area on one side, to first order, is what runs through the middle of a shallow box.
    scene = scene_of()
    assert current(Slosh((0.0, 0.0), (1.0, 0.0)), scene)[0] > 0.0
    assert current(Slosh((0.0, 0.0), (0.0, -1.0)), scene)[1] < 0.0


def test_a_tilt_carries_floats_towards_the_low_side(bowl):
    bowl.tilt = (0.1, 0.0)
    start = places(bowl)[:, 0].mean()
    for _ in range(6):
        bowl.play(1 / 60)
    assert places(bowl)[:, 0].mean() > start + 1e-4


@pytest.fixture
def game():
    made = game_of(scene_of())
    loop = threading.Thread(target=made.run, daemon=True)
    loop.start()
    with served(made) as address:
        yield made, address.split("/?")[0]
    made.over.set()
    loop.join()


def asked(game, path, body=None, token=None):
    made, base = game
    data = None if body is None else json.dumps(body).encode()
    headers = {"X-Token": made.token if token is None else token}
    with urllib.request.urlopen(urllib.request.Request(f"{base}{path}", data, headers)) as answer:
        return answer.read()


def test_a_game_that_no_page_asks_for_pauses_until_one_does(game, monkeypatch):
    made, _ = game
    monkeypatch.setattr(pages, "ABSENT", 0.2)
    asked(game, "/now")
    time.sleep(0.6)
    with made.lock:
        before = made.toy.moving.time
    time.sleep(0.6)
    with made.lock:
        assert made.toy.moving.time == before
    after, patience = before, time.monotonic() + 100.0
    while not after > before and time.monotonic() < patience:
        time.sleep(0.05)
        after = json.loads(asked(game, "/now"))["time"]
    assert after > before


def test_the_page_receives_the_state_and_what_was_refused(game):
    before, patience = json.loads(asked(game, "/now")), time.monotonic() + 100.0
    after = before
    while not after["time"] > before["time"] and time.monotonic() < patience:
        time.sleep(0.05)
        after = json.loads(asked(game, "/now"))
    assert after["time"] > before["time"]
    assert len(after["x"]) == len(after["radius"]) == 3
    assert len(after["surface"]) > 1000
    assert json.loads(asked(game, "/do", {"what": "drop", "name": "bead", "x": 0.01, "y": 0.01})) == {"said": ""}
    assert len(json.loads(asked(game, "/now"))["x"]) == 4
    assert "no room" in json.loads(asked(game, "/do", {"what": "drop", "name": "bead", "x": 9, "y": 0}))["said"]
    load_scene(asked(game, "/scene").decode())


@pytest.mark.parametrize(
    "body",
    [
        {}, [], "drop", {"what": "explode"}, {"what": "grasp", "one": -1, "x": 0, "y": 0},
        {"what": "drop", "name": "bead"}, {"what": "drop", "name": "bead", "x": "nan", "y": 0},
        {"what": "speed", "value": "fast"},
        {"what": "change", "part": "liquid", "key": "flow", "value": 1},
    ],
)  # fmt: skip
def test_nonsense_does_nothing_and_is_reported(game, body):
    assert json.loads(asked(game, "/do", body))["said"]
    assert len(json.loads(asked(game, "/now"))["x"]) == 3


def test_strangers_play_no_part(game):
    for path, body in (("/now", None), ("/scene", None), ("/do", {"what": "take", "one": 0})):
        with pytest.raises(urllib.error.HTTPError) as error:
            asked(game, path, body, token="guess")
        error.value.close()
        assert error.value.code == 403
    assert len(game[0].toy.moving.frame.arrays["radius"]) == 3


def test_it_pauses_and_goes_slower(game):
    asked(game, "/do", {"what": "speed", "value": 0})
    still = json.loads(asked(game, "/now"))["time"]
    time.sleep(0.2)
    assert json.loads(asked(game, "/now"))["time"] == still
