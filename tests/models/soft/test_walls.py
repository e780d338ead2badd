"""Walls: the exact law of a sphere at one, what they push at each other with, walls that move and walls that yield."""

import dataclasses
import functools
import math
from importlib.resources import files

import numpy as np
import pytest

from ecume.engine.linear_solvers.solvers import SOLVERS
from ecume.errors import SceneError
from ecume.laws.drag import stokes_friction
from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft import SOFT
from ecume.models.soft.cell import StageTarget
from ecume.models.soft.integration import newton
from ecume.models.soft.integration.dirk import first_stage
from ecume.models.soft.integration.time_stepping import one_step
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.state import CLOCK
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from tests.models import begun

from .clusters import integrated

FLOOR = {"side": "bottom", "position": 0.0}


def at_floor(dimensions=2, force=1e-3, gap=0.01, **more):
    """Two unit spheres above a floor, far from each other, pulled up."""
    places = [[x, 1.0 + gap, 0.0][:dimensions] for x in (0.0, 9.0)]
    plain = {
        "model": "soft", "duration": 60.0, "frame_every": 60.0, "liquid": {"viscosity": 1e-3}, "films": {"cutoff": 2.0},
        "particles": [{"radius": 1.0, "modulus": 1.0, "positions": places, "force": [0.0, force, 0.0][:dimensions]}],
        "walls": [FLOOR], "integration": {"tolerance": 1e-9},
    }  # fmt: skip
    return from_plain(plain | more)


def channel(walls, dimensions=2, count=8, **more):
    """Spheres between a floor and a ceiling, periodic along the other axes."""
    volume = count * sum(math.pi * r**2 if dimensions == 2 else 4 / 3 * math.pi * r**3 for r in (1.0, 1.3))
    side = (volume / (0.65 if dimensions == 2 else 0.4)) ** (1 / dimensions)
    plain = {
        "model": "soft", "duration": 4.0, "frame_every": 2.0, "liquid": {"viscosity": 1e-3},
        "particles": [{"radius": r, "modulus": 1.0, "count": count} for r in (1.0, 1.3)],
        "cell": {"size": [side] * dimensions, "minimum_gap": 0.02},
        "walls": [{"side": name} | walls.get(name, {}) for name in ("bottom", "top")],
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-4},
    }  # fmt: skip
    return from_plain(plain | more)


@pytest.mark.long
@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("modulus", [None, 3.0])
def test_a_sphere_leaves_a_wall_as_the_closed_form_has_it(modulus, dimensions):
    # A wall is a sphere without end: R* = R, that of two spheres of twice the radius; rigid, it leaves twice E.
    shared = 2.0 if modulus is None else 2.0 / (1.0 + 1.0 / modulus)
    pair = SoftPair(2.0, shared, 1e-3)
    end = passage_time(pair, 1e-3, 0.01, 0.2)
    wall = FLOOR if modulus is None else FLOOR | {"modulus": modulus}
    _, state = integrated(at_floor(dimensions, duration=end, frame_every=end, walls=[wall]))
    assert np.exp(state.wall_gap[:, 0]) == pytest.approx(np.full(2, 0.2), rel=1e-6)


def test_a_rigid_sphere_feels_six_pi_eta_r_squared_over_h():
    scene = at_floor(force=-1e-9, gap=0.02, duration=1e3, frame_every=1e3)
    _, state = integrated(scene)
    zeta = 6 * math.pi * 1e-3 / 0.02
    assert math.log(0.02) - state.wall_gap[0, 0] == pytest.approx(1e3 * 1e-9 / zeta / 0.02, rel=1e-3)


