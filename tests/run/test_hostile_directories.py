"""A run directory may come from anyone: no link in it is followed, and every size is compared with the file."""

import io
import json
import os
import shutil
import socket
import zipfile
from pathlib import Path

import numpy as np
import pytest

import ecume
from ecume import _plain_files
from ecume.errors import EcumeError, StorageError
from ecume.run import RunDirectory, RunOptions, checkpoints, compare, info, list_runs, lock, repair, resume, run
from ecume.run.archives import arrays_of
from ecume.run.directory import manifest_of, write
from ecume.trajectories.gsd import ENTRY
from ecume.trajectories.reader import open_trajectory

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows makes links for administrators alone, and no pipes")
FILES = (
    *("manifest.json", "resolved.json", "scene.toml", "constants.npz", "lock", "scalars.jsonl", "log.jsonl"),
    *("status.json", "watch.json", "DONE.json", "FAILED.json", "traj/0000.gsd", "ckpt/000000000060.npz"),
    *("status.json.part", "manifest.json.part", "watch.json.part", "results/view.html"),
)
FOLDERS = ("traj", "ckpt", "results")
SECRET = "export PATH\n"
COMMAND = "$(touch owned)"


MADE = []


@pytest.fixture
def killed(tmp_path, tmp_path_factory, scene):
    """A run that looks killed, and a start-up file of the user's outside."""
    home = RunDirectory(tmp_path / "run")
    if not MADE:
        MADE.append(tmp_path_factory.mktemp("made") / "run")
        run(scene(duration=0.06), MADE[0], options=RunOptions(checkpoint_every=0.0))
    shutil.copytree(MADE[0], home.path)
    home.done.unlink()
    (tmp_path / "bashrc").write_text(SECRET)
    (tmp_path / "outside").mkdir()
    return home


def symbolic(path: Path, outside: Path) -> None:
    path.symlink_to(outside)


def relative(path: Path, outside: Path) -> None:
    path.symlink_to(os.path.relpath(outside, path.parent))


def pipe(path: Path, outside: Path) -> None:
    os.mkfifo(path)


def endless(path: Path, outside: Path) -> None:
    path.symlink_to("/dev/zero")


