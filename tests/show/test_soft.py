"""Soft spheres as pictures."""

import contextlib
import dataclasses
import math
import re

import numpy as np
import pytest

from ecume.analysis.boxes import Box, box_of, nearest, wrapped
from ecume.analysis.series import Mean
from ecume.errors import BadInput
from ecume.scenes.schema import from_plain
from ecume.scenes.soft import (
    CellSpec,
    OscillationSpec,
    RateStepsSpec,
    SoftLiquid,
    SoftScene,
    SphereSpec,
    StageSpec,
    WallSpec,
)
from ecume.show.movies import film
from ecume.show.soft.figures import SOFT_FIGURES, hysteresis, oscillations, steady_flows
from ecume.show.soft.measures import between_rough_walls
from ecume.show.soft.packing import PULL, PUSH, Packing, links_around, links_of
from ecume.trajectories.frame import Frame

OF_BOXES = (
    "stress", "viscosity", "nonaffine", "steady-state", "flow-curve", "viscous-number", "normal-stresses",
    "viscosity-fraction", "creep", "moduli", "large-oscillation", "start-up", "relaxation", "recovery",
)  # fmt: skip
OF_PROTOCOLS = ("creep", "moduli", "large-oscillation", "start-up", "relaxation", "recovery")
UNITS = {"gap": "m", "tension": "N", "elastic_energy": "J"}


@pytest.fixture
def scene():
    spheres = SphereSpec(name="_soft $", radius=1e-3, modulus=1e4, positions=((0.0, 0.0), (2.1e-3, 0.0), (4.5e-3, 0.0)))
    return SoftScene(duration=1.0, frame_every=0.5, liquid=SoftLiquid(viscosity=1.0), particles=(spheres,))


@pytest.fixture
def frames():
    return [_frame(0.5 * n) for n in range(3)]


def _frame(time, **numbers):
    arrays = {
        "position": np.array([[0.0, 0.0], [2.1e-3, 0.0], [5.1e-3, 0.0]]),
        "radius": np.full(3, 1e-3),
        "species": np.zeros(3, np.int64),
        "neighbor": np.array([[1, 2], [2, -1], [-1, -1]]),
        "gap": np.array([[1e-4 * (1 + time), 3e-3], [1e-3, 0.0], [0.0, 0.0]]),
        "tension": np.array([[2e-6, -1e-9], [-1e-6, 0.0], [0.0, 0.0]]),
    }
    return Frame(time, arrays, {"elastic_energy": 1e-9 * time} | numbers, UNITS)


@pytest.fixture
def boxed():
    """A box of six spheres that is sheared while one film opens."""
    spheres = SphereSpec(name="soft", radius=1e-3, modulus=1e4, count=6)
    scene = SoftScene(
        duration=3.0, frame_every=0.25, liquid=SoftLiquid(viscosity=1.0), particles=(spheres,),
        cell=CellSpec(size=(6e-3, 4e-3)),
        protocol=(StageSpec(time=0.0), StageSpec(time=3.0, strain=0.3)),
    )  # fmt: skip
    return scene, [_sheared(0.25 * step) for step in range(13)]


def _sheared(time):
    start = 1e-3 * np.array([[1.0, 1.0], [3.1, 1.2], [5.2, 1.0], [2.0, 3.0], [4.1, 3.2], [0.1, 3.1]])
    strain = 0.1 * time
    moved = start + np.column_stack([strain * start[:, 1], np.zeros(6)])
    neighbor = np.array([[1, 3], [2, 4], [-1, -1], [4, 5], [-1, -1], [-1, -1]])
    arrays = {
        "position": wrapped(moved, Box(1e-3 * np.array([6.0, 4.0]), strain)),
        "velocity": 0.1 * np.column_stack([start[:, 1], np.zeros(6)]),
        "radius": np.full(6, 1e-3),
        "species": np.zeros(6, np.int64),
        "neighbor": neighbor,
        "gap": np.where(neighbor >= 0, 1e-5 * (1 + time), 0.0) * [1.0, 3.0],
        "tension": np.where(neighbor >= 0, 1e-6, 0.0) * [1.0, -2.0],
    }
    numbers = {
        "elastic_energy": 1e-9, "coordination": 5 / 3, "mean_gap": 2e-5, "smallest_gap": 1e-5, "pressure": 0.2,
        "shear_stress": 0.1 + 0.01 * time, "normal_stress": 0.3, "viscosity": 1.0 + time if time else math.nan,
        "stress_squeeze_xy": 0.08, "stress_sliding_xy": 0.02, "stress_squeeze_yx": 0.08, "stress_sliding_yx": 0.02,
        "stress_squeeze_xx": -0.4, "stress_sliding_xx": 0.3, "stress_squeeze_yy": -0.3, "stress_sliding_yy": 0.0,
        "strain": strain, "volume_fraction": 0.78,
        "box_width": 6e-3, "box_height": 4e-3,
    }  # fmt: skip
    return Frame(time, arrays, numbers, UNITS | {"shear_stress": "N/m", "viscosity": "N*s/m"})


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", SOFT_FIGURES)
def test_every_figure_can_be_drawn_or_says_why_not(name, scene, frames, boxed):
    if name in OF_BOXES:
        with pytest.raises(BadInput, match="no box"):
            SOFT_FIGURES[name](frames, scene)
        walled = dataclasses.replace(boxed[0], protocol=(), walls=(WallSpec(side="bottom"),))
        with pytest.raises(BadInput, match="no box without walls"):
            SOFT_FIGURES[name](frames, walled)
    elif name not in ("coordination", "swaps", "across"):
        SOFT_FIGURES[name](frames, scene).canvas.draw()
    if name not in OF_PROTOCOLS:
        SOFT_FIGURES[name](boxed[1], boxed[0]).canvas.draw()


