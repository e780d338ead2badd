"""A box that answers to stresses: they are met, work goes where it should, and the strain is that of the stress."""

import dataclasses
import functools
import math

import numpy as np
import pytest

from ecume.analysis.rheology import stress_tensor
from ecume.engine.linear_solvers.solvers import SOLVERS
from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.models.soft.cell import StageTarget
from ecume.models.soft.integration import dirk, newton
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.integration.linear_solvers import balance
from ecume.models.soft.integration.time_stepping import one_step
from ecume.models.soft.protocol import Drive, at_frames, drive_at, next_turn, protocol_of
from ecume.models.soft.state import ACCEPTED, CLOCK
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.soft import RateStepsSpec, StageSpec
from ecume.simulation import simulate
from tests.models import begun

from .clusters import integrated
from .test_packings import packing, solved_by

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]

SHEAR, NORMAL = 2e-4, 1e-3
BOTH = [{"time": 0.0, "shear_stress": SHEAR, "normal_stress": NORMAL}]


def stressed(protocol, duration=4.0, frames=2, **more):
    return packing(filled=0.8, duration=duration, frame_every=duration / frames, protocol=protocol, **more)


def numbers(scene, *names):
    return np.array([[frame.numbers[name] for name in names] for frame in simulate(scene)]).T


@pytest.mark.long
@pytest.mark.parametrize(
    ("protocol", "met"),
    [
        ([{"time": 0.0, "shear_stress": SHEAR}], {"shear_stress": SHEAR}),
        (BOTH, {"shear_stress": SHEAR, "normal_stress": NORMAL}),
        ([{"time": 0.0, "shear_rate": 0.02, "normal_stress": NORMAL}], {"normal_stress": NORMAL}),
        ([{"time": 0.0, "shear_stress": SHEAR, "pressure": NORMAL}], {"shear_stress": SHEAR, "pressure": NORMAL}),
    ],
)
@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_stress_that_is_imposed_is_that_of_the_packing_from_the_first_instant_on(protocol, met, dimensions):
    given = {"dimensions": dimensions, "filled": 0.8 if dimensions == 2 else 0.55}
    for frame in simulate(packing(**given, duration=1.0, frame_every=0.5, protocol=protocol)):
        for name, value in met.items():
            assert frame.numbers[name] == pytest.approx(value, rel=1e-8)
    assert (frame.numbers["strain"] > 0.0) == ("shear_stress" in met or "shear_rate" in protocol[0])
    assert (frame.numbers["box_height"] < packing(**given).cell.size[1]) == (len(met) > 1 or "normal_stress" in met)


@pytest.mark.long
def test_a_pressure_moves_all_sides_alike_and_a_normal_stress_the_height_alone():
    for name, same in (("pressure", True), ("normal_stress", False)):
        width, height = numbers(stressed([{"time": 0.0, name: NORMAL}]), "box_width", "box_height")
        assert height[-1] < height[0]
        assert width[-1] == pytest.approx(height[-1] if same else width[0], rel=1e-12)


@pytest.mark.long
def test_the_stress_that_a_strain_took_gives_the_strain_back():
    strained = packing(filled=0.8, strain=0.1, duration=10.0, frame_every=0.1)
    frames = list(simulate(strained))
    table = [{"time": frame.time, "shear_stress": frame.numbers["shear_stress"]} for frame in frames[10:]]
    there = [{"time": 0.0}, {"time": 1.0, "strain": 0.01}, *table]
    back = list(simulate(packing(filled=0.8, duration=10.0, frame_every=0.1, protocol=there)))
    for one, other in zip(frames[10::15], back[10::15], strict=True):
        assert other.numbers["strain"] == pytest.approx(one.numbers["strain"], rel=1e-3)


@pytest.mark.long
def test_spheres_that_spin_make_a_symmetric_stress():
    frame = list(simulate(stressed(BOTH, rotation=True)))[-1]
    tensor = stress_tensor(frame)
    assert tensor[1, 0] == pytest.approx(tensor[0, 1], rel=1e-8)
    assert tensor[0, 1] == pytest.approx(SHEAR, rel=1e-8)
    still = list(simulate(stressed(BOTH)))[-1]
    assert abs(stress_tensor(still)[1, 0] - SHEAR) > 0.01 * SHEAR
    assert frame.numbers["strain"] > still.numbers["strain"]


