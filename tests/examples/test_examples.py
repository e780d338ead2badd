"""Each scene of the gallery runs, one of its numbers has the physical value, and all agree with the records."""

import math
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import ecume
from ecume.analysis.clusters import touching_pairs
from ecume.analysis.rearrangements import neighbor_swaps
from ecume.laws.drag import stokes_settling_speed
from ecume.laws.drops import drop_strain_change
from ecume.laws.flows import taylor_green_decay
from ecume.scenes.templates import templates
from tests.torture.regression import differing, recorded

ROOT = Path(__file__).parents[2]
SCENES = sorted((ROOT / "examples").glob("*.toml"))
LONG = {
    "channel", "dam-break", "docking-quadrupoles", "ellipsoids-docking", "pattern-formation", "rounding-drop",
    "settling-packing", "sloshing", "taylor-green",
}  # fmt: skip
"""Take seconds each, some of them to compile a time step that no other test needs."""


class Wanted(NamedTuple):
    """An expected number of the frames."""

    measure: object
    value: float
    tolerance: float
    why: str


def last(name, frames):
    return frames[-1].numbers[name]


def unlike_neighbors(frames):
    """Pairs of two species that touch at the end."""
    arrays = frames[-1].arrays
    first, second = touching_pairs(arrays["position"], arrays["radius"]).T
    return int(np.sum(arrays["species"][first] != arrays["species"][second]))


def reach_of_the_light(frames):
    """The largest distance from the middle of floats of the first species at the end."""
    arrays = frames[-1].arrays
    return float(np.linalg.norm(arrays["position"][arrays["species"] == 0], axis=1).min())


def mirrored(frames):
    """Half the angles of two rims relative to the line between them: a whole number of right angles for mirror
    images.
    """
    (first, second), (one, other) = frames[-1].arrays["position"], frames[-1].arrays["angle"]
    line = math.atan2(*(second - first)[::-1])
    turns = (one + other - 2.0 * line) / math.pi
    return turns - round(turns)


def tips_apart(frames):
    """The distance of the centers of two ellipsoids over their length: 1 if they touch tip to tip."""
    return math.dist(*frames[-1].arrays["position"]) / (2.0 * float(frames[-1].arrays["radius"].mean()))


def second_height(frames):
    """The height of the first ball after its first bounce over its initial height, both of its lowest point."""
    height = np.array([frame.arrays["position"][0, 1] for frame in frames]) - 8e-3
    bounce = int(np.argmax(np.diff(height) > 0.0))
    again = bounce + 1 + int(np.argmax(np.diff(height[bounce + 1 :]) < 0.0))
    return height[again] / height[0]


def settling_of_the_coarse(frames):
    """The speed of the coarsest grains in the first second over that of Stokes."""
    arrays, later = frames[0].arrays, frames[12]
    high = (arrays["species"] == 0) & (arrays["position"][:, 1] > 0.5e-3)
    fallen = (arrays["position"] - later.arrays["position"])[high, 1].mean() / later.time
    return fallen / stokes_settling_speed(8e-6, 2500.0 - 998.2, 1.0016e-3, 9.81)