def test_profiles_across_a_packing_take_a_cell_that_is_periodic_along_x(frames, scene):
    with pytest.raises(BadInput, match="periodic along x"):
        SOFT_FIGURES["across"](frames, scene)


def test_moduli_are_those_of_the_oscillations_in_the_protocol(boxed):
    scene, (first, *_) = boxed
    with pytest.raises(BadInput, match="no oscillation"):
        SOFT_FIGURES["moduli"](boxed[1], scene)
    wave = OscillationSpec(frequency=0.5, amplitude=0.01)
    scene = dataclasses.replace(scene, duration=6.0, protocol=(StageSpec(time=0.0, oscillation=wave),))
    now = np.linspace(0.0, 6.0, 121)
    frames = [
        first._replace(time=time, numbers=first.numbers | {"strain": strain, "shear_stress": 3.0 * strain + 0.02 * lag})
        for time, strain, lag in zip(now, 0.01 * np.sin(np.pi * now), np.cos(np.pi * now), strict=True)
    ]
    ((frequency, found),) = oscillations(frames, scene)
    assert (frequency, found.periods) == (0.5, 2)
    assert (found.storage.value, found.loss.value) == (pytest.approx(3.0), pytest.approx(2.0))
    SOFT_FIGURES["moduli"](frames, scene).canvas.draw()


def test_loops_of_large_oscillations_have_their_third_harmonic(boxed):
    """Strains of two amplitudes a, and a stress s + 100 s^3: e_3/e_1 = 25 a^2/(1 + 75 a^2)."""
    scene, (first, *_) = boxed
    sizes = {0.0: 0.05, 6.0: 0.2}
    waves = [StageSpec(time=time, oscillation=OscillationSpec(frequency=0.5, amplitude=a)) for time, a in sizes.items()]
    scene = dataclasses.replace(scene, duration=12.0, protocol=tuple(waves))
    now = np.linspace(0.0, 12.0, 241)
    strains = np.where(now < 6.0, 0.05, 0.2) * np.sin(np.pi * now)
    frames = [
        first._replace(
            time=time, numbers=first.numbers | {"strain": strain, "shear_stress": strain + 100.0 * strain**3}
        )
        for time, strain in zip(now, strains, strict=True)
    ]
    drawn = SOFT_FIGURES["large-oscillation"](frames, scene)
    loops, harmonics = drawn.axes
    assert len(loops.lines) == 2
    (_, elastic, *_) = harmonics.lines
    expected = [25.0 * a**2 / (1.0 + 75.0 * a**2) for a in sizes.values()]
    assert elastic.get_ydata() == pytest.approx(expected, rel=1e-6)
    drawn.canvas.draw()