@pytest.mark.long
def test_every_solver_finds_the_same_creep_in_as_many_steps():
    scene = stressed(BOTH, duration=1.0)
    ends = [integrated(solved_by(scene, solver))[1] for solver in ("dense", "iterative", "direct")]
    for end in ends[1:]:
        assert end.cell == pytest.approx(ends[0].cell, abs=1e-7)
        assert end.tally[ACCEPTED] == pytest.approx(ends[0].tally[ACCEPTED], abs=2)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("rotation", [False, True])
def test_newtons_method_doubles_its_digits_with_the_stresses_in(monkeypatch, rotation, dimensions):
    given = {"dimensions": dimensions, "filled": 0.8 if dimensions == 2 else 0.55, "rotation": rotation}
    scene = solved_by(packing(**given, duration=1.0, protocol=BOTH), "dense")
    parameters, state, scratch = begun(scene)
    step, drive = scratch.step, drive_at(parameters.protocol, 0.0)
    changes = []
    move = newton.move
    monkeypatch.setattr(newton, "move", lambda *given: changes.append(move(*given)) or changes[-1])
    at = (drive, drive._replace(shear_stress=3e-4, normal_stress=1.2e-3), (1, 0, 1, 0))
    assert balance(parameters, scratch, at, state.effort)
    dirk.begin_stage(step, SCHEMES["tr-bdf2"].tableau, 1, 0.1)
    changes.clear()
    dirk.first_stage(parameters.contacts, step, drive)
    goal = StageTarget(drive._replace(shear_stress=3e-4), drive, 0.5, 1e-13)
    assert newton.newton_bordered(functools.partial(SOLVERS["dense"], scratch.kept), parameters.contacts, step, goal)
    assert math.log(changes[3]) / math.log(changes[2]) > 1.8


def test_the_work_of_the_stresses_is_that_of_all_forces_on_surfaces_and_films():
    scene = stressed(BOTH, duration=1.0, integration={"tolerance": 1e-8})
    parameters, state, scratch = begun(scene)
    rows = [deflections(parameters, state, scratch)]
    while state.pace[CLOCK] < 0.3:
        assert one_step(parameters, state, scratch) is not None
        rows.append(deflections(parameters, state, scratch))
    time, strain, volume, power, force, deflection = (np.array(column) for column in zip(*rows, strict=True))
    middle = (volume[1:] + volume[:-1]) / 2
    work = SHEAR * (middle * np.diff(strain)).sum() - NORMAL * (volume[-1] - volume[0])
    lost = (np.diff(time) * (power[1:] + power[:-1]) / 2).sum()
    bent = ((force[1:] + force[:-1]) / 2 * np.diff(deflection, axis=0)).sum()
    assert min(lost, bent) > 0.1 * work
    assert work == pytest.approx(lost + bent, rel=1e-3)


def deflections(parameters, state, scratch):
    """Time, strain, volume, the power lost in films, and force and deflection of each contact."""
    frame = SOFT.observe(parameters, state, scratch)
    step = scratch.step
    gap = np.exp(step.log_gap)
    flow = (gap * step.responses.slope[:, 0])[:, None] * step.direction
    flow += (gap + step.pairs.radius_sum)[:, None] * step.responses.slope[:, 1:]
    between = step.bodies.position[step.pairs.second] - step.bodies.position[step.pairs.first]
    between = between + step.pairs.offset[:, :2] - ((gap + step.pairs.radius_sum)[:, None] * step.direction)[:, :2]
    volume = frame.numbers["box_width"] * frame.numbers["box_height"]
    force = step.responses.force.copy()
    return frame.time, frame.numbers["strain"], volume, float((force * flow).sum()), force[:, :2], between


