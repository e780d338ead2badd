"""A tank that is played with is the simulated one, whatever hands do to it, and can be saved as a scene."""

import base64
import contextlib
import dataclasses
import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import ecume
from ecume.cli import app
from ecume.errors import BadInput
from ecume.scenes.load import load_scene
from ecume.scenes.sph import GaugeSpec, ObstacleSpec
from ecume.scenes.templates import folder
from ecume.scenes.writing import to_toml
from ecume.show.play import tank as playing
from ecume.show.play.pages import game_of
from ecume.show.play.tank import ANEW, CALMED, HURRY, MOST, PUSHED, STEEPEST, Push, Tank, tilting

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]
COARSE = ["spacing=8 cm", "obstacles=[{low = [0.72, 0.0], high = [1.04, 1.0]}]", "fluid[1].low=[1.04, 0.0]"]


def scene_of(*changes):
    return load_scene((folder() / "small-tank.toml").read_text(), [*COARSE, *changes])


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """However slow the machine, it goes as far as it is asked to."""
    monkeypatch.setattr(playing, "BUDGET", 1e3)


@pytest.fixture
def tank():
    return Tank(scene_of())


def play(tank, seconds):
    end = tank.time + seconds
    while tank.time < end:
        tank.play(1 / 60)


def places_of(tank):
    return tank.liquid().position.T


def mass(tank):
    return float(tank.liquid().mass.sum())


def simulated(scene, tank):
    """The last of the same steps, by the plain way."""
    step = tank.integration.parameters.time_step
    span = f"{round(tank.time / step) * step!r}"
    text = to_toml(scene)
    return list(
        ecume.simulate(load_scene(text, [f"integration.time_step={step}", f"duration={span}", f"frame_every={span}"]))
    )[-1]


def test_left_alone_it_goes_as_the_simulation_does(tank):
    play(tank, 0.2)
    last = simulated(tank.first, tank)
    assert places_of(tank) == pytest.approx(last.arrays["position"], abs=1e-9)
    assert last.numbers["largest_speed"] > 0.0


def test_a_push_is_the_motion_of_the_side(tank):
    rows = [(0.0, 0.0)]
    for tick in range(20):
        tank.drag(0.5 if tick < 8 else 0.1)
        tank.play(1 / 60)
        ends = [time for time in tank.push.times if rows[-1][0] + 1e-9 < time < tank.time - 1e-9]
        rows += [(time, tank.push.at(time)) for time in (*ends, tank.time)]
    times, places = (list(column) for column in zip(*rows, strict=True))
    speeds = np.diff(places) / np.diff(times)
    assert 0.9 < speeds.max() <= HURRY * 4.0 * (1 + 1e-9)
    assert speeds[-1] < 0.0
    motion = f"tank.left.motion={{ times = {times}, positions = {places} }}"
    last = simulated(load_scene(to_toml(tank.first), [motion]), tank)
    # Where a straight line ends, one sum of the played tank knows the speed before it, of the other that after it: a
    # twentieth of a spacing may come of that.
    assert places_of(tank) == pytest.approx(last.arrays["position"], abs=0.05 * 0.08)
    assert tank.liquid().position[0].min() > tank.pushed - 0.01


@pytest.mark.long
def test_liquid_that_is_pressed_together_is_not_thrown(tank):
    """The scene expects 4 m/s. With steps of 0.45 instead of 0.35 rho/(zeta k^2) of the damping it is 12 m/s."""
    tank.open_gate()
    tank.pour(2.0, 1.1)
    tank.drag(0.2)
    tank.lean(0.2)
    fastest = []
    while tank.time < 1.5:
        tank.play(1 / 60)
        fastest.append(np.hypot(*tank.liquid().velocity).max())
    assert 3.0 < max(fastest) < 5.0


@pytest.mark.long
def test_a_hand_pushes_no_farther_than_it_may_and_a_wave_comes_back(tank):
    tank.drag(9.0)
    play(tank, 2.0)
    assert tank.pushed == pytest.approx(PUSHED * 2.4, rel=1e-4)
    farthest = []
    tank.drag(0.0)
    play(tank, 1.5)
    tank.wave()
    while tank.time < tank.wave_since + tank.period + 1.0:
        tank.play(1 / 60)
        farthest.append(tank.pushed)
    assert max(farthest) == pytest.approx(0.24, rel=0.05)
    assert tank.pushed == pytest.approx(0.0, abs=1e-3)