@pytest.mark.long
def test_the_floor_bears_all_that_pushes():
    frame = list(simulate(at_floor(force=-1e-3)))[-1]
    assert frame.numbers["bottom_force_y"] == pytest.approx(-2e-3, rel=1e-9)
    assert frame.numbers["bottom_force_x"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("rotation", [False, pytest.param(True, marks=pytest.mark.compiled)])
def test_a_moving_ceiling_drags_the_spheres_along_and_the_floor_holds_them(rotation):
    frames = list(simulate(channel({"top": {"velocity": [0.2, 0.0]}}, rotation=rotation)))
    numbers = frames[-1].numbers
    assert numbers["top_x"] == pytest.approx(0.8, rel=1e-12)
    assert numbers["top_force_x"] == pytest.approx(-numbers["bottom_force_x"], rel=1e-8)
    assert numbers["top_force_y"] == pytest.approx(-numbers["bottom_force_y"], rel=1e-8)
    assert numbers["top_force_x"] < 0.0
    speed, height = frames[-1].arrays["velocity"][:, 0], frames[-1].arrays["position"][:, 1]
    assert np.polyfit(height, speed, 1)[0] > 0.0
    assert speed.min() > -0.02
    assert speed.max() < 0.22


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.parametrize("dimensions", [pytest.param(2, marks=pytest.mark.long), 3])
def test_a_ceiling_yields_until_it_is_pushed_back_as_hard(dimensions):
    scene = channel({"top": {"pressure": 1e-3, "shear_stress": 2e-4}}, dimensions, frame_every=1.0, duration=2.0)
    area = math.prod(scene.cell.size[::2])
    frames = list(simulate(scene))
    for frame in frames:
        assert frame.numbers["top_force_y"] == pytest.approx(1e-3 * area, rel=1e-8)
        assert frame.numbers["top_force_x"] == pytest.approx(-2e-4 * area, rel=1e-8)
        assert frame.numbers["bottom_force_y"] == pytest.approx(-1e-3 * area, rel=1e-8)
    x, y = ([frame.numbers[f"top_{axis}"] for frame in frames] for axis in "xy")
    assert x[0] < x[1] < x[2]
    assert y[0] > y[1] > y[2]


@pytest.mark.compiled
@pytest.mark.long
def test_a_plate_is_sheared_by_a_step_of_stress_while_the_pressure_on_it_stays():
    """Creep between plates: at once, then slowly, and back in part when the stress is taken off."""
    protocol = [
        {"time": 0.0, "wall_shear": 0.0},
        {"time": 1.0, "wall_shear": 0.0},
        {"time": 1.0, "wall_shear": 1.0},
        {"time": 3.0, "wall_shear": 1.0},
        {"time": 3.0, "wall_shear": 0.0},
    ]
    top = {"pressure": 1e-3, "shear_stress": 2e-4}
    scene = channel({"top": top}, duration=4.0, frame_every=0.02, protocol=protocol)
    frames, width = list(simulate(scene)), scene.cell.size[0]
    x, pressed, sheared = (
        np.array([frame.numbers[name] for frame in frames]) for name in ("top_x", "top_force_y", "top_force_x")
    )
    assert pressed == pytest.approx(np.full(201, 1e-3 * width), rel=1e-8)
    assert sheared == pytest.approx(-2e-4 * width * np.repeat([0, 1, 0], [50, 100, 51]), abs=1e-8 * 2e-4 * width)
    # What happens at once, without what goes on evenly.
    leap, back = x[50] - 2.0 * x[49] + x[48], 2.0 * x[149] - x[148] - x[150]
    assert leap > 0.0
    assert back == pytest.approx(leap, rel=0.5)
    assert x[149] - x[50] > 10.0 * leap
    assert x[150] > x[200] > 0.5 * x[150]


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.parametrize(
    ("top", "bottom"),
    [({"velocity": [0.3, 0.0]}, {}), ({}, {"velocity": [-0.3, 0.0]})],
    ids=["it is sheared itself", "the other one is"],
)
def test_a_plate_that_is_pressed_down_rides_on_what_is_sheared_below(top, bottom):
    frames = list(simulate(channel({"top": top | {"pressure": 2e-3}, "bottom": bottom}, duration=3.0, frame_every=0.5)))
    width = channel({}).cell.size[0]
    numbers = [frame.numbers for frame in frames]
    for one in numbers:
        assert one["top_force_y"] == pytest.approx(2e-3 * width, rel=1e-8)
        assert one["bottom_force_y"] == pytest.approx(-2e-3 * width, rel=1e-8)
        assert one["top_force_x"] == pytest.approx(-one["bottom_force_x"], rel=1e-7, abs=1e-12)
    assert numbers[-1]["top_x"] - numbers[-1]["bottom_x"] == pytest.approx(0.9, rel=1e-12)
    # What is sheared pulls the top plate back, and as spheres climb each other it goes up and down.
    assert all(one["top_force_x"] < 0.0 for one in numbers[1:])
    assert np.ptp([one["top_y"] for one in numbers]) > 0.02


@pytest.mark.compiled
@pytest.mark.long
def test_two_plates_are_one_flow_whichever_of_them_goes():
    ends = []
    for walls in ({"top": {"velocity": [0.2, 0.0]}}, {"bottom": {"velocity": [-0.2, 0.0]}}):
        pressed = {
            name: walls.get(name, {}) | ({"pressure": 2e-3} if name == "top" else {}) for name in ("top", "bottom")
        }
        ends.append(list(simulate(channel(pressed, duration=0.5, frame_every=0.5)))[-1])
    one, other = (frame.numbers for frame in ends)
    assert one["top_y"] == pytest.approx(other["top_y"], rel=1e-7)
    assert one["top_force_x"] == pytest.approx(other["top_force_x"], rel=1e-4)
    moved = ends[0].arrays["position"] - ends[1].arrays["position"]
    width = channel({}).cell.size[0]
    moved[:, 0] -= np.round((moved[:, 0] - 0.1) / width) * width
    assert moved[:, 0] == pytest.approx(np.full(16, 0.1), abs=1e-6)


@pytest.mark.compiled
@pytest.mark.long
def test_a_wall_that_is_pushed_goes_as_the_one_that_is_moved_is_pushed_back():
    moved = list(simulate(channel({"top": {"velocity": [0.0, -0.02]}}, duration=2.0, frame_every=0.02)))
    width = channel({}).cell.size[0]
    load = [frame.numbers["top_force_y"] for frame in moved]
    table = [{"time": frame.time, "load": value} for frame, value in zip(moved, load, strict=True)]
    pushed = list(simulate(channel({"top": {"pressure": 1.0 / width}}, duration=2.0, frame_every=0.02, protocol=table)))
    for one, other in zip(moved[10::30], pushed[10::30], strict=True):
        gone, reached = (frame.numbers["top_y"] - moved[0].numbers["top_y"] for frame in (one, other))
        assert reached == pytest.approx(gone, rel=0.01)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("rotation", [False, True])
@pytest.mark.parametrize("top", [{}, {"pressure": 2e-3, "shear_stress": 5e-4}])
def test_newtons_method_doubles_its_digits_at_walls(monkeypatch, top, rotation, dimensions):
    scene = channel({"top": top}, dimensions, rotation=rotation, integration={"solver": "dense"}, count=5)
    parameters, _, scratch = begun(scene)
    step, drive = scratch.step, drive_at(parameters.protocol, 0.0)
    changes = []
    move = newton.move
    monkeypatch.setattr(newton, "move", lambda *given: changes.append(move(*given)) or changes[-1])
    parameters.weight[:] = 2e-4 * np.random.default_rng(1).normal(size=parameters.weight.shape)
    first_stage(parameters.contacts, step, drive)
    integrate = newton.newton_bordered if top else newton.newton_many
    solve = functools.partial(SOLVERS["dense" if top else "direct"], scratch.kept)
    assert integrate(solve, parameters.contacts, step, StageTarget(drive, drive, 0.02, 1e-13))
    if dimensions == 3 and rotation:  # Turns add up there as vectors, which they do for small ones only.
        assert changes[-1] < 1e-2 * changes[-2] < 1e-8
    else:
        small = [change for change in changes if change < 0.1]
        assert math.log(small[2]) < 1.7 * math.log(small[1])


@pytest.mark.compiled
@pytest.mark.long
def test_interruptions_change_no_bit_at_walls():
    scene = channel({"top": {"pressure": 1e-3, "shear_stress": 2e-3}}, rotation=True, duration=8.0, frame_every=8.0)
    whole, pieces = integrated(scene, parts=10**9)[1], integrated(scene, parts=2)[1]
    assert whole.generation[0] > 1
    for name, array in whole._asdict().items():
        assert getattr(pieces, name).tobytes() == array.tobytes(), name


@pytest.mark.long
def test_a_heavy_sphere_falls_at_stokes_speed_and_lies_on_the_floor_with_its_weight():
    plain = {
        "model": "soft", "duration": 40.0, "frame_every": 0.5,
        "liquid": {"viscosity": 1.0, "density": 1.0}, "hydrodynamics": {"drag": "stokes"},
        "films": {"cutoff": 0.2}, "gravity": [0.0, -10.0], "walls": [FLOOR], "integration": {"tolerance": 1e-6},
        "particles": [{"radius": 1.0, "modulus": 1e4, "density": 1.5, "positions": [[0.0, 2.5], [7.0, 4.0]]}],
    }  # fmt: skip
    weight = 4 / 3 * math.pi * 0.5 * 10.0
    frames = list(simulate(from_plain(plain)))
    assert frames[1].arrays["velocity"][:, 1] == pytest.approx(-weight / stokes_friction(1.0, 1.0, 1.0), rel=1e-9)
    assert frames[-1].numbers["bottom_force_y"] == pytest.approx(-2 * weight, rel=2e-2)
    heights = frames[-1].arrays["position"][:, 1]
    assert (heights < 1.001).all()
    assert (heights > 0.98).all()


@pytest.mark.compiled
@pytest.mark.long
def test_spheres_that_fall_beside_a_periodic_border_are_caught_however_long_a_step_could_be():
    scene = load_scene(files("ecume") / "templates" / "settling-packing.toml")
    scene = dataclasses.replace(scene, duration=2.0, frame_every=1.0)
    frames = list(simulate(scene))
    assert frames[-1].numbers["rejected_steps"] > 0
    assert (frames[-1].arrays["position"][:, 1] > 0.98e-3).all()
    weight = 4 / 3 * math.pi * (frames[0].arrays["radius"] ** 3).sum() * 400.0 * 9.81
    assert 0.1 * weight < -frames[-1].numbers["bottom_force_y"] < weight


def test_work_goes_into_surfaces_and_films_at_walls_too():
    scene = at_floor(force=-1e-3, gap=0.05, duration=20.0, frame_every=20.0)
    parameters, state, scratch = begun(scene)
    rows = []
    while state.pace[CLOCK] < 10.0:
        SOFT.observe(parameters, state, scratch)
        touches = scratch.step.walls.touches
        gap = np.exp(touches.log_gap)
        rows.append(
            (
                state.position[:, 1].sum(),
                gap.sum(),
                state.pace[CLOCK],
                (gap * touches.now[:, 0] * -touches.force[:, 1]).sum(),
            )
        )
        assert one_step(parameters, state, scratch) is not None
    place, gap, time, power = np.array(rows).T
    work = 1e-3 * (place[0] - place[-1])
    lost = 1e-3 * (gap[0] - gap[-1])
    assert (np.diff(time) * (power[1:] + power[:-1]) / 2).sum() == pytest.approx(lost, rel=1e-3)
    assert lost < work


REFUSED = [
    ({"walls": [{"side": "bottom"}]}, "position", "no [cell]"),
    ({"walls": [{"side": "back", "position": 0.0}]}, "side", "a layer has no back"),
    ({"walls": [FLOOR, FLOOR]}, "side", "appears twice"),
    ({"walls": [FLOOR | {"pressure": 1.0}]}, "pressure", "add that table"),
    ({"walls": [FLOOR | {"velocity": [0.0, 0.0, 0.0]}]}, "velocity", "got 3 components"),
    ({"gravity": [0.0, -9.8]}, "density", "gravity needs it"),
    ({"protocol": [{"time": 0.0, "wall_shear": 1.0}]}, "wall_shear", "multiplies the shear_stress of walls"),
]


@pytest.mark.parametrize(("change", "key", "says"), REFUSED)
def test_walls_and_weights_that_cannot_be_are_refused(change, key, says):
    with pytest.raises(SceneError) as caught:
        at_floor(**change)
    assert caught.value.faults[0].path.endswith(key)
    assert says in caught.value.faults[0].message


def test_what_lies_in_a_wall_or_hangs_in_the_middle_of_nowhere_is_refused():
    for gap, says in ((-0.5, "is in wall 0"), (4.0, "no film to any wall")):
        scene = at_floor(gap=gap)
        with pytest.raises(SceneError, match=says):
            SOFT.start(scene, SOFT.parameters(scene))
    with pytest.raises(SceneError, match="all walls yield along x"):
        channel({"top": {"shear_stress": 1.0}, "bottom": {"shear_stress": -1.0}})
    with pytest.raises(SceneError, match="without walls"):
        channel({}, protocol=[{"time": 0.0, "shear_rate": 1.0}])
