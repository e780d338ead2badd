"""Measures in frames of soft spheres: stresses by contribution, velocities, neighbors."""

import math

import numpy as np
import pytest

from ecume.analysis.boxes import box_of, nearest
from ecume.analysis.close_pairs import coordination, films
from ecume.analysis.rearrangements import nonaffine_displacement
from ecume.analysis.rheology import stress_tensor
from ecume.laws.long_range import steric_force
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

pytestmark = pytest.mark.compiled


def sheared(dimensions=2, count=10, steps=4, **more):
    """Frames of a packing that is sheared and compressed."""
    volume = count * sum(math.pi * r**2 if dimensions == 2 else 4 / 3 * math.pi * r**3 for r in (1.0, 1.3))
    plain = {
        "model": "soft", "duration": 4.0, "frame_every": 4.0 / steps, "liquid": {"viscosity": 1e-2},
        "particles": [{"radius": r, "modulus": 1.0, "count": count} for r in (1.0, 1.3)],
        "cell": {"size": [(volume / (0.7 if dimensions == 2 else 0.45)) ** (1 / dimensions)] * dimensions,
            "minimum_gap": 0.02},
        "protocol": [{"time": 0.0}, {"time": 4.0, "strain": 0.2, "scale": 0.99}],
        "integration": {"tolerance": 1e-5},
    }  # fmt: skip
    return list(simulate(from_plain(plain | more)))


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_parts_of_the_stress_make_the_stress_of_the_frame(dimensions):
    frame = sheared(dimensions, steps=1)[-1]
    tensor = stress_tensor(frame)
    assert tensor[0, 1] == pytest.approx(frame.numbers["shear_stress"])
    assert -np.trace(tensor) / dimensions == pytest.approx(frame.numbers["pressure"])
    assert -tensor[1, 1] == pytest.approx(frame.numbers["normal_stress"])
    assert frame.numbers["viscosity"] == pytest.approx(tensor[0, 1] / 0.05, rel=1e-9)
    # Films are sheared along their surfaces: their part has nearly no trace, and resists.
    sliding = stress_tensor(frame, "sliding")
    assert abs(np.trace(sliding)) < 0.1 * sliding[0, 1]
    assert 0.0 < sliding[0, 1] < tensor[0, 1]


def test_two_spheres_across_a_border_carry_the_stress_of_their_force_and_distance():
    # One pair in a wide box, pressed by a steric force: sigma_xx = -F r / A, in the frame's own parts.
    plain = {
        "model": "soft", "duration": 1e-6, "frame_every": 1e-6, "liquid": {"viscosity": 1.0},
        "hydrodynamics": {"drag": "stokes"},
        "particles": [{"radius": 1.0, "modulus": 10.0, "positions": [[0.5, 3.0], [7.4, 3.0]]}],
        "cell": {"size": [9.0, 8.0]}, "films": {"cutoff": 0.5},
        "long_range_forces": {"law": "steric", "steric_strength": 0.02, "steric_length": 0.3},
    }  # fmt: skip
    frame = next(iter(simulate(from_plain(plain))))
    gap = films(frame).gap[0]
    assert gap == pytest.approx(0.1)
    assert nearest(np.diff(frame.arrays["position"], axis=0), box_of(frame)) == pytest.approx(np.array([[-2.1, 0.0]]))
    wanted = -steric_force(gap, 0.02, 0.3) * 2.1 / 72.0
    assert stress_tensor(frame, "remote") == pytest.approx(np.diag([wanted, 0.0]), abs=1e-12)
    # Nothing is deflected as yet: the film, which the spheres' flight squeezes, holds against it.
    assert stress_tensor(frame)[0, 0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("dimensions", [2, 3])
def test_velocities_are_those_of_the_copies_in_the_box(dimensions):
    before, after = sheared(dimensions, steps=400)[-2:]
    box = box_of(after)
    moved = nearest(after.arrays["position"] - before.arrays["position"], box)
    crossed = np.abs(after.arrays["position"] - before.arrays["position"]).max(axis=1) > 1.0
    velocity = moved / (after.time - before.time)
    scale = np.abs(velocity).max()
    assert after.arrays["velocity"][~crossed] == pytest.approx(velocity[~crossed], abs=0.05 * scale)
    assert np.abs(nonaffine_displacement(before, after)).max() < np.abs(moved).max()


def test_coordination_counts_what_is_closer_than_a_tenth_of_the_smaller_radius():
    frame = sheared(count=8, steps=1)[-1]
    found = films(frame)
    smaller = frame.arrays["radius"][found.pairs].min(axis=1)
    close = found.gap < 0.1 * smaller
    assert frame.numbers["coordination"] == pytest.approx(2.0 * close.sum() / 16)
    assert frame.numbers["mean_gap"] == pytest.approx(np.exp(np.log(found.gap[close]).mean()))
    equal = frame._replace(arrays=frame.arrays | {"radius": np.ones(16)})
    assert coordination(equal, gap=0.1).mean() <= frame.numbers["coordination"]


def test_at_the_start_nothing_is_sheared_and_there_is_no_viscosity():
    first = sheared(count=4, steps=1)[0]
    assert first.numbers["strain_rate"] == 0.0
    assert math.isnan(first.numbers["viscosity"])