def test_a_push_goes_on_evenly_and_forgets_what_was_before_the_lists():
    push = Push(speed=1.0)
    for now in (0.0, 0.1, 0.2, 0.3):
        push = push.then(now, 0.1, 1.0, max(0.0, now - 0.15))
    assert push.times[0] == pytest.approx(0.15)
    assert push.times[-1] == pytest.approx(0.5)
    assert push.places == pytest.approx(push.times)
    faster = push.then(0.35, 0.1, 3.0, 0.35)
    assert faster.times[0] == 0.35
    assert faster.at(0.45) - faster.at(0.35) == pytest.approx(0.1 * 2.0)
    assert np.diff(faster.places)[-1] / np.diff(faster.times)[-1] == pytest.approx(3.0)
    assert (np.diff(faster.places) / np.diff(faster.times))[:-1] == pytest.approx(1.0 + 2.0 * (np.arange(8) + 0.5) / 8)


def test_what_is_poured_adds_its_mass_and_falls(tank):
    before, count = mass(tank), tank.count
    tank.pour(2.0, 0.9)
    more = tank.count - count
    assert more > 15
    assert mass(tank) - before == pytest.approx(more * 1000.0 * 0.08**2)
    high = tank.liquid().position[1, -more:]
    assert np.abs(high - 0.9).max() <= 0.2
    play(tank, 0.2)
    fallen = high - tank.liquid().position[1, -more:]
    assert fallen == pytest.approx(0.5 * 9.81 * tank.time**2, abs=0.01)


@pytest.mark.parametrize("place", [(0.3, 0.3), (0.88, 0.5), (3.5, 0.5), (1.5, -1.0)])
def test_where_there_is_no_room_nothing_is_poured(tank, place):
    before = tank.count
    with pytest.raises(BadInput, match="no room for liquid here"):
        tank.pour(*place)
    assert tank.count == before


def test_a_full_tank_is_not_poured_into(tank, monkeypatch):
    monkeypatch.setattr(playing, "MOST", tank.count + 5)
    with pytest.raises(BadInput, match="scoop out some liquid"):
        tank.pour(2.0, 0.9)


def test_what_is_scooped_is_gone_and_the_last_of_it_stays(tank):
    before = tank.liquid()
    tank.scoop(1.8, 0.1)
    after = tank.liquid()
    assert tank.count < before.position.shape[1]
    assert np.hypot(after.position[0] - 1.8, after.position[1] - 0.1).min() > 4 * 0.08
    with pytest.raises(BadInput, match="no liquid here"):
        tank.scoop(2.0, 1.1)
    while np.ptp(tank.liquid().position, axis=1).max() > 0.5:
        tank.scoop(*max(places_of(tank).tolist()))
    with pytest.raises(BadInput, match="the last of it stays"):
        tank.scoop(*places_of(tank).mean(axis=0))


def test_a_gate_holds_the_column_until_it_is_opened(tank):
    play(tank, 0.2)
    column = tank.liquid().region == 0
    assert tank.liquid().position[0, column].max() < 0.72
    tank.open_gate()
    play(tank, 0.3)
    assert tank.liquid().position[0, column].max() > 1.0
    with pytest.raises(BadInput, match="no gate"):
        tank.open_gate()


def test_a_basin_is_no_gate(tank):
    """A drawn tank is a hollow obstacle: without it the liquid would fall out of it."""
    corners = ((0.02, 0.02), (1.9, 0.02), (1.9, 1.4), (0.02, 1.4))
    basin = ObstacleSpec(name="tank", vertices=corners, hollow=True)
    tank.first = dataclasses.replace(tank.first, obstacles=(basin, *tank.first.obstacles))
    assert [solid.name for solid in tank._obstacles(1)] == ["tank"]
    assert tank._obstacles(0) == tank.first.obstacles
    tank.scene = dataclasses.replace(tank.first, obstacles=(basin,))
    with pytest.raises(BadInput, match="no gate to open"):
        tank.open_gate()


@pytest.mark.long
def test_a_gate_that_closes_pushes_aside_who_stands_there_and_holds_again(tank):
    with pytest.raises(BadInput, match="no gate to close"):
        tank.close_gate()
    tank.open_gate()
    tank.lean(-STEEPEST)
    play(tank, 0.6)
    before = tank.liquid()
    tank.close_gate()
    after = tank.liquid()
    assert np.array_equal(after.mass, before.mass)
    assert np.array_equal(after.region, before.region)
    moved = np.flatnonzero((after.position != before.position).any(axis=0))
    in_the_way = (before.position[0] > 0.72 - 0.02) & (before.position[0] < 1.04 + 0.02) & (before.position[1] < 1.02)
    assert np.array_equal(moved, np.flatnonzero(in_the_way))
    assert len(moved) > 10
    assert not after.velocity[:, moved].any()
    left = after.position[0] < 0.88
    apart = np.hypot(*(after.position[:, moved, None] - after.position[:, None])) > 0.8 * 0.08 - 1e-12
    assert np.count_nonzero(~apart) == len(moved), "each is that near to itself alone"
    tank.lean(0.0)
    play(tank, 1.0)
    x, y = tank.liquid().position
    assert np.array_equal(x < 0.88, left), "nobody comes through"
    assert not ((x > 0.72) & (x < 1.04) & (y < 1.0)).any()
    assert np.count_nonzero(left) / 0.72 > 1.2 * np.count_nonzero(~left) / (2.4 - 1.04), "it stands higher at the left"
    assert tank.news == []
    assert tank.opened == 0