def floor_pressure(frames):
    """The pressure at the floor in the second half, over that of 40 cm of water."""
    output = [frame.numbers["floor_pressure"] for frame in frames[len(frames) // 2 :]]
    return float(np.mean(output)) / (1000.0 * 9.81 * 0.4)


def front_speed(frames):
    """The speed of the front on its way through the tank, over the root of g H."""
    way = [(frame.time, frame.numbers["front"]) for frame in frames if 0.25 < frame.time < 0.4]
    return np.polyfit(*zip(*way, strict=True), 1)[0] / math.sqrt(9.81 * 0.3)


def sides_alike(frames):
    """The displacement of the center of the water along one side of the tank, over that along the other."""
    went = [frames[-1].numbers[f"center_{axis}"] - frames[0].numbers[f"center_{axis}"] for axis in "xz"]
    return went[0] / went[1]


def swing(frames):
    """The period of oscillation of the center, from its passages through the middle."""
    times = np.array([frame.time for frame in frames])
    offset = np.array([frame.numbers["center_x"] for frame in frames]) - 0.5
    down = np.flatnonzero((offset[:-1] > 0.0) & (offset[1:] <= 0.0))
    passes = times[down] + (times[down + 1] - times[down]) * offset[down] / (offset[down] - offset[down + 1])
    return float(np.diff(passes[passes > 0.5]).mean())


def peak_over_mean(frames):
    """The peak over the mean of the speed in the channel, near its end: 3/2 for a parabola."""
    place, velocity = (frames[-1].arrays[name] for name in ("position", "velocity"))
    along = velocity[(place[:, 0] > 1.8) & (place[:, 0] < 2.8), 0]
    return along.max() / along.mean()


def second_stretch(frames):
    """The time at which the drop is longest for the second time."""
    shape = [np.divide(*frame.arrays["position"].std(axis=0)) for frame in frames]
    return frames[50 + int(np.argmax(shape[50:]))].time


def exact_second_stretch():
    """The time of the second maximum of an ellipse of liquid, by its equation of motion."""
    (width, height, rate), step, passed, before = (1.0, 1.0, 0.5), 1e-4, 0, 0.5
    for number in range(100_000):
        width, height = width * math.exp(rate * step), height * math.exp(-rate * step)
        rate += step * drop_strain_change(rate, 1.0, width, height)
        if before > 0.0 >= rate:
            passed += 1
            if passed == 2:
                return number * step
        before = rate
    raise AssertionError("the drop does not swing")


def roundness(frames):
    """The farthest particle over the root mean square distance, relative to a disc: 1 for a disc, 1.22 for a square."""
    place = frames[-1].arrays["position"]
    away = np.linalg.norm(place - place.mean(axis=0), axis=1)
    return away.max() / math.sqrt(2.0 * np.mean(away**2))


def decay(frames):
    """The decay rate of speeds, over the exact one."""
    first, final = (frame.numbers["kinetic_energy"] for frame in (frames[0], frames[-1]))
    return 0.5 * math.log(first / final) / frames[-1].time / taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, 0.01)


def swaps(frames):
    return len(neighbor_swaps(frames).events)


def stress_of_its_parts(frames):
    """The stress by squeezed and sheared films, over the whole shear stress, in the second half."""
    half = frames[len(frames) // 2 :]
    parts = sum(frame.numbers["stress_squeeze_xy"] + frame.numbers["stress_sliding_xy"] for frame in half)
    return parts / sum(frame.numbers["shear_stress"] for frame in half)


def carried_weight(frames):
    """The force on the floor, over the weight of the spheres in the liquid."""
    volume = 24 * 4.0 / 3.0 * math.pi * (1e-3**3 + 1.4e-3**3)
    return -frames[-1].numbers["bottom_force_y"] / (400.0 * 9.81 * volume)


WANTED = {
    "bowl": Wanted(partial(last, "clusters"), 5, 4, "forty cereals are a few rafts"),
    "rafts": Wanted(partial(last, "clusters"), 1, 0, "all attract, and one raft is left"),
    "heavy-and-light": Wanted(unlike_neighbors, 0, 0, "unlike charges repel"),
    "wall-climbing": Wanted(reach_of_the_light, 19e-3, 1e-5, "all light ones lie at the wall"),
    "bubbles-and-beads": Wanted(unlike_neighbors, 0, 0, "unlike charges repel"),
    "ellipsoids-docking": Wanted(tips_apart, 1.0, 1e-6, "they touch tip to tip"),
    "pattern-formation": Wanted(partial(last, "clusters"), 5, 2, "dipoles keep rafts apart"),
    "docking-quadrupoles": Wanted(mirrored, 0.0, 0.01, "quadrupoles dock as mirror images"),
    "bouncing-tracers": Wanted(second_height, 0.64, 0.01, "a bounce leaves the restitution squared"),
    "settling-grains": Wanted(settling_of_the_coarse, 1.0, 0.02, "Stokes's law"),
    "tank-at-rest": Wanted(floor_pressure, 1.0, 0.03, "the weight of the water above"),
    "dam-break": Wanted(front_speed, 1.7, 0.15, "faster than a bore, slower than 2, a thin sheet without friction"),
    "dam-break-3d": Wanted(sides_alike, 1.0, 0.05, "both sides of the tank are alike"),
    "sloshing": Wanted(swing, 1.0 / 0.76, 0.04, "it swings as it is shaken"),
    "channel": Wanted(peak_over_mean, 1.5, 0.08, "a parabola"),
    "swinging-drop": Wanted(second_stretch, 0.0, 0.15, "an ellipse's exact motion"),
    "rounding-drop": Wanted(roundness, 1.0, 0.1, "surface tension makes it round"),
    "taylor-green": Wanted(decay, 1.0, 0.04, "viscosity alone fades it"),
    "t1": Wanted(swaps, 1, 0, "one swap of neighbors"),
    "sheared-packing": Wanted(stress_of_its_parts, 1.0, 1e-9, "films carry all of the stress"),
    "settling-packing": Wanted(carried_weight, 1.0, 0.01, "in the end the floor carries the weight"),
}


def test_every_example_has_its_number_and_its_clip():
    assert sorted(path.stem for path in SCENES) == sorted(WANTED)
    assert len(SCENES) >= 15
    clips = list((ROOT / "docs" / "clips").iterdir())
    shown = {path.stem for path in clips}
    assert set(WANTED) <= shown <= {*WANTED, *templates()}
    assert {path.name for path in clips} == {f"{name}.{kind}" for name in shown for kind in ("mp4", "webp")}
    assert sum(path.stat().st_size for path in clips) < 6_000_000


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    "path", [pytest.param(path, marks=[pytest.mark.long] * (path.stem in LONG), id=path.stem) for path in SCENES]
)
def test_an_example_runs_and_its_number_is_right(path):
    frames = list(ecume.simulate(ecume.load_scene(path)))
    measure, value, tolerance, why = WANTED[path.stem]
    expected = exact_second_stretch() if path.stem == "swinging-drop" else value
    assert measure(frames) == pytest.approx(expected, abs=tolerance), why
    # Of a change that is meant, the numbers are recorded anew: python -m tests.torture.regression NAME
    assert differing(frames, recorded()[path.stem], same=False) == {}