def test_transients_are_found_in_the_protocol_and_drawn_with_their_numbers(boxed):
    """A flow at 1/s up to 4 s whose stress peaks at a strain of 1, a rest up to 8 s, a creep up to 12 s, a recovery."""
    scene, (first, *_) = boxed
    protocol = (
        StageSpec(time=0.0, shear_rate=1.0), StageSpec(time=4.0, shear_rate=0.0), StageSpec(time=8.0, shear_stress=0.2),
        StageSpec(time=12.0, shear_stress=0.2), StageSpec(time=12.0, shear_stress=0.0),
    )  # fmt: skip
    scene = dataclasses.replace(scene, duration=16.0, protocol=protocol)
    noise = np.random.default_rng(2)

    def at(time):
        rise, rest, back = min(time, 4.0), max(time - 4.0, 0.0), max(time - 12.0, 0.0)
        stress = 1.0 + 2.0 * rise * math.exp(-rise) - math.exp(-9.0 * rise) + 1e-3 * noise.normal()
        strain = rise + 0.5 * min(max(time - 8.0, 0.0), 4.0) - 0.6 * (1.0 - 2.0 ** (-4.0 * back))
        stress *= 0.25 + 0.75 * 2.0 ** (-8.0 * rest)
        return first._replace(time=time, numbers=first.numbers | {"strain": strain, "shear_stress": stress})

    frames = [at(time) for time in np.linspace(0.0, 16.0, 641)]
    texts = {}
    for name in ("start-up", "relaxation", "recovery"):
        drawn = SOFT_FIGURES[name](frames, scene)
        (label,) = [text.get_text() for text in drawn.axes[0].get_legend().get_texts()]
        texts[name] = label
        drawn.canvas.draw()
    (peak,) = [line for line in SOFT_FIGURES["start-up"](frames, scene).axes[0].lines if line.get_marker() == "o"]
    assert peak.get_xdata()[0] == pytest.approx(1.0, abs=0.1)
    assert re.search(r"after 1 /s: 25(\.1)? % left, half in 0\.1[23] s", texts["relaxation"])
    assert texts["recovery"] == "30 % of a strain of 2"


STEPS = {0.02: 0.14, 0.1: 0.3, 0.5: 1.1, 2.5: 5.1}
"""Stresses s = 0.1 + 2 rate."""


@pytest.fixture
def stepped(boxed):
    """A run of four rates, each held for a strain of 0.5, whose stress is stationary from a third of each on."""
    scene, (first, *_) = boxed
    steps = RateStepsSpec(rates=tuple(STEPS), strain=0.5)
    scene = dataclasses.replace(scene, duration=31.2, protocol=(StageSpec(time=0.0, rate_steps=steps),))
    frames, start, strain, noise = [first], 0.0, 0.0, np.random.default_rng(1)
    for rate, span in zip(steps.rates, steps.spans, strict=True):
        for part in np.arange(1, 61) / 60:
            shear = STEPS[rate] * (1.0 + math.exp(-20.0 * part) + 0.01 * noise.normal())
            now = {"strain": strain + 0.5 * part, "shear_stress": shear, "normal_stress": 3.0 * shear}
            frames.append(first._replace(time=start + part * span, numbers=first.numbers | now))
        start, strain = start + span, strain + 0.5
    return scene, frames


def test_each_step_of_the_rate_is_a_point_of_the_flow_curve_after_its_transient(stepped):
    scene, frames = stepped
    flows = steady_flows(frames, scene)
    assert [flow.point.rate.value for flow in flows] == pytest.approx(list(STEPS))
    for flow, wanted in zip(flows, STEPS.values(), strict=True):
        assert flow.settled
        assert 30 <= len(flow.steady) < 60
        assert flow.point.shear_stress.value == pytest.approx(wanted, rel=0.01)
        assert flow.stress.first_difference.value == pytest.approx(0.2)
    shown = SOFT_FIGURES["flow-curve"](frames, scene)
    (label,) = [text.get_text() for text in shown.axes[0].get_legend().get_texts() if "rate^n" in text.get_text()]
    assert float(label.split()[0]) == pytest.approx(0.1, abs=0.003)
    assert "n = 1.0" in label
    assert steady_flows(frames[:1] * 2, scene) == []


