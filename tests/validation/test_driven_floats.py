"""The references of the cases of waves and clusters, without their runs."""

import math

import numpy as np
import pytest
from scipy.special import k0

from ecume.laws.brownian import thermal_energy
from ecume.validation import clusters, waves


def test_the_kernel_has_the_wavelengths_of_the_dispersion_relation():
    rows = list(waves.dispersion())
    assert len(rows) == len(waves.FREQUENCIES)
    assert all(row.met for row in rows)


def test_a_spinner_has_three_equal_arms():
    points = waves.spinner_points().reshape(3, waves.POINTS, 2)
    reach = np.linalg.norm(points, axis=2)
    assert reach == pytest.approx(np.tile(reach[0], (3, 1)))
    assert points.mean(axis=(0, 1)) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert np.linalg.norm(points[0, -1] - points[0, 0]) == pytest.approx(waves.ARM)


def test_phase_differences_are_folded_by_the_symmetry_of_three_arms():
    assert [waves.folded(phase) for phase in (0.3, -0.3, 2.0 * waves.THIRD + 0.3)] == pytest.approx([0.3] * 3)


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
