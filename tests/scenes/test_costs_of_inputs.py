"""Small inputs have small costs: the time of each reader grows no faster than its input."""

import contextlib
import json
import struct
import time
import tracemalloc

import numpy as np
import pytest

from ecume.errors import EcumeError, SceneError
from ecume.run import RunDirectory
from ecume.run.archives import arrays_of
from ecume.run.scalars import lines_of
from ecume.scenes.load import load_scene
from ecume.scenes.sph.sources import _triangles, _vertices
from ecume.scenes.tables import lines_of as lines_of_table
from ecume.scenes.valid_part import load_and_examine
from ecume.show.publishing import read_measured
from ecume.sweep.directory import json_at, written
from ecume.sweep.spec import load_sweep
from ecume.trajectories import gsd
from ecume.trajectories.foreign import dcd, dumps, lammps, xyz
from ecume.trajectories.foreign import gsd as foreign_gsd
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.records import json_of, sealed_line
from ecume.trajectories.samples import Samples
from ecume.trajectories.segments import NAMES_LOCATION, Recorder

HEAD = 'model = "floating"\nduration = "1 s"\nframe_every = "0.1 s"\n'
KEYS = {
    "plain": lambda size: ".".join("a" * size) + " = 1",
    "quoted": lambda size: '"\\"".' + ".".join("a" * size) + " = 1",
    "no value": lambda size: '"\\"".' + ".".join("a" * size),
    "literal": lambda size: "'\"'." + ".".join("a" * size) + " = 1",
    "after a text": lambda size: 't = """a"b\n"""\n' + ".".join("a" * size) + " = 1",
    "inline": lambda size: "x = {" + ".".join("a" * size) + " = 1}",
    "lists": lambda size: "a = " + "[" * size,
    "tables": lambda size: "a = " + "{b = " * size,
    "open texts": lambda size: '\\"""' * size,
    "words": lambda size: "title = x" + " y" * size,
    "title": lambda size: f'title = "{"." * size}"',
}


def seconds(action):
    began = time.process_time()
    with contextlib.suppress(EcumeError):
        action()
    return time.process_time() - began


@pytest.mark.parametrize("kind", KEYS)
def test_a_scene_costs_little(tmp_path, kind):
    """Also where all faults are looked for."""
    path = tmp_path / "scene.toml"
    path.write_text(HEAD + KEYS[kind](200_000))
    assert seconds(lambda: load_scene(path)) < 3.0
    assert seconds(lambda: load_and_examine(path, [], lambda scene: None)) < 6.0


def test_a_text_with_many_dots_is_no_deep_key():
    with pytest.raises(SceneError, match="particles"):
        load_scene(HEAD + f'title = "{"." * 90}"\n')