def named_socket(path: Path, outside: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one:
        here = Path.cwd()
        os.chdir(path.parent)  # a socket's path is short
        one.bind(path.name)
        os.chdir(here)


VERBS = {
    "resume": resume,
    "info": info,
    "repair": repair,
    "open": lambda path: list(open_trajectory(path)),
    "compare": lambda path: compare(path, path),
    "scene": lambda path: open_trajectory(path).scene,
}


@pytest.mark.parametrize("made", [symbolic, relative, pipe, endless, named_socket])
def test_what_is_no_plain_file_is_refused_by_each_verb(killed, tmp_path, made, scene):
    for name in FILES:
        path = killed.path / name
        path.parent.mkdir(exist_ok=True)
        if there := path.exists():
            path.rename(tmp_path / "kept")
        made(path, tmp_path / "bashrc")
        for verb, asked in VERBS.items():
            if name == "manifest.json" and verb not in ("open", "scene"):
                continue  # not a run then
            with pytest.raises(StorageError, match=r"expected a plain file"):
                asked(killed.path)
        assert [one.state for one in list_runs(tmp_path)] == ["damaged"]
        with pytest.raises(EcumeError):
            run(scene(), killed.path, force=True)
        path.unlink()
        if there:
            (tmp_path / "kept").rename(path)
    assert (tmp_path / "bashrc").read_text() == SECRET
    resume(killed.path)


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_that_is_a_link_is_not_entered(killed, tmp_path, name):
    folder = killed.path / name
    if folder.exists():
        shutil.copytree(folder, tmp_path / "outside" / name)
        shutil.rmtree(folder)
    folder.symlink_to(tmp_path / "outside" / name)
    before = sorted(tmp_path.glob("outside/**/*"))
    for asked in VERBS.values():
        with pytest.raises(StorageError, match="is a link"):
            asked(killed.path)
    assert sorted(tmp_path.glob("outside/**/*")) == before


@pytest.mark.parametrize("name", ["lock", "scalars.jsonl", "log.jsonl", "traj/0000.gsd"])
def test_a_file_with_a_second_name_is_not_added_to(killed, tmp_path, name):
    os.link(killed.path / name, tmp_path / "second")
    before = (tmp_path / "second").read_bytes()
    with pytest.raises(StorageError, match="a second name"):
        resume(killed.path)
    assert (tmp_path / "second").read_bytes() == before


@pytest.mark.parametrize("name", ["status.json", "watch.json", "manifest.json"])
def test_a_file_with_a_second_name_is_replaced_and_the_second_one_stays(killed, tmp_path, name):
    os.link(killed.path / name, tmp_path / "second")
    before = (tmp_path / "second").read_bytes()
    resume(killed.path)
    assert (tmp_path / "second").read_bytes() == before
    assert (killed.path / name).stat().st_nlink == 1


def test_text_of_a_manifest_that_could_act_elsewhere_is_refused(killed):
    plain = manifest_of(killed)
    write(killed, killed.manifest, {**plain, "processor": COMMAND})
    before = killed.log.read_bytes()
    with pytest.raises(StorageError, match=r"processor: got '\$\(touch owned\)'; expected text without"):
        resume(killed.path)
    assert killed.log.read_bytes() == before
    write(killed, killed.manifest, {**plain, "processor": "another one"})
    resume(killed.path)
    assert b"another one" in killed.log.read_bytes()


def test_quotations_from_damaged_files_reach_the_log_without_what_could_act(killed):
    newest = checkpoints.newest_first(killed)[0]
    with zipfile.ZipFile(newest, "w") as archive:
        archive.writestr(f"{COMMAND}`x`.npy", b"no array")
    resume(killed.path)
    line = next(line for line in killed.log.read_text().splitlines() if "set aside" in line)
    assert not set("$`\\") & set(line)


def test_a_process_that_only_a_lock_names_gets_no_signal(killed, monkeypatch):
    got = []
    killed.status.unlink()
    monkeypatch.setattr(lock, "ask_to_stop", got.append)
    for changes, state in (({}, "killed"), ({"host": "elsewhere"}, "running")):
        owner = {**lock._self(), **changes}
        killed.lock.write_bytes(lock.sealed_line(owner).encode().ljust(lock.WIDTH))
        assert info(killed.path).state == state
        assert lock.stop(killed) is False
    assert got == []
    with lock.held(killed):
        assert lock.stop(killed) is True
    assert got == [os.getpid()]


def archive_of(members, method=zipfile.ZIP_STORED):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return stream.getvalue()


def member(shape, kind="<f8", data=b""):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": False, "shape": shape})
    return stream.getvalue() + data


BOMBS = {
    "deflated": (archive_of([("a.npy", member((10**6,), data=bytes(8 * 10**6)))], zipfile.ZIP_DEFLATED), "compressed"),
    "a false header": (archive_of([("a.npy", member((10**15,)))]), "does not fit its data"),
    "negative": (archive_of([("a.npy", member((-1, -8), data=bytes(64)))]), "negative|does not fit|unknown dimension"),
    "objects": (archive_of([("a.npy", member((1,), "|O", bytes(8)))]), "does not fit its data"),
    "nested": (archive_of([("a.npy", b"\x93NUMPY\1\0\x88\x13" + b"(" * 5000)]), "TokenError|nested|Recursion"),
}


@pytest.mark.parametrize("name", BOMBS)
def test_an_archive_larger_than_its_file_is_refused_before_anything_is_allocated(tmp_path, name):
    content, why = BOMBS[name]
    path = tmp_path / "bomb.npz"
    path.write_bytes(content)
    with path.open("rb") as file, pytest.raises(ValueError, match=why):
        arrays_of(file, path)


def test_members_that_share_their_bytes_are_refused(tmp_path):
    content = archive_of([("a.npy", member((1000,), data=bytes(8000)))])
    directory = content.rindex(b"PK\x01\x02")
    entry, end = content[directory : content.rindex(b"PK\x05\x06")], bytearray(content[content.rindex(b"PK\x05\x06") :])
    end[8:12] = (40).to_bytes(2, "little") * 2
    end[12:16] = (40 * len(entry)).to_bytes(4, "little")
    (tmp_path / "bomb.npz").write_bytes(content[:directory] + 40 * entry + end)
    with (tmp_path / "bomb.npz").open("rb") as file, pytest.raises(ValueError, match="larger than the file"):
        arrays_of(file, tmp_path)


def test_frames_whose_data_overlap_are_refused(killed):
    path = killed.trajectory / "0000.gsd"
    content = bytearray(path.read_bytes())
    entries = np.frombuffer(content, ENTRY, 512, 256).copy()
    mine = np.flatnonzero(entries["frame"] == 3)
    entries["location"][mine[1]] = entries["location"][mine[0]]
    content[256 : 256 + entries.nbytes] = entries.tobytes()
    path.write_bytes(content)
    with open_trajectory(killed.path) as trajectory:
        with pytest.raises(StorageError, match="frame 3 is damaged: its data overlap"):
            trajectory[3]
        assert trajectory[4].time == pytest.approx(0.04)


def test_a_size_beyond_the_memory_is_refused(tmp_path):
    path = tmp_path / "sparse"
    with path.open("wb") as file:
        file.truncate(2**42)
    with pytest.raises(_plain_files.TooLarge, match="this process may use"):
        _plain_files.content_of(path, 2**50)
    with pytest.raises(_plain_files.TooLarge, match="expected at most 1"):
        _plain_files.content_of(path, 2**20)


def test_a_file_of_holes_is_not_read_to_its_end(killed):
    with killed.scene.open("wb") as file:
        file.truncate(2**40)
    for asked in VERBS.values():
        with pytest.raises(StorageError, match="is sparse"):
            asked(killed.path)


def test_without_relative_calls_links_are_refused_all_the_same(killed, tmp_path, monkeypatch, results):
    """As on Windows."""
    monkeypatch.setattr(_plain_files, "RELATIVE", False)
    before = results(killed.path)
    resume(killed.path)
    assert results(killed.path) == before
    for name, why in (("log.jsonl", "is a link"), ("traj/0000.gsd", "is a link")):
        (tmp_path / "copy").mkdir()
        shutil.copytree(killed.path, tmp_path / "copy" / "run")
        path = tmp_path / "copy" / "run" / name
        path.unlink()
        path.symlink_to(tmp_path / "bashrc")
        with pytest.raises(_plain_files.NotPlain, match=why):
            _plain_files.opened(path, "r+", tmp_path / "copy" / "run")
        shutil.rmtree(tmp_path / "copy")
    (killed.path / "traj").rename(tmp_path / "elsewhere")
    (killed.path / "traj").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(_plain_files.NotPlain, match="is a link"):
        _plain_files.opened(killed.trajectory / "0000.gsd", "r", killed.path)


@pytest.mark.parametrize("name", ["../bashrc", "traj/../../bashrc"])
def test_no_path_leads_out_of_its_folder(killed, name):
    with pytest.raises(ValueError, match="subpath") if name.startswith("..") else pytest.raises(_plain_files.NotPlain):
        _plain_files.opened(killed.path.parent / name if name[0] == "." else killed.path / name, "r", killed.path)


HEADERS = {
    "far": {"first": 10**30},
    "kind": {"arrays": {"position": ["S1000000000", [2]]}},
    "wide": {"arrays": {"position": ["<f8", [10**12]]}},
    "nothing": {"arrays": {}},
    "units": {"units": 7},
}


@pytest.mark.parametrize("name", HEADERS)
def test_a_header_that_no_run_writes_is_an_error_and_no_allocation(name):
    from ecume.trajectories import gsd

    plain = {"format": 1, "first": 0, "arrays": {"position": ["<f8", [2]]}, "numbers": [], "units": {}}
    chunk = np.frombuffer(json.dumps({**plain, **HEADERS[name]}).encode(), np.uint8)
    with pytest.raises(StorageError, match="header is damaged"):
        gsd.read({gsd.HEADER: chunk}, "0000.gsd")


def test_a_scene_starts_from_no_run_with_links(tmp_path, killed):
    from ecume.scenes.load import load_scene

    (killed.path / "traj").rename(tmp_path / "outside" / "traj")
    (killed.path / "traj").symlink_to(tmp_path / "outside" / "traj")
    text = 'model = "floating"\nduration = 1\nframe_every = 1\nstart_from = "run"\n[liquid]\nviscosity = 1e-3\n'
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(ecume.errors.SceneError, match="is a link; expected a plain file"):
        load_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("name", ["bunny.stl", "outline.dxf"])
def test_an_outline_that_is_a_pipe_is_not_waited_for(tmp_path, name):
    from ecume.scenes.load import load_scene

    os.mkfifo(tmp_path / name)
    text = f"""model = "sph"\nduration = 1\nframe_every = 1\nspacing = 0.02
[tank]\nlow = [0, 0]\nhigh = [1, 1]\n[[fluid]]\noutline_from = "{name}"\n"""
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(ecume.errors.SceneError, match="is not a regular file"):
        load_scene(tmp_path / "scene.toml")
