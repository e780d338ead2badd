"""Inputs of floats that once failed, each with the result it must have."""

import shutil
import time
from pathlib import Path

import gsd.hoomd
import numpy as np
import pytest

from ecume.analysis.series import tracks
from ecume.analysis.structure import mean_square_displacement
from ecume.models import MODELS
from ecume.models.floating.setup.hydrodynamic_interaction import GasWarning
from ecume.run import RunOptions
from ecume.run import run as simulated
from ecume.run.imports import import_run
from ecume.scenes.load import load_scene
from ecume.show.figures import FIGURES
from ecume.simulation import simulate
from ecume.trajectories.exports import export
from ecume.trajectories.foreign import dumps
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory

CASES = Path(__file__).parent / "cases"
CELL = '[cell]\nsize = ["10 cm", "8 cm"]\n'
BEADS = '[[particles]]\ndensity = 1250.0\ncontact_angle = "90 deg"\n'
HEAD = 'model = "floating"\nduration = "{duration} s"\nframe_every = "0.1 s"\n'


def from_file(folder, file, around=CELL, duration=0.1, units='length_unit = "1 m"\ntime_unit = "1 s"\n'):
    """A scene file that starts from a file of a case."""
    if file != folder / Path(file).name:
        shutil.copy(CASES / file, folder)
    start = f'[start_from]\nfile = "{Path(file).name}"\n{units}'
    path = folder / "scene.toml"
    path.write_text(HEAD.format(duration=duration) + start + BEADS + around)
    return path


@pytest.mark.parametrize("file", ["image_flags.dump", "image_flags_unwrapped.dump"])
def test_image_flags(file, tmp_path):
    import_run(from_file(tmp_path, file, duration=0.5, units='length_unit = "1 m"\n'), tmp_path / "run")
    with open_trajectory(tmp_path / "run") as frames:
        path = tracks(list(frames))
    assert path[:, 0, 0] == pytest.approx(0.005 - 0.06 * np.arange(6))
    assert mean_square_displacement(path[:, :1], [5])[0] == pytest.approx(0.09)


def long_dump(frames, count=40):
    """A dump whose particles move by 1 mm per frame along x."""
    head = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS ff ff pp\n-9 9\n-9 9\n-1 1\n"
    columns = "ITEM: ATOMS id type x y z radius\n"
    return "".join(
        head.format(k, count) + columns + "".join(f"{i + 1} 1 {1e-3 * k:.9f} {i} 0 0.001\n" for i in range(count))
        for k in range(frames)
    )


def seconds_per_frame(frames):
    """Of processor time, to read all frames of a dump, each found where it belongs."""
    text = long_dump(frames)
    began = time.thread_time()
    count, read = dumps.series(text)
    found = [read(k).position[0, 0] for k in range(count)]
    spent = time.thread_time() - began
    assert found == pytest.approx(1e-3 * np.arange(frames))
    return spent / frames


def test_long_dump():
    """Eight times as many frames take as long per frame; dividing the text again for each took eight times as long.
    Both are timed in turns: coverage slows down the first half second of a test.
    """
    seconds_per_frame(20)
    rounds = [(seconds_per_frame(800), seconds_per_frame(100)) for _ in range(4)]
    long, short = (min(column) for column in zip(*rounds, strict=True))
    assert long < 2.5 * short


def test_msd_long_periodic():
    """A float drifts by a quarter of the cell per frame; figures show 400 of 1,200 frames."""
    cell, frames = np.array([0.1, 0.08]), []
    body = BEADS + 'radius = "1 mm"\npositions = [["9 cm", "4 cm"]]\n'
    scene = load_scene(HEAD.format(duration=0.1) + CELL + body)
    first = next(iter(simulate(scene)))
    for k in range(1200):
        image, place = np.divmod(np.array([[0.09 + 0.025 * k, 0.04]]), cell)
        arrays = {**first.arrays, "position": place, "image": image.astype(first.arrays["image"].dtype)}
        frames.append(Frame(float(k), arrays, first.numbers, first.units))
    line = FIGURES["floating"]["displacement"](frames, scene).axes[0].lines[0]
    lag, square = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    assert square == pytest.approx((0.025 * lag) ** 2, rel=1e-6)
    assert lag.max() > 300.0


def test_hoomd_periodic_import(tmp_path):
    for depth in (0.0, 1.0):
        with gsd.hoomd.open(tmp_path / "two.gsd", "w") as file:
            for k in range(2):
                frame = gsd.hoomd.Frame()
                frame.configuration.step, frame.configuration.dimensions = 100 * k, 2
                frame.configuration.box = [100.0, 80.0, depth, 0.0, 0.0, 0.0]
                frame.particles.N, frame.particles.types = 3, ["A"]
                frame.particles.position = [[-40.0 + k, 10.0, 0.0], [0.0, 0.0, 0.0], [30.0, 30.0, 0.0]]
                frame.particles.diameter = [2.0] * 3
                file.append(frame)
        scene = from_file(tmp_path, tmp_path / "two.gsd", units='length_unit = "1 mm"\ntime_unit = "1 s"\n')
        scene.write_text(scene.read_text().replace("[[particles]]\n", '[[particles]]\nname = "A"\n'))
        done = import_run(scene, tmp_path / f"run-{depth}")
        assert done.frames == 2
        with open_trajectory(done.directory) as frames:
            path = tracks(list(frames))
        assert path[1] - path[0] == pytest.approx(np.array([[1e-3, 0.0], [0.0, 0.0], [0.0, 0.0]]), abs=1e-9)