def test_a_span_costs_little(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(f'scene = "s.toml"\n[[axes]]\nkey = "a"\nspan = {{ start = "{"1" * 400_000}", stop = "2 mm" }}\n')
    assert seconds(lambda: load_sweep(path)) < 3.0


def test_a_comment_of_a_file_costs_little():
    for text in ("a" * 400_000, "a " * 200_000, 'a="' * 100_000):
        assert seconds(lambda text=text: xyz.PAIR.findall(text)) < 3.0


def frame(time):
    return Frame(time, {"position": np.zeros((2, 2))}, {"energy": 1.0}, {"position": "m", "energy": "J"})


@pytest.mark.parametrize("between", [b"", b"\xff" * 32])
def test_an_index_that_is_repeated_costs_little(tmp_path, between):
    with Recorder(tmp_path / "traj") as recorder:
        recorder.write(frame(0.0), 0)
        recorder.write(frame(1.0), 1)
    path = tmp_path / "traj" / "0000.gsd"
    content = bytearray(path.read_bytes())
    header = np.frombuffer(bytes(content[:256]), gsd.FILE_HEADER).copy()
    header["index_room"] = 1 << 20
    content[:256] = header.tobytes()
    first = bytes(content[256:288])
    assert NAMES_LOCATION > 288
    path.write_bytes(bytes(content) + (first + between) * 60_000)
    assert seconds(lambda: len(open_trajectory(tmp_path / "traj"))) < 3.0


def frames_of(folder, size):
    """A trajectory of so many frames."""
    with Recorder(folder / "traj") as recorder:
        for number in range(size):
            recorder.write(frame(float(number)), number)
    return folder / "traj"


def text_at(folder, name, text):
    (folder / name).write_text(text)
    return folder / name


DUMP = (
    "ITEM: TIMESTEP\n{0}\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n"
    "ITEM: ATOMS id type x y z\n1 1 0 0 0\n"
)


def positions(size):
    listed = ",".join(f'["{number} mm","0 mm"]' for number in range(size))
    return f'{HEAD}[[particles]]\nradius = "0.4 mm"\ndensity = 600\ncontact_angle = "70 deg"\npositions = [{listed}]\n'


def archive(folder, size):
    np.savez(folder / "state.npz", allow_pickle=False, **{f"state.{k}": np.zeros(9) for k in range(size)})
    return folder / "state.npz"


def read_archive(path):
    with path.open("rb") as file:
        return arrays_of(file, path)


def surface(folder, size):
    """A ball of about so many triangles."""
    trimesh = pytest.importorskip("trimesh")
    rings = max(3, int((size / 2) ** 0.5))
    ball = trimesh.creation.uv_sphere(1.0, count=(rings, rings))
    return trimesh.exchange.stl.export_stl_ascii(ball).encode()


def drawing(folder, size):
    """An outline of so many corners."""
    ezdxf = pytest.importorskip("ezdxf")
    document, turn = ezdxf.new(), np.linspace(0.0, 2.0 * np.pi, size, endpoint=False)
    document.modelspace().add_lwpolyline(np.column_stack((np.cos(turn), np.sin(turn))), close=True)
    document.saveas(folder / "outline.dxf")
    return (folder / "outline.dxf").read_bytes()


def dcd_record(content):
    length = struct.pack("<i", len(content))
    return length + content + length


def dcd_of(folder, size):
    """One particle in so many frames."""
    head = dcd_record(b"CORD" + bytes(80)) + dcd_record(b"") + dcd_record(struct.pack("<i", 1))
    (folder / "a.dcd").write_bytes(head + 3 * dcd_record(struct.pack("<f", 1.0)) * size)
    return folder / "a.dcd"


def gsd_of(folder, size):
    """A run's own frames, read as those of a foreign program."""
    return frames_of(folder, size) / "0000.gsd"


def all_frames(module):
    return lambda path: [module.read(path, number) for number in range(module.frames(path))]


def all_of(series):
    frames, read = series
    return [read(number) for number in range(frames)]


def refused(text):
    with pytest.raises(SceneError):
        load_scene(text)


READERS = {
    "scene": (400, lambda here, n: positions(n), load_scene),
    "keys of a table": (
        2000,
        lambda here, n: HEAD + "[liquid]\n" + "".join(f"a{k} = {k}\n" for k in range(n)),
        refused,
    ),
    "sweep": (
        1000,
        lambda here, n: text_at(
            here, "s.toml", f'scene = "a.toml"\n[[axes]]\nkey = "seed"\nvalues = {list(range(n))}\n'
        ),
        load_sweep,
    ),
    "table": (4000, lambda here, n: "x [m],y [m]\n" + "1.0,2.0\n" * n, lines_of_table),
    "xyz": (
        400,
        lambda here, n: "1\nProperties=species:S:1:pos:R:3\nH 0 0 0\n" * n,
        lambda text: all_of(xyz.series(text)),
    ),
    "dump": (400, lambda here, n: "".join(map(DUMP.format, range(n))), lambda text: all_of(dumps.series(text))),
    "data": (
        4000,
        lambda here, n: (
            f"title\n\n{n} atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # atomic\n\n"
            + "".join(f"{k + 1} 1 0 0 0\n" for k in range(n))
        ),
        lammps.read,
    ),
    "frames": (300, frames_of, lambda path: list(open_trajectory(path))),
    "numbers of frames": (300, frames_of, lambda path: open_trajectory(path).times),
    "samples": (
        2000,
        lambda here, n: text_at(here, "samples.csv", "step,time [s],energy [J]\n" + "1,2.0,3.0\n" * n),
        Samples,
    ),
    "lines": (
        2000,
        lambda here, n: RunDirectory(text_at(here, "scalars.jsonl", sealed_line({"step": 1, "time": 0.5}) * n).parent),
        lambda home: list(lines_of(home)),
    ),
    "checkpoint": (500, archive, read_archive),
    "record": (4000, lambda here, n: text_at(here, "a.json", json.dumps({f"k{k}": k for k in range(n)})), json_of),
    "points": (
        4000,
        lambda here, n: text_at(here, "p.json", written({f"k{k}": k for k in range(n)}, here / "p.json")),
        lambda path: json_at(path, dict),
    ),
    "surface": (1500, surface, lambda content: _triangles(content, None)),
    "drawing": (1500, drawing, lambda content: _vertices(content, None)),
    "dcd": (400, dcd_of, all_frames(dcd)),
    "foreign gsd": (150, gsd_of, all_frames(foreign_gsd)),
    "experiment": (2000, lambda here, n: text_at(here, "e.csv", "time [s],p [Pa]\n" + "1.0,2.0\n" * n), read_measured),
}
GROWTH = 4
"""Times the size."""


def peak(action):
    tracemalloc.start()
    action()
    _, highest = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return highest


def fastest(action):
    return min(seconds(action) for _ in range(3))


@pytest.mark.long
@pytest.mark.parametrize("name", READERS)
def test_time_and_memory_per_byte_stay_flat(tmp_path, name):
    """Four times the input takes about four times the time and the memory, not sixteen times."""
    size, make, read = READERS[name]
    made = []
    for number, count in enumerate((size, GROWTH * size)):
        (tmp_path / str(number)).mkdir()
        made.append(make(tmp_path / str(number), count))
    few, many = (fastest(lambda one=one: read(one)) for one in made)
    assert many < 2.0 * GROWTH * few + 0.05
    less, more = (peak(lambda one=one: read(one)) for one in made)
    assert more < 1.5 * GROWTH * less + 2e5


def test_the_growing_input_finds_what_is_quadratic():
    def quadratic(size):
        return [sum(range(place)) for place in range(size)]

    few, many = (fastest(lambda size=size: quadratic(size)) for size in (1500, 1500 * GROWTH))
    assert many > 2.0 * GROWTH * few + 0.05