def test_a_gate_stays_open_where_there_is_no_room_for_what_stands_there(tank, monkeypatch):
    tank.open_gate()
    play(tank, 0.3)
    before = places_of(tank)
    monkeypatch.setattr(playing, "ROOM", 99.0)
    with pytest.raises(BadInput, match="the liquid at the gate has no room"):
        tank.close_gate()
    assert np.array_equal(places_of(tank), before)
    assert tank.opened == 1


def test_a_tilt_turns_gravity_and_the_liquid_goes_down(tank):
    scene = tank.first
    for angle in (0.1, -0.3):
        pull = np.array(scene.gravity) + tilting(scene, angle)
        assert np.hypot(*pull) == pytest.approx(9.81)
        assert math.atan2(pull[0], -pull[1]) == pytest.approx(angle)
    pool = tank.liquid().region == 1
    before = tank.liquid().position[0, pool].mean()
    tank.lean(9.0)
    play(tank, 0.3)
    assert 0.8 * STEEPEST < tank.leaning < STEEPEST
    assert tank.liquid().position[0, pool].mean() > before + 0.01


def test_a_tank_that_is_put_back_leans_no_more(tank):
    for angle in (5e-6, 0.0):
        tank.lean(angle)
        tank.play(1 / 60)
        assert tank.leaning == angle
    assert tank.present().base_excitation is None


def test_the_saved_scene_goes_on_from_here(tank):
    tank.open_gate()
    tank.pour(2.0, 1.1)
    tank.drag(0.2)
    tank.lean(0.2)
    play(tank, 1.0)
    tank.tilt = tank.leaning
    tank.integration.state.position[1, 0] = 1.3  # a splash above the open top
    scene = load_scene(to_toml(tank.present()))
    first, liquid = next(iter(ecume.simulate(scene))), tank.liquid()
    order = np.argsort(liquid.region, kind="stable")
    for name in ("position", "velocity", "density", "mass", "region"):
        mine = getattr(liquid, name)[..., order].T
        assert np.array_equal(first.arrays["species" if name == "region" else name], mine), name
    assert scene.fluid[0].color == "#1f77b4"
    assert scene.tank.low[0] == pytest.approx(tank.pushed)
    tank.drag(tank.pushed)
    tank.time = 0.0
    tank.integration.state.ready[0] = 0  # the scene begins with the forces beside a side at rest; here it still moved
    tank.play(1 / 60)
    assert places_of(tank)[order] == pytest.approx(simulated(scene, tank).arrays["position"], abs=1e-3)


def test_a_gauge_in_the_wall_is_not_saved(tank):
    """A scene with a gauge outside of its tank cannot be loaded."""
    gauges = (
        GaugeSpec(name="near", position=(0.05, 0.3)),
        GaugeSpec(name="far", position=(0.05, 0.2), end=(2.0, 0.2), count=2),
    )
    tank.scene = dataclasses.replace(tank.scene, gauges=(*gauges, GaugeSpec(name="in", position=(0.5, 0.3))))
    assert len(tank.present().gauges) == 3
    tank.push = Push(places=(0.1,))
    assert [gauge.name for gauge in load_scene(to_toml(tank.present())).gauges] == ["in"]


def test_a_full_tank_can_be_saved_and_read_again(tank):
    liquid = tank.liquid()
    many = np.arange(MOST) % tank.count
    tank._go_on(type(liquid)(*(np.ascontiguousarray(part[..., many]) for part in liquid)))
    assert len(load_scene(to_toml(tank.present())).fluid) == 2


