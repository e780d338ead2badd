"""Three spheres in a row whose distances follow a loop: how far they swim in a period."""

import math

import numpy as np
import pytest

from ecume.laws.pair_mobility import surface_mobility
from ecume.validation.swimmers import PER_PERIOD, closed_form

SIZE = np.array([2e-4, 2.5e-4, 3e-4])


def swum(first, second, size):
    """The positions (frames, 3, 2) of spheres free of forces whose two distances are given, by their mobilities."""
    track = np.zeros((len(first), 3, 2))
    track[0, :, 0] = [0.0, first[0], first[0] + second[0]]
    for step in range(1, len(first)):
        middle = np.array([0.0, first[step - 1] + first[step], first[step - 1] + first[step]]) / 2.0
        middle[2] += 0.5 * (second[step - 1] + second[step])
        mobility = surface_mobility(np.stack([middle, np.zeros(3)], axis=1), size, 1.0)[::2, ::2]
        # Unknown forces on the first two spheres; the third has the opposite of their sum.
        free = mobility @ np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]])
        opening = np.array([first[step] - first[step - 1], second[step] - second[step - 1]])
        moved = free @ np.linalg.solve(np.diff(free, axis=0), opening)
        track[step] = track[step - 1]
        track[step, :, 0] += moved
    return track


def stretched(delay, amplitude=0.02):
    phase = 2.0 * math.pi * np.arange(PER_PERIOD + 1) / PER_PERIOD
    return 4e-3 * (1.0 + amplitude * np.cos(phase)), 5e-3 * (1.0 + amplitude * np.cos(phase - delay))


@pytest.mark.parametrize("delay", [0.5 * math.pi, -0.7])
def test_the_closed_form_is_the_displacement_of_small_strokes(delay):
    track = swum(*stretched(delay), SIZE)
    found = track[-1, 0, 0] - track[0, 0, 0]
    assert abs(found) > 1e-7
    assert found == pytest.approx(closed_form(track, SIZE), rel=0.15)


def test_a_stroke_that_is_the_same_backward_and_one_of_a_mirror_image_lead_nowhere():
    there = swum(*stretched(0.5 * math.pi), SIZE)
    far = abs(there[-1, 0, 0])
    for delay, size in ((0.0, SIZE), (math.pi, SIZE)):
        assert abs(swum(*stretched(delay), size)[-1, 0, 0]) < 1e-4 * far
    turned = swum(*stretched(0.5 * math.pi)[::-1], SIZE[::-1])
    assert turned[-1, 0, 0] == pytest.approx(-there[-1, 0, 0], rel=1e-6)