def test_rates_that_end_early_are_parts_of_the_flow_curve_with_the_strain_of_each(stepped):
    """The same flows in half of the planned time: frames say to which rate they belong, and the last is not steady."""
    scene, (first, *frames) = stepped
    steps = dataclasses.replace(scene.protocol[0].rate_steps, strain=1.0, stationary_within=0.05)
    scene = dataclasses.replace(
        scene, duration=62.4, frame_every=1e-3, protocol=(StageSpec(time=0.0, rate_steps=steps),)
    )
    waited = [first] + [
        frame._replace(numbers=frame.numbers | {"rate_step": 1.0 + place // 60, "rates_stationary": float(reached)})
        for place, frame in enumerate(frames)
        for reached in [min((place + 1) // 60, 3)]
    ]
    shown = SOFT_FIGURES["flow-curve"](waited, scene)
    held = {line.get_label(): line.get_xydata() for line in shown.axes[1].lines}
    assert held["until stationary"] == pytest.approx(np.array([[rate, 0.5] for rate in list(STEPS)[:3]]))
    assert held["largest strain"] == pytest.approx(np.array([[2.5, 0.5]]))


def test_hysteresis_needs_no_steady_flow_at_the_turn(stepped):
    """Of three rates up and down only that in the middle is shared and stationary."""
    scene, frames = stepped
    flow = steady_flows(frames, scene)[0]

    def at(rate, stress, settled=True):
        point = flow.point._replace(rate=Mean(rate, 0.0), shear_stress=Mean(stress, 0.1))
        return flow._replace(point=point, settled=settled)

    flows = [at(0.1, 1.0), at(0.3, 2.0), at(1.0, 3.0, settled=False), at(0.3, 1.0), at(0.05, 1.0)]
    found = hysteresis(flows)
    assert (found.at, found.relative) == pytest.approx((0.3, -0.5))
    assert hysteresis(flows[:3]) is None


@pytest.mark.parametrize(("rates", "falling"), [
    ((0.1, 0.3, 1.0, 0.3, 0.1), "-20 % at 0.3 /s"),
    ((1.0, 1.0, 0.1, 0.3, 1.0), None),  # a pre-shear, and rates that rise
    ((0.1, 0.3, 1.0), None),
])  # fmt: skip
def test_a_sweep_up_and_down_shows_its_hysteresis(boxed, rates, falling):
    """On the way down the stress at 0.3/s is lower by a fifth, that at 0.1/s by a tenth."""
    scene, (first, *_) = boxed
    steps = RateStepsSpec(rates=rates, strain=0.5)
    scene = dataclasses.replace(scene, duration=sum(steps.spans), protocol=(StageSpec(time=0.0, rate_steps=steps),))
    frames, start, strain, noise = [first], 0.0, 0.0, np.random.default_rng(1)
    for place, (rate, span) in enumerate(zip(rates, steps.spans, strict=True)):
        lower = {0.3: 0.8, 0.1: 0.9}.get(rate, 1.0) if place > 2 else 1.0
        for part in np.arange(1, 41) / 40:
            shear = lower * (0.1 + rate) * (1.0 + 0.001 * noise.normal())
            now = {"strain": strain + 0.5 * part, "shear_stress": shear, "normal_stress": 3.0 * shear}
            frames.append(first._replace(time=start + part * span, numbers=first.numbers | now))
        start, strain = start + span, strain + 0.5
    shown = SOFT_FIGURES["flow-curve"](frames, scene)
    labels = [text.get_text() for text in shown.axes[0].get_legend().get_texts()]
    assert any(falling in label for label in labels) if falling else "rates falling" not in " ".join(labels)
    assert ("steady flows" in labels) is (falling is None)


def test_a_drift_is_marked_as_not_stationary(boxed):
    scene, _ = boxed
    frames = [_sheared(time) for time in np.linspace(0.0, 3.0, 61)]
    (flow,) = steady_flows(frames, scene)
    assert not flow.settled
    shown = SOFT_FIGURES["flow-curve"](frames, scene)
    assert "not stationary" in [text.get_text() for text in shown.axes[0].get_legend().get_texts()]


def test_an_oscillation_is_no_steady_flow(boxed):
    """Its mean rate is that of a part of a period."""
    scene, (first, *_) = boxed
    now = np.linspace(0.0, 6.2, 125)
    frames = [
        first._replace(time=time, numbers=first.numbers | {"strain": 0.01 * math.sin(math.pi * time)}) for time in now
    ]
    wave = OscillationSpec(frequency=0.5, amplitude=0.01)
    scene = dataclasses.replace(scene, duration=6.2, protocol=(StageSpec(time=0.0, oscillation=wave),))
    assert steady_flows(frames, scene) == []
    with pytest.raises(BadInput, match="nowhere in this run is the packing sheared"):
        SOFT_FIGURES["flow-curve"](frames, scene)


def test_creep_ends_where_the_packing_is_sheared_otherwise(boxed):
    """A stress up to 3 s, and a rate of -1/s afterwards."""
    scene, (first, *_) = boxed
    moments = (StageSpec(time=0.0, shear_stress=0.1), StageSpec(time=3.0, shear_rate=-1.0))
    now = np.linspace(0.0, 6.0, 121)
    frames = [
        first._replace(time=time, numbers=first.numbers | {"strain": 0.2 * min(time, 3.0) - max(time - 3.0, 0.0)})
        for time in now
    ]
    (strains, _) = SOFT_FIGURES["creep"](frames, dataclasses.replace(scene, duration=6.0, protocol=moments)).axes
    (line,) = strains.lines
    assert line.get_xydata()[-1] == pytest.approx([3.0, 0.6])
    assert line.get_xdata()[0] == pytest.approx(0.05)  # the axis is logarithmic: nothing is drawn at 0


def test_instants_without_contacts_leave_gaps_in_percentiles(scene):
    """More contacts than single curves; at first there is none."""
    neighbor = np.array([[1, 2, 3, 4, 5, 6, 7], [2, 3, 4, 5, 6, 7, -1], *[[-1] * 7] * 6])
    alone = np.full_like(neighbor, -1)
    frames = [
        Frame(time, {
            "position": np.zeros((8, 2)), "radius": np.full(8, 1e-3), "neighbor": here,
            "gap": np.full(here.shape, 1e-5), "tension": np.full(here.shape, 1e-6),
        }, {}, UNITS)
        for time, here in enumerate((alone, neighbor, neighbor))
    ]  # fmt: skip
    for name in ("gaps", "forces"):
        drawn = SOFT_FIGURES[name](frames, scene)
        drawn.canvas.draw()
        assert np.isfinite(drawn.axes[0].lines[0].get_ydata()).tolist() == [False, True, True]


def test_creep_is_drawn_for_each_step_of_the_stress(boxed):
    scene, (first, *_) = boxed
    with pytest.raises(BadInput, match="no shear_stress"):
        SOFT_FIGURES["creep"](boxed[1], scene)
    moments = (StageSpec(time=0.0, shear_stress=0.1), StageSpec(time=3.0, shear_stress=0.4))
    now = np.linspace(0.0, 6.0, 121)
    crept = 0.01 * np.minimum(now, 3.0) ** 0.1 + 0.2 * np.maximum(now - 3.0, 0.0)
    frames = [
        first._replace(time=time, numbers=first.numbers | {"strain": strain})
        for time, strain in zip(now, crept, strict=True)
    ]
    shown = SOFT_FIGURES["creep"](frames, dataclasses.replace(scene, duration=6.0, protocol=moments))
    labels = [text.get_text() for text in shown.axes[0].get_legend().get_texts()]
    assert [label.split(", ")[1] for label in labels] == ["no steady flow", "0.2 /s"]


def test_a_box_shows_its_copies_beside_it_and_its_outline(boxed):
    scene, frames = boxed
    shown = Packing(scene, frames)
    shown.show(frames[-1])
    assert shown.outline.get_xy()[2] == pytest.approx([6e-3, 4e-3])
    centers = [path.vertices[:-1].mean(axis=0) for path in shown.beside.get_paths()]
    home, box = frames[-1].arrays["position"], box_of(frames[-1])
    for center in centers:
        assert min(np.linalg.norm(nearest(home - center, box), axis=1)) < 1e-9
        assert not ((center > 0.0) & (center < box.sides)).all()
    # A contact across the border is drawn on both sides of it.
    ends = links_around(frames[-1])
    middle = ends.first + 0.5 * ends.along
    across = links_of(frames[-1])
    assert len(middle) > len(across.first)
    seen = np.linalg.norm(nearest(middle[:, None].reshape(-1, 2) - (across.first + 0.5 * across.along)[0], box), axis=1)
    assert (seen < 1e-9).sum() > 1


def test_what_is_not_in_a_box_has_no_copies(scene, frames):
    shown = Packing(scene, frames)
    assert not shown.beside.get_paths()
    assert not shown.outline.get_visible()


def test_what_pulls_is_red_what_pushes_blue_and_wide_films_are_left_out(scene, frames):
    shown = Packing(scene, frames)
    shown.show(frames[1])
    assert len(shown.forces.get_segments()) == 3
    colors = [tuple(round(255 * c) for c in color[:3]) for color in shown.forces.get_color()]
    assert colors[0] == tuple(bytes.fromhex(PULL[1:]))
    assert colors[1] == colors[2] == tuple(bytes.fromhex(PUSH[1:]))
    assert list(shown.films.get_array()) == pytest.approx([1.5e-4])


def test_a_mark_turns_with_its_sphere(scene, frames):
    still = Packing(scene, frames)
    assert still.marks.get_segments() == []
    half = np.sqrt(0.5)
    for spins in ({"angle": np.full(3, np.pi / 2)}, {"orientation": np.tile([half, 0.0, 0.0, half], (3, 1))}):
        turned = [frame._replace(arrays=frame.arrays | spins) for frame in frames]
        shown = Packing(scene, turned)
        from_center = np.array(shown.marks.get_segments()) - frames[0].arrays["position"][:, None]
        assert from_center[:, :, 0] == pytest.approx(np.zeros((3, 2)), abs=1e-15)
        assert (from_center[:, 1, 1] > from_center[:, 0, 1]).all()
        assert (from_center[:, 0, 1] > 0.0).all()


def test_a_contact_across_a_sheared_border_goes_to_the_nearest_copy():
    frame = _frame(0.0, box_width=6e-3, box_height=4e-3, box_tilt=1e-3)
    frame.arrays["position"][1] = 0.5e-3, 3.9e-3
    along = links_of(frame).along
    assert along[0] == pytest.approx([0.5e-3 - 1e-3, -0.1e-3])


def test_a_movie_can_be_made(scene, frames, tmp_path):
    made = film(frames, scene, tmp_path / "soft.gif")
    assert made.stat().st_size > 1000


class CountedFrames(list):
    """Frames that count how often one is read."""

    reads = 0

    def __getitem__(self, place):
        found = super().__getitem__(place)
        CountedFrames.reads += len(found) if isinstance(place, slice) else 1
        return CountedFrames(found) if isinstance(place, slice) else found

    def __iter__(self):
        for frame in super().__iter__():
            CountedFrames.reads += 1
            yield frame


MOST_READS = 9
"""Of each frame, of which several are for numbers that each figure reads separately."""


@pytest.mark.parametrize("name", sorted(SOFT_FIGURES))
def test_a_figure_reads_each_frame_a_few_times_whatever_the_number_of_frames(name, boxed):
    scene, (first, *_) = boxed
    rates = RateStepsSpec(rates=tuple(0.02 * 1.5**k for k in range(8)), strain=1.0)
    moments = dataclasses.replace(scene, duration=200.0, protocol=(StageSpec(time=0.0, rate_steps=rates),))
    reads = {}
    for count in (100, 200):
        frames = CountedFrames(
            first._replace(time=time, numbers=first.numbers | {"strain": 0.01 * time})
            for time in np.linspace(0, 200, count)
        )
        CountedFrames.reads = 0
        with contextlib.suppress(BadInput):
            SOFT_FIGURES[name](frames, moments)
        reads[count] = CountedFrames.reads
    assert reads[200] <= MOST_READS * 200
    assert reads[200] <= 2.2 * reads[100] + 50


def test_a_profile_between_rough_walls_is_that_of_the_spheres_between_the_glued_ones():
    """Spheres of radius 0.5 at the walls, and others between them that flow uniformly."""
    rough = [{"radius": 0.5, "modulus": 1.0, "count": 1, "glued": side} for side in ("bottom", "top")]
    scene = from_plain({
        "model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1e-3},
        "particles": [*rough, {"radius": 0.5, "modulus": 1.0, "count": 1}],
        "cell": {"size": [4.0, 6.0]}, "walls": [{"side": "bottom"}, {"side": "top"}],
    })  # fmt: skip
    y = np.array([0.5, 5.5, *np.linspace(1.6, 4.4, 15)])
    position = np.stack([np.linspace(0.5, 3.5, 17), y], axis=1)
    arrays = {
        "position": position, "radius": np.full(17, 0.5), "species": np.array([0, 1, *[2] * 15]),
        "velocity": np.stack([np.clip(y - 1.0, 0.0, 4.0), np.zeros(17)], axis=1),
    }  # fmt: skip
    frame = Frame(0.0, arrays, {"box_width": 4.0, "bottom_y": 0.0, "top_y": 6.0}, {})
    assert between_rough_walls([frame, frame], scene) == pytest.approx((1.0, 5.0))
    smooth = dataclasses.replace(scene, particles=scene.particles[2:])
    assert between_rough_walls([frame], smooth) == pytest.approx((0.0, 6.0))
    drawn = SOFT_FIGURES["across"]([frame] * 4, scene)
    assert [patch.get_height() for patch in drawn.axes[0].patches] == pytest.approx([1.0, 1.0])
    (straight,) = [line for line in drawn.axes[0].lines if line.get_label() == "straight"]
    assert 1.0 < min(straight.get_ydata()) < max(straight.get_ydata()) < 5.0