@pytest.mark.long
def test_creep_is_the_same_in_other_units():
    scene = stressed(BOTH, duration=2.0)
    length, pressure, time = 1e-3, 1e4, 7.0
    other = to_plain(scene)
    for species in other["particles"]:
        species |= {"radius": species["radius"] * length, "modulus": pressure}
    other["cell"] = {"size": [side * length for side in scene.cell.size], "minimum_gap": 0.02 * length}
    other["liquid"] = {"viscosity": scene.liquid.viscosity * pressure * time}
    other |= {"duration": 2.0 * time, "frame_every": time}
    # In a layer a modulus resists over a depth of a contact's size: stress is force over length.
    stress = pressure * length
    other["protocol"] = [{"time": 0.0, "shear_stress": SHEAR * stress, "normal_stress": NORMAL * stress}]
    one, two = (integrated(scene_)[1] for scene_ in (scene, from_plain(other)))
    assert two.cell == pytest.approx(one.cell, abs=1e-9)


@pytest.mark.long
def test_interruptions_change_no_bit_of_a_creep_with_steps():
    protocol = [
        {"time": 0.0, "shear_stress": 0.0, "normal_stress": NORMAL},
        {"time": 1.0, "shear_stress": 0.0},
        {"time": 1.0, "shear_stress": SHEAR},
        {"time": 3.0, "shear_rate": 0.01},
    ]
    scene = stressed(protocol)
    whole, pieces = integrated(scene, parts=10**9)[1], integrated(scene, parts=2)[1]
    for name, array in whole._asdict().items():
        assert getattr(pieces, name).tobytes() == array.tobytes(), name
    assert whole.cell_rate[4] == 0.01


@pytest.mark.long
def test_a_step_of_stress_is_met_at_once_by_the_surfaces_and_then_creeps():
    protocol = [
        {"time": 0.0, "shear_stress": 0.0},
        {"time": 1.0},
        {"time": 1.0, "shear_stress": SHEAR},
        {"time": 3.0},
        {"time": 3.0, "shear_stress": 0.0},
    ]
    strain, stress = numbers(stressed(protocol, 5.0, frames=500), "strain", "shear_stress")
    assert stress == pytest.approx(np.repeat([0.0, SHEAR, 0.0], [100, 200, 201]), abs=1e-8 * SHEAR)
    assert np.abs(strain[:100]).max() < 1e-3 * strain[100]
    leap, back = strain[100] - strain[99], strain[299] - strain[300]
    assert strain[299] > 1.5 * strain[100] > 0
    assert back == pytest.approx(leap, rel=0.25)
    assert strain[300] > strain[500] > 0.1 * strain[300]


@pytest.mark.long
def test_a_strain_or_a_stress_oscillates_as_asked_and_the_other_lags():
    wave = {"frequency": 0.5, "amplitude": 1e-3}
    strain, stress = numbers(stressed([{"time": 0.0, "oscillation": wave}], 4.0, frames=80), "strain", "shear_stress")
    phase = np.pi * np.linspace(0.0, 4.0, 81)
    assert strain == pytest.approx(1e-3 * np.sin(phase), abs=1e-15)
    elastic, viscous = (2 * (stress[41:] * f(phase[41:])).mean() for f in (np.sin, np.cos))
    assert elastic > 0 < viscous
    wave = {"frequency": 0.5, "stress": SHEAR}
    scene = stressed([{"time": 0.0, "shear_stress": 0.0, "oscillation": wave}], 4.0, frames=80)
    strain, stress = numbers(scene, "strain", "shear_stress")
    assert stress == pytest.approx(SHEAR * np.sin(phase), abs=1e-8 * SHEAR)
    lag = np.angle((strain[41:] * np.exp(1j * phase[41:])).sum() / (stress[41:] * np.exp(1j * phase[41:])).sum())
    assert 0.0 < lag < np.pi / 2


def test_a_rate_is_that_of_the_box_as_it_stands():
    protocol = [{"time": 0.0, "shear_rate": 0.1, "height_rate": 0.05}]
    tilt, height, strain = numbers(stressed(protocol, 2.0, frames=1), "box_tilt", "box_height", "strain")
    begin = height[0]
    assert strain[1] == pytest.approx(0.2, rel=1e-12)
    assert height[1] == pytest.approx(begin * math.exp(0.1), rel=1e-12)
    assert tilt[1] == pytest.approx(0.1 * begin * (math.exp(0.1) - 1.0) / 0.05, rel=1e-6)


