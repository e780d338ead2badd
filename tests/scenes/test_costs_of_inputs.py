"""Small inputs have small costs: the time of each reader grows no faster than its input."""

import contextlib
import time

import numpy as np
import pytest

from ecume.errors import EcumeError, SceneError
from ecume.scenes.load import load_and_examine, load_scene
from ecume.sweep.spec import load_sweep
from ecume.trajectories import gsd
from ecume.trajectories.foreign import xyz
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
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
