"""The figure of sizes."""

import numpy as np
import pytest

from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.curves import sizes
from ecume.simulation import simulate


def test_equal_sizes_are_in_the_middle_of_one_class_and_all_particles_are_counted():
    scene = load_scene(folder() / "two-spheres.toml")
    frame = next(simulate(scene))
    axes = sizes([frame], scene).axes[0]
    radius = 1e3 * float(np.mean(frame.arrays["radius"]))
    for steps in axes.patches:
        part, edges, _ = steps.get_data()
        full = int(np.argmax(part))
        assert part.sum() == pytest.approx(100.0) == part[full]
        assert 0.5 * (edges[full] + edges[full + 1]) == pytest.approx(radius)