def test_what_follows_a_stress_is_held_where_it_got():
    protocol = [
        {"time": 0.0, "shear_stress": SHEAR, "normal_stress": NORMAL},
        {"time": 1.0, "shear_rate": 0.0, "height_rate": 0.0},
        {"time": 2.0, "strain": 0.0},
    ]
    with pytest.raises(SceneError, match="answered to a shear_stress"):
        stressed(protocol)
    strain, height, stress = numbers(stressed(protocol[:2], 4.0, frames=4), "strain", "box_height", "shear_stress")
    assert strain[1] == strain[-1] > 0
    assert height[1] == height[-1]
    assert SHEAR > stress[2] > stress[-1] > 0


def test_a_sheared_box_with_drag_drags_along_its_flow():
    """Without contacts spheres go with the liquid: in a box that is sheared by a rate, and one that is stretched."""
    plain = {
        "model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1.0},
        "hydrodynamics": {"drag": "stokes"},
        "films": {"cutoff": 0.1}, "cell": {"size": [10.0, 10.0]},
        "particles": [{"radius": 1.0, "modulus": 1.0, "positions": [[2.0, 2.0], [7.0, 8.0]]}],
        "protocol": [{"time": 0.0, "shear_rate": 0.1, "height_rate": 0.05}],
    }  # fmt: skip
    end = integrated(from_plain(plain))[1].position
    for (x, y), place in zip([(2.0, 2.0), (7.0, 8.0)], end, strict=True):
        assert place[1] == pytest.approx(y * math.exp(0.05), rel=1e-7)
        assert place[0] == pytest.approx(x + 0.1 * y * (math.exp(0.05) - 1.0) / 0.05, rel=1e-7)