def test_liquid_that_diverges_is_brought_to_rest_and_then_begins_again(tank):
    tank.open_gate()
    play(tank, 0.1)
    before, then = tank.liquid(), tank.time
    tank.integration.state.velocity[:, 0] = np.nan
    tank.play(1 / 60)
    assert tank.news == [CALMED]
    assert tank.liquid().position == pytest.approx(before.position)
    assert not tank.liquid().velocity.any()
    assert tank.time == then
    tank.integration.state.velocity[:, 0] = np.nan
    tank.play(1 / 60)
    assert tank.news == [CALMED, ANEW]
    assert len(tank.scene.obstacles) == 1
    play(tank, 0.1)
    assert len(tank.news) == 2


@pytest.mark.parametrize(
    ("name", "changes", "says"),
    [
        ("dam-break-3d", [], "expected a 2D scene"),
        ("bouncing-particles", [], "scene of model 'tracers'"),
        ("floating-bodies", [], "this one has bodies"),
        ("channel", [], "in- or outflows"),
        ("sloshing", [], r"this one has \[base_excitation\]"),
    ],
)
def test_only_tanks_of_liquid_are_played_with(name, changes, says):
    with pytest.raises(BadInput, match=says):
        game_of(load_scene((folder() / f"{name}.toml").read_text(), changes))


def test_its_page_receives_all_places_and_obeys(tank):
    game = game_of(scene_of())
    said = [json.loads(game.post("/do", json.dumps(body).encode()).content)["said"] for body in ASKED]
    assert [bool(text) for text in said] == REFUSED
    reported = json.loads(game.get("/now", {}).content)
    tank = game.toy.moving
    places = np.frombuffer(base64.b64decode(reported["places"]), "<u2").reshape(-1, 2) / 65535.0
    low, high = np.array([0.0, 0.0]), np.array([2.4, 1.2 * 1.35])
    assert low + places * (high - low) == pytest.approx(tank.liquid().position.T, abs=1e-4)
    assert reported["coloring"] == "pressure"
    assert reported["solids"] == []
    assert reported["opened"] == 1
    load_scene(game.get("/scene", {}).content.decode())


ASKED = [
    {"what": "pour", "x": 2.0, "y": 0.9}, {"what": "scoop", "x": 0.1, "y": 0.1}, {"what": "open"}, {"what": "open"},
    {"what": "close"}, {"what": "close"}, {"what": "open"},
    {"what": "drag", "x": 0.1}, {"what": "wave"}, {"what": "lean", "angle": 0.1}, {"what": "color", "name": "pressure"},
    {"what": "color", "name": "taste"}, {"what": "pour", "x": "nan", "y": 0}, {"what": "freeze"},
]  # fmt: skip
REFUSED = [False, False, False, True, False, True, False, False, False, False, False, True, True, True]


def test_where_there_is_no_wall_nothing_is_pushed():
    tank = Tank(scene_of('tank.walls="dummy"'))
    with pytest.raises(BadInput, match="not a movable wall"):
        tank.drag(0.1)
    with pytest.raises(BadInput, match="not a movable wall"):
        tank.wave()


def test_the_command_line_plays_with_a_tank_of_its_own_or_with_a_scene_but_not_with_both(monkeypatch):
    played = []
    monkeypatch.setattr("ecume.show.play.pages.Game.run", lambda game: played.append(game.toy.moving))
    monkeypatch.setattr("ecume.cli.browser.offered", lambda address, what: contextlib.nullcontext(address))
    both = CliRunner().invoke(app, ["play", "--tank", "mine.toml"])
    assert both.exit_code == 2
    assert "expected one of them" in both.output
    waited = []
    monkeypatch.setattr("ecume.cli.browser._wait", lambda: waited.append(True))
    coarse = [word for change in COARSE for word in ("--set", change)]
    assert CliRunner().invoke(app, ["play", "--tank", *coarse]).exit_code == 0
    assert (waited, played) == ([True], [])  # the page simulates it, but no viscous liquid
    made = CliRunner().invoke(app, ["play", "--tank", *coarse, "--set", "liquid.viscosity=1.0"])
    assert made.exit_code == 0, made.output
    assert (waited, played[0].scene.spacing) == ([True], 0.08)


def test_a_page_is_saved_instead_of_opened_unless_pages_cannot_simulate_the_scene(tmp_path):
    coarse = [word for change in COARSE for word in ("--set", change)]
    target = tmp_path / "tank.html"
    saved = CliRunner().invoke(app, ["play", "--tank", "--save", str(target), *coarse])
    assert saved.exit_code == 0, saved.output
    assert target.read_text(encoding="utf-8").startswith("<!doctype html>")
    target.unlink()
    viscous = CliRunner().invoke(app, ["play", "--tank", "--save", str(target), *coarse, "--set", "liquid.viscosity=1"])
    assert viscous.exit_code == 2
    assert "viscosity" in viscous.output
    assert not target.exists()
