"""Driven floats: waves, rigid clusters and swimmers, in numbers that need no run."""

import math

import numpy as np
import pytest
from scipy.special import k0

from ecume.laws.brownian_motion import thermal_energy
from ecume.laws.pair_mobility import surface_mobility
from ecume_validation import clusters, driven_floats
from ecume_validation.driven_floats import PER_PERIOD, closed_form


def test_the_kernel_has_the_wavelengths_of_the_dispersion_relation():
    rows = list(driven_floats.dispersion())
    assert len(rows) == len(driven_floats.FREQUENCIES)
    assert all(row.met for row in rows)


def test_a_spinner_has_three_equal_arms():
    points = driven_floats.spinner_points().reshape(3, driven_floats.POINTS, 2)
    reach = np.linalg.norm(points, axis=2)
    assert reach == pytest.approx(np.tile(reach[0], (3, 1)))
    assert points.mean(axis=(0, 1)) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert np.linalg.norm(points[0, -1] - points[0, 0]) == pytest.approx(driven_floats.ARM)


def test_phase_differences_are_folded_by_the_symmetry_of_three_arms():
    assert [driven_floats.folded(phase) for phase in (0.3, -0.3, 2.0 * driven_floats.THIRD + 0.3)] == pytest.approx(
        [0.3] * 3
    )


def test_bonds_of_six_spheres_have_the_labels_of_the_ground_states():
    weights = clusters.weights_of_ground_states()
    assert list(weights.values()) == pytest.approx([weights[next(iter(weights))] * n for n in (1, 3, 3)])
    for label, steps in zip(weights, clusters.GROUND_STATES.values(), strict=True):
        place = 2.02 * clusters.RADIUS * np.array(steps) @ clusters.LATTICE
        assert clusters.label_of(place) == label
        assert clusters.label_of(1.5 * place) != label


def test_the_share_of_a_label_has_the_error_of_independent_groups():
    found = clusters.share_of("a", ["a", "b"], [["a", "b", "c"], ["a", "a", "b", "b"]])
    assert found == pytest.approx((0.5, 0.0))
    assert clusters.share_of("a", ["a", "b"], [["a"], ["b"]]).error == pytest.approx(0.5)


def test_menisci_weigh_rigid_clusters_by_the_distances_of_their_spheres():
    scene = clusters.scene_of(np.zeros((1, 2)), {}, 1, clusters.CAPILLARY)
    found = np.array(clusters.capillary_energies(scene)) / thermal_energy(clusters.TEMPERATURE)
    # Pairs at 1, sqrt(3), 2 and sqrt(7) diameters, with the capillary length in diameters.
    length = math.sqrt(1e-6 / (1000.0 * 9.81)) / (2.0 * clusters.RADIUS)
    pairs = np.array([[9, 3, 3, 0], [9, 3, 2, 1], [9, 4, 2, 0]])
    sums = pairs @ k0(np.sqrt([1.0, 3.0, 4.0, 7.0]) / length)
    assert found / found[0] == pytest.approx(sums / sums[0], rel=1e-9)
    assert found[1] - found[2] == pytest.approx(0.97, abs=0.05)


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