PROTOCOLS = [
    ([{"time": 0.0, "shear_stress": 1.0, "shear_rate": 1.0}], "shear_stress", "given together with shear_rate"),
    ([{"time": 0.0, "normal_stress": 1.0, "pressure": 1.0}], "pressure", "given together with normal_stress"),
    ([{"time": 0.0, "shear_stress": "5 Pa"}], "shear_stress", "expected N/m in 2D"),
    ([{"time": 0.0, "pressure": 1.0}, {"time": 1.0, "scale": 0.9}], "scale", "answered to a stress"),
    ([{"time": 0.0, "shear_rate": 1.0}, {"time": 1.0, "strain": 3.0}], "strain", "a shear_rate rules"),
    ([{"time": 0.0, "oscillation": {"frequency": 1.0}}], "oscillation", "expected either amplitude"),
    ([{"time": 0.0, "oscillation": {"frequency": 1.0, "stress": 1.0}}], "stress", "no shear_stress is imposed"),
    (
        [{"time": 0.0, "oscillation": {"frequency": 1.0, "amplitude": 0.1}}, {"time": 1.5}],
        "frequency", "makes 1.5 cycles",
    ),
    ([{"time": 0.0, "shear_rate": 1.0, "rate_steps": {"rates": [1.0], "strain": 0.1}}], "rate_steps", "shear_rate"),
    ([{"time": 0.0, "rate_steps": {"rates": [1.0, 0.0], "strain": 0.1}}], "rates[1]", "reaches no strain"),
    (
        [{"time": 0.0, "rate_steps": {"rates": [2.0, -1.0], "strain": 0.2}}, {"time": 0.25, "shear_rate": 0.0}],
        "time", "end at 0.3 s",
    ),
    ([{"time": 0.0, "rate_steps": {"rates": [1e-3], "strain": 0.2}}], "rate_steps", "end at 200 s"),
    (
        [{"time": 0.0, "rate_steps": {"rates": [2.0, 1.0], "strain": 0.2}}, {"time": 0.4, "strain": 3.0}],
        "[1].strain", "a shear_rate rules",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("protocol", "key", "says"), PROTOCOLS)
def test_protocols_that_contradict_themselves_are_refused(protocol, key, says):
    with pytest.raises(SceneError) as caught:
        packing(protocol=protocol)
    fault = caught.value.faults[0]
    assert says in fault.message
    assert fault.path.startswith(("protocol[0]", "protocol[1]"))
    assert key in fault.path


def test_a_protocol_goes_evenly_jumps_at_doubled_times_and_keeps_what_is_left_out():
    protocol = protocol_of([
        StageSpec(time=0.0, strain=0.1),
        StageSpec(time=2.0, strain=0.3, load=3.0),
        StageSpec(time=2.0, strain=0.5, shear_rate=0.1),
        StageSpec(time=4.0, normal_stress=2.0),
        StageSpec(time=6.0, normal_stress=4.0),
    ])  # fmt: skip

    def at(time, interval=None):
        return drive_at(protocol, time, interval)

    assert at(1.0)[:2] == pytest.approx((2.0, 0.2))
    assert at(2.0, 0).strain == pytest.approx(0.3)
    assert at(2.0).strain == pytest.approx(0.5)
    assert at(3.0)[:3] == pytest.approx((3.0, 0.6, 0.1))
    assert at(5.0).normal_stress == pytest.approx(3.0)
    assert at(9.0)[:3] == pytest.approx((3.0, 1.2, 0.1))
    assert protocol.jumps.tolist()[1:] == [1, 1, 0]
    assert isinstance(at(0.0), Drive)


def test_rate_steps_hold_each_rate_for_one_strain_and_then_the_last():
    steps = RateStepsSpec(rates=(2.0, -0.5, 1.0), strain=0.4)
    protocol = protocol_of([StageSpec(time=0.0, shear_rate=1.0), StageSpec(time=1.0, rate_steps=steps, load=3.0)])
    assert protocol.times == pytest.approx([0.0, 1.0, 1.2, 2.0])
    assert [drive_at(protocol, time).rate for time in (0.5, 1.1, 1.9, 2.1, 9.0)] == [1.0, 2.0, -0.5, 1.0, 1.0]
    assert [drive_at(protocol, time).strain for time in (1.2, 2.0, 2.4)] == pytest.approx([1.4, 1.0, 1.4])
    assert drive_at(protocol, 1.5).load == 3.0
    assert not protocol.jumps[1:].any()


@pytest.mark.parametrize("turn", [0.3, 0.1 + 0.2, np.nextafter(0.3, 0.0)])
def test_a_corner_at_the_time_of_a_frame_is_at_the_frame(turn):
    stages = [StageSpec(time=0.0, shear_rate=1.0), StageSpec(time=turn, shear_rate=2.0)]
    tick = 0.1 / 1024
    for end in (math.inf, 1.0):
        protocol = at_frames(protocol_of(stages), 1024, tick, end)
        assert next_turn(protocol, 0.2) == 3 * 1024 * tick
        assert drive_at(protocol, 0.3).rate == 2.0
        assert next_turn(protocol, 3 * 1024 * tick) == math.inf
    assert next_turn(at_frames(protocol_of(stages), 1024, tick, 0.3), 0.2) == 0.3
    assert next_turn(at_frames(protocol_of(stages), 1000, tick, math.inf), 0.2) == turn


@pytest.mark.parametrize(("first", "second"), [(0.3, 0.1 + 0.2), (0.1 + 0.2, 0.3)])
def test_times_that_differ_by_rounding_are_a_jump(first, second):
    """The strain between them was lost without a word: no step is as short as 6e-17 s. The other order was refused."""
    stages = [{"time": 0.0, "strain": 0.0}, {"time": first, "strain": 0.0}, {"time": second, "strain": 0.05}]
    protocol = protocol_of(packing(protocol=stages).protocol)
    assert drive_at(protocol, 0.2).strain == 0.0
    assert drive_at(protocol, 0.31).strain == 0.05
    assert protocol.jumps.tolist() == [0, 1]


def test_a_box_that_a_stress_tears_apart_ends_with_a_word():
    with pytest.raises(Exception, match=r"but not as large a one; reduce it|no step is short enough"):
        list(simulate(stressed([{"time": 0.0, "normal_stress": -10.0}])))


def test_scenes_with_stresses_survive_being_written():
    scene = packing(protocol=[{"time": 0.0, "shear_stress": "1 mN/m", "oscillation": {"frequency": 1, "stress": 1e-4}}])
    assert from_plain(to_plain(scene)) == scene
    assert dataclasses.asdict(scene)["protocol"][0]["shear_stress"] == 1e-3
