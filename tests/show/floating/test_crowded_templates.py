"""Templates from the file to the picture, shortened: a run on disk, its energy budget, and what is drawn of it."""

from importlib.resources import files

import numpy as np
import pytest

from ecume.run import run
from ecume.scenes.load import load_scene
from ecume.show.floating.bowl import Bowl
from ecume.show.picture import Size
from ecume.trajectories.reader import open_trajectory


def shortened(name, folder, *changes):
    """The frames of a template's run with these changes, and its scene."""
    scene = load_scene(files("ecume") / "templates" / f"{name}.toml", changes)
    run(scene, folder)
    with open_trajectory(folder) as trajectory:
        return list(trajectory), scene


def painted(frames, scene):
    """The pixels of the last frame, and how many are not those of the first."""
    picture = Bowl(scene, [frames[0], frames[-1]], Size(320, 240), cells=60)
    first, last = picture.pixels(frames[0]).copy(), picture.pixels(frames[-1]).copy()
    return last, int(np.sum(np.any(first != last, axis=2)))


@pytest.mark.long
@pytest.mark.compiled
def test_mermaids_run_and_are_drawn(tmp_path):
    frames, scene = shortened(
        "mermaid", tmp_path / "run", "particles[0].count=24", "dish.radius=15 mm", "duration=0.4 s", "frame_every=0.2 s"
    )
    first, last = frames[0], frames[-1]
    assert len(frames) == 3
    assert last.arrays["magnetic_moment"] == pytest.approx(23.6e-6)
    # Viscous and inelastic: energy only goes, and the dipoles' is in the budget.
    totals = [frame.numbers["total_energy"] for frame in frames]
    assert totals[0] > totals[1] > totals[2]
    assert last.numbers["deepest_overlap"] < 1e-3 * 1.5e-3
    assert last.numbers["mean_cluster_size"] >= first.numbers["mean_cluster_size"]
    pixels, changed = painted(frames, scene)
    assert len(np.unique(pixels.reshape(-1, 4), axis=0)) > 50
    assert changed > 500


@pytest.mark.long
@pytest.mark.compiled
def test_colloids_run_and_are_drawn(tmp_path):
    frames, scene = shortened(
        "colloids", tmp_path / "run", "particles[0].count=400", "dish.radius=0.8 mm", "duration=20 s"
    )
    first, last = frames[0], frames[-1]
    assert len(frames) == 3
    # They creep together, and chance moves the ones that are alone: energy falls by far more than kT a float.
    assert first.numbers["total_energy"] - last.numbers["total_energy"] > 400 * 4.0e-21
    moved = np.hypot(*(last.arrays["position"] - first.arrays["position"]).T)
    assert 1e-6 < np.median(moved) < 2e-4
    assert np.all(np.hypot(*last.arrays["position"].T) < 0.8e-3)
    assert last.numbers["deepest_overlap"] < 1e-3 * 20e-6
    _, changed = painted(frames, scene)
    assert changed > 200
