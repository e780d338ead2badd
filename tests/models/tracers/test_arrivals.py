"""Particles that come in through openings."""

import dataclasses

import numpy as np
import pytest

import ecume
from ecume.engine import walls
from ecume.errors import BadInput, SceneError
from ecume.models import MODELS
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.tracers import (
    FlowSpec,
    OpeningSpec,
    ParticleSpec,
    PulseSpec,
    TankSpec,
    TracerIntegrationSpec,
    TracersScene,
)

DUST = ParticleSpec(name="dust", radius=1e-5, density=1000.0, positions=((0.5, 0.5),))
SAND = ParticleSpec(name="sand", radius=1e-3, density=2500.0, positions=((0.5, 0.2),))


def channel(**changes):
    """Liquid flows from an opening on the left to one on the right, a meter away, in two seconds."""
    return TracersScene(
        **{
            "duration": 4.0,
            "frame_every": 0.5,
            "seed": 5,
            "gravity": 0.0,
            "flow": FlowSpec(velocity=(0.5, 0.0)),
            "particles": (DUST, SAND),
            "tank": TankSpec(high=(1.0, 0.8)),
            "openings": (
                OpeningSpec(wall=0, low=(0.0, 0.0), high=(0.0, 0.8), rate=200.0),
                OpeningSpec(wall=2, low=(1.0, 0.0), high=(1.0, 0.8)),
            ),
            "integration": TracerIntegrationSpec(integrator="overdamped", time_step=0.01),
            **changes,
        }
    )


@pytest.mark.compiled
def test_as_many_come_in_as_were_asked_for_and_leave_two_seconds_later():
    for frame in ecume.simulate(channel()):
        entered_count, left = frame.numbers["entered_through_opening_0"], frame.numbers["left_through_opening_1"]
        assert entered_count == pytest.approx(200.0 * frame.time, abs=1)
        assert len(frame.arrays["position"]) == 2 + entered_count
        assert frame.numbers["particles_inside"] == 2 + entered_count - left
        if frame.time > 2.1:
            assert left == pytest.approx(200.0 * (frame.time - 2.0) + 2, abs=5)
    assert frame.numbers["entered_through_opening_1"] == 0.0


@pytest.mark.compiled
def test_newcomers_are_as_many_everywhere_as_there_are_in_what_flows_in():
    scene = channel(
        openings=(
            OpeningSpec(wall=0, low=(0.0, 0.0), high=(0.0, 0.8), concentration=4000.0),
            OpeningSpec(wall=2, low=(1.0, 0.0), high=(1.0, 0.8)),
        ),
        gravity=0.0,
        flow=FlowSpec(velocity=(0.2, 0.0), shear_rate=1.0),
        duration=6.0,
        frame_every=6.0,
    )
    (*_, last) = ecume.simulate(scene)
    place = last.arrays["position"][(last.arrays["left"] < 0)]
    cells = np.histogram2d(*place.T, bins=(4, 4), range=((0.0, 1.0), (0.0, 0.8)))[0] / (0.25 * 0.2)
    assert len(place) > 2500
    np.testing.assert_allclose(cells, 4000.0, rtol=5.0 / np.sqrt(200.0))
    assert cells.mean() == pytest.approx(4000.0, rel=0.02)


@pytest.mark.compiled
def test_where_and_when_they_come_is_the_seeds_alone():
    first, same, other = (MODELS["tracers"].parameters(channel(seed=seed)).arrivals for seed in (5, 5, 6))
    assert np.array_equal(first.position, same.position)
    assert not np.array_equal(first.position, other.position)
    assert np.all(np.diff(first.step) >= 0)


@pytest.mark.compiled
def test_a_species_settles_in_from_above_and_keeps_its_radius_from_the_walls():
    rain = OpeningSpec(wall=3, low=(0.0, 0.8), high=(1.0, 0.8), rate=300.0, species="sand")
    scene = channel(
        openings=(rain,),
        gravity=9.81,
        flow=FlowSpec(),
        integration=TracerIntegrationSpec(time_step=0.001),
        duration=0.5,
    )
    arrivals = MODELS["tracers"].parameters(scene).arrivals
    x = arrivals.position[:, 0]
    assert x.min() >= 1e-3
    assert x.max() <= 1.0 - 1e-3
    assert np.abs(np.sort(x) - (np.arange(150) + 0.5) / 150).max() < 2.0 / np.sqrt(150)
    (*_, last) = ecume.simulate(scene)
    entered_count = last.arrays["species"][2:]
    assert np.all(entered_count == 1)
    assert len(entered_count) == 150


def test_an_entrance_in_an_askew_wall_is_the_part_of_it_in_the_box():
    roof = walls.opening(walls.polygon([[0, 0], [4, 0], [0, 3]]), 1, (0.8, 0.0), (2.4, 9.0))
    door = walls.entrance(roof, 0)
    assert door.area() == pytest.approx(2.0)
    ends = door.at(np.array([[0.0], [1.0]]))
    assert sorted(ends[:, 0].tolist()) == pytest.approx([0.8, 2.4])
    np.testing.assert_allclose(3.0 * ends[:, 0] + 4.0 * ends[:, 1], 12.0)
    assert door.normal.tolist() == pytest.approx([-0.6, -0.8])