def test_oil_water():
    text = HEAD.format(duration=1.0) + "[liquid]\ndensity = 998.0\ngas_density = 770.0\nsurface_tension = 0.053\n"
    places = 'radius = "100 um"\npositions = [[0.0, 0.0], [1e-3, 0.0]]\n'
    with pytest.warns(GasWarning, match="drag is that of the lower liquid alone"):
        alone = MODELS["floating"].parameters(load_scene(text + BEADS + places))
    both = MODELS["floating"].parameters(load_scene(text + "gas_viscosity = 1e-3\n" + BEADS + places))
    assert both.floats.relaxation_time == pytest.approx(0.5 * alone.floats.relaxation_time, rel=1e-3)


@pytest.mark.filterwarnings("ignore:.*energy:UserWarning")
@pytest.mark.parametrize("overlap", ["0.0005", "0.002"])
def test_overlapping_start(overlap, tmp_path):
    dish = '[dish]\nradius = "5 cm"\ncontact_angle = "90 deg"\n'
    scene = load_scene(from_file(tmp_path, f"overlapping_start_{overlap}.dump", dish, units='length_unit = "1 m"\n'))
    simulated(scene, tmp_path / "run", options=RunOptions(on_violation="stop"))
    with open_trajectory(tmp_path / "run") as frames:
        last = frames[-1]
    assert last.numbers["deepest_overlap"] < 1e-4 * last.arrays["radius"].min()
    assert last.numbers["contacts"] == 3.0


def test_polydisperse_file(tmp_path):
    text = (CASES / "polydisperse_file.data").read_text()
    diameters = [
        float(line.split()[2]) for line in text.split("# sphere")[1].split("Velocities")[0].strip().split("\n")
    ]
    dish = '[dish]\nradius = "3 cm"\n'
    scene = load_scene(from_file(tmp_path, "polydisperse_file.data", dish, units='length_unit = "1 m"\n'))
    assert MODELS["floating"].parameters(scene).floats.radius == pytest.approx(0.5 * np.array(diameters))


@pytest.mark.parametrize("kind", ["scaled", "tri0", "units_time"])
def test_right_dumps(kind, tmp_path):
    import_run(from_file(tmp_path, f"right_dumps_{kind}.dump"), tmp_path / "run")
    with open_trajectory(tmp_path / "run") as frames:
        found = [frame.arrays["position"] for frame in frames]
    expected = np.array([[0.01, 0.01], [0.02, 0.01], [0.05, 0.06]])
    assert found[0] == pytest.approx(expected)
    assert found[1] - found[0] == pytest.approx(np.array([[1e-3, 0.0], [0.0, 0.0], [0.0, 0.0]]), abs=1e-9)


def test_xyz_periodic(tmp_path):
    places = 'radius = "1 mm"\npositions = [["0.5 mm", "4 cm"], ["98.4 mm", "4 cm"], ["5 cm", "4 cm"]]\n'
    simulated(load_scene(HEAD.format(duration=0.1) + CELL + BEADS + places), tmp_path / "pair")
    head, *rows = export(tmp_path / "pair", "xyz", tmp_path / "pair.xyz").read_text().split("\n")[1:5]
    assert 'Lattice="0.1 0' in head.replace("0.0 ", "0 ")
    assert 'pbc="T T F"' in head
    names = head.split('Properties="' if 'Properties="' in head else "Properties=")[1].split(" ")[0].split(":")
    column = sum(int(names[k + 2]) for k in range(0, names.index("pos"), 3))
    x = [float(row.split()[column]) for row in rows[:2]]
    apart = x[1] - x[0]
    assert abs(apart - 0.1 * round(apart / 0.1)) == pytest.approx(2.1e-3, rel=1e-3)


TRACERS = """model = "tracers"
duration = "0.2 s"
frame_every = "0.1 s"
seed = 3
[liquid]
viscosity = "1 mPa*s"
[[particles]]
count = 7
radius = "1 mm"
density = 1000.0
[tank]
low = {low}
high = {high}
periodic = ["x"]
[flow]
velocity = [0.7, 0.0]
"""
TANK = """model = "sph"
duration = "2 ms"
frame_every = "1 ms"
spacing = 0.1
[tank]
low = {low}
high = {high}
left.kind = "periodic"
right.kind = "periodic"
[[fluid]]
low = {low}
high = {full}
velocity = [2.0, 0.0]
"""


@pytest.mark.parametrize("low", [(0.0, 0.0), (1.5, -2.0), (-0.25, 0.75)])
@pytest.mark.parametrize("text", [TRACERS, TANK])
def test_xyz_of_a_tank_has_the_box_of_its_particles(text, low, tmp_path):
    """Sibling of `xyz_periodic`: with its origin a box contains all particles, in each frame at the same place."""
    high, full = [low[0] + 0.8, low[1] + 0.6], [low[0] + 0.8, low[1] + 0.3]
    (tmp_path / "scene.toml").write_text(text.format(low=list(low), high=high, full=full))
    simulated(load_scene(tmp_path / "scene.toml"), tmp_path / "run")
    lines = export(tmp_path / "run", "xyz", tmp_path / "run.xyz").read_text().splitlines()
    with open_trajectory(tmp_path / "run") as frames:
        for number, frame in enumerate(frames):
            comment = lines[1 + number * (len(frame.arrays["position"]) + 2)]
            lattice = np.array(comment.split('Lattice="')[1].split('"')[0].split(), float).reshape(3, 3)
            origin = np.zeros(3)
            if 'Origin="' in comment:
                origin = np.array(comment.split('Origin="')[1].split('"')[0].split(), float)
            assert origin[0] == low[0]
            assert lattice[0, 0] == pytest.approx(0.8)
            share = (frame.arrays["position"] - origin[:2]) / np.diag(lattice)[:2]
            assert share.min() >= -1e-12
            assert share.max() <= 1.0 + 1e-12