def test_an_entrance_in_space_has_an_area_and_holds_what_is_in_it():
    with pytest.raises(BadInput, match="has no part in plane 4"):
        walls.opening(walls.box((0, 0, 0), (1, 2, 3)), 4, (0.5, 0.5, 2.0), (0.5, 1.0, 3.0))
    room = walls.opening(walls.box((0, 0, 0), (1, 2, 3)), 3, (1.0, 0.5, 2.0), (1.0, 1.0, 3.0))
    door = walls.entrance(room, 0)
    assert door.area() == pytest.approx(0.5)
    assert door.holds(door.at(np.random.default_rng(1).uniform(size=(50, 2)))).all()
    assert not door.holds(np.array([[1.0, 0.4, 2.5]])).any()


@pytest.mark.parametrize(
    ("hole", "said"),
    [
        ({"rate": 1.0, "velocity": (-1.0, 0.0)}, "above 0 in all of the opening"),
        ({"rate": 1.0, "species": "sund"}, "the species are 'dust', 'sand'"),
        ({"rate": 1.0, "concentration": 1.0}, "expected one of them"),
        ({"species": "sand"}, "expected rate or concentration with it"),
        ({"rate": 1.0, "velocity": (1.0, 0.0, 0.0)}, "got 3 coordinates; expected 2"),
        ({"rate": 1.0, "high": (0.0, 1e-3), "species": "sand"}, "no room for a radius of 0.001 m"),
        ({"rate": 1e11}, "are more than"),
    ],
)
def test_an_opening_that_admits_no_particle_is_refused_with_the_reason(hole, said):
    plain = to_plain(channel())
    plain["openings"] = [{"wall": 0, "low": [0.0, 0.0], "high": [0.0, 0.8], **hole}]
    with pytest.raises(SceneError) as error:
        MODELS["tracers"].summary(from_plain(plain))
    assert "openings" in str(error.value)
    assert said in str(error.value)


def test_particles_enter_a_pulsating_flow_with_the_velocity_of_their_time():
    flow = FlowSpec(name="channel", speed=0.2, pulse=PulseSpec(amplitude=0.5, period=0.4))
    hole = OpeningSpec(wall=0, low=(0.0, 0.2), high=(0.0, 0.6), rate=200.0)
    scene = channel(flow=flow, openings=(hole,), duration=0.4, frame_every=0.4)
    arrivals = MODELS["tracers"].parameters(scene).arrivals
    share = arrivals.position[:, 1] / scene.tank.high[1]
    factor = arrivals.velocity[:, 0] / (6.0 * 0.2 * share * (1.0 - share))
    step = MODELS["tracers"].parameters(scene).time_step
    time = arrivals.step * step
    assert factor.max() > 1.45
    assert np.abs(factor - 1.0 - 0.5 * np.sin(2.0 * np.pi * time / 0.4)).max() < 0.5 * 2.0 * np.pi * step / 0.4 + 1e-9


def test_a_flow_that_reverses_in_an_opening_is_refused():
    flow = FlowSpec(name="channel", speed=0.2, pulse=PulseSpec(amplitude=2.0, period=0.4))
    hole = OpeningSpec(wall=0, low=(0.0, 0.2), high=(0.0, 0.8), rate=200.0)
    with pytest.raises(SceneError, match="at all times"):
        MODELS["tracers"].parameters(channel(flow=flow, openings=(hole,), duration=0.4, frame_every=0.4))


def test_no_particle_enters_through_a_curved_wall():
    grain = dataclasses.replace(DUST, positions=((0.0, 0.0),))
    hole = OpeningSpec(wall=0, low=(-0.5, -1.0), high=(0.5, 0.0), rate=1.0)
    scene = channel(particles=(grain,), tank=TankSpec(radius=0.5), openings=(hole,))
    with pytest.raises(SceneError, match="expected one in a flat wall"):
        MODELS["tracers"].summary(scene)


def test_check_says_how_many_will_come():
    rows = dict(row[:2] for row in MODELS["tracers"].summary(channel()))
    assert rows["opening 0"] == "800 enter"
    assert "opening 1" not in rows


@pytest.mark.compiled
def test_a_scene_file_may_say_how_many_come(tmp_path):
    file = tmp_path / "rain.toml"
    file.write_text(
        'model = "tracers"\nduration = "0.2 s"\nframe_every = "50 ms"\n[flow]\nvelocity = ["20 cm/s", "0 m/s"]\n'
        '[tank]\nhigh = ["10 cm", "5 cm"]\n[[particles]]\nradius = "20 um"\ndensity = 1100.0\n'
        '[[openings]]\nwall = 0\nlow = ["0 m", "1 cm"]\nhigh = ["0 m", "4 cm"]\nrate = "400 s^-1"\n'
    )
    counts = [len(frame.arrays["position"]) for frame in ecume.simulate(load_scene(file))]
    assert counts == pytest.approx([1, 21, 41, 61, 81], abs=1)
