import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ecume import _cache

PACKAGE = Path(_cache.__file__).parent
COLLISION = """
from ecume import _jit
from ecume.laws import friction

_jit.admit(friction)

@_jit.compiled
def exchanged(speed):
    return friction.impulse(speed, 2.0, 2.0, 0.5)

print(exchanged(4.0), sum(exchanged.stats.cache_hits.values()))
"""


@pytest.mark.long
@pytest.mark.compiled
def test_an_edited_law_is_compiled_again_and_an_edit_elsewhere_compiles_nothing(tmp_path):
    copy, script = tmp_path / "src" / "ecume", tmp_path / "collision.py"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    script.write_text(COLLISION)
    places = {"ECUME_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(copy.parent)}

    def run():
        words = [sys.executable, str(script)]
        return subprocess.run(words, env={**os.environ, **places}, capture_output=True, text=True, check=True).stdout

    assert run().split() == ["6.0", "0"]
    for elsewhere in ("laws/states.py", "laws/friction.py", "models/floating/record.py", "show/movies.py"):
        with (copy / elsewhere).open("a") as file:
            file.write("\n\ndef beside(number):\n    return number\n")
    assert run().split() == ["6.0", "1"]
    # Of another length: Python tells bytecode from edited text by seconds and length.
    law = copy / "laws" / "friction.py"
    law.write_text(law.read_text().replace("(1.0 + restitution)", "(2.00 + restitution)"))
    assert run().split() == ["10.0", "0"]


KEY = "0123456789abcdef"


def test_files_unused_for_a_month_are_thrown_away_once_a_day_and_nothing_else(tmp_path):
    def old(name, folder=False):
        if folder:
            (tmp_path / name).mkdir()
            (tmp_path / name / "code.nbc").touch()
        else:
            (tmp_path / name).touch()
        month_ago = time.time() - 31 * _cache.DAY
        os.utime(tmp_path / name, (month_ago, month_ago))

    old(f"whole-step-{KEY}{KEY}.code")
    old(f"whole-step-{KEY}{KEY}.code7gh2_x")  # of a process that was ended while it wrote
    old(f"march-{KEY}", folder=True)  # of earlier versions
    old("holidays")
    (tmp_path / f"part-cells-{KEY}{KEY}.code").touch()
    _cache._prune(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"holidays", f"part-cells-{KEY}{KEY}.code", "pruned"}
    old(f"march-{KEY}")
    _cache._prune(tmp_path)
    assert (tmp_path / f"march-{KEY}").exists()


def test_a_file_in_use_stays_young(tmp_path, monkeypatch):
    monkeypatch.setattr(_cache, "root", lambda: tmp_path)
    _cache.write("step.code", b"code")
    os.utime(tmp_path / "step.code", (0.0, 0.0))
    assert _cache.read("step.code") == b"code"
    assert time.time() - (tmp_path / "step.code").stat().st_mtime < _cache.DAY
    assert _cache.read("another.code") is None
    assert [path.name for path in tmp_path.iterdir()] == ["step.code"]


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """An installed package of compiled code beside the user's files, both with the same name, and what makes it."""
    user, installed = tmp_path / "user", tmp_path / "installed"
    user.mkdir()
    (installed / "ecume_compiled").mkdir(parents=True)
    monkeypatch.setattr(_cache, "root", lambda: user)
    monkeypatch.setattr(_cache, "PACKAGE", installed / "ecume")
    monkeypatch.setattr(_cache.sysconfig, "get_path", lambda which: str(installed))
    _cache.write("step.code", b"of the user")
    whole = hashlib.sha256(b"shipped").digest() + b"shipped"

    def ship(data=whole, manifest=None):
        (installed / "ecume_compiled" / "step.code").write_bytes(data)
        listed = {"files": {"step.code": hashlib.sha256(whole).hexdigest()}} if manifest is None else manifest
        text = listed if isinstance(listed, str) else json.dumps(listed)
        (installed / "ecume_compiled" / "MANIFEST.json").write_text(text)
        _cache.shipped.cache_clear()

    yield ship, whole, installed
    _cache.shipped.cache_clear()


def test_a_package_of_compiled_code_is_read_first_and_never_written(packages):
    ship, _, installed = packages
    ship()
    before = {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in installed.rglob("*.*")}
    assert _cache.read("step.code") == b"shipped"
    _cache.write("step.code", b"new")
    _cache.write("more.code", b"new")
    assert _cache.read("step.code") == b"shipped"
    assert _cache.read("more.code") == b"new"
    assert {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in installed.rglob("*.*")} == before


@pytest.mark.parametrize("length", [0, 10, 32, 38])
def test_a_file_that_is_damaged_in_a_package_of_compiled_code_is_absent(packages, length):
    ship, whole, _ = packages
    ship(whole[:length])
    assert _cache.read("step.code") == b"of the user"


def test_a_file_that_a_package_of_compiled_code_does_not_list_is_absent(packages):
    ship, whole, _ = packages
    ship(hashlib.sha256(b"foreign").digest() + b"foreign")
    assert _cache.read("step.code") == b"of the user"
    ship(whole, {"files": {}})
    assert _cache.read("step.code") == b"of the user"


@pytest.mark.parametrize("manifest", ["", "{", "[]", "{}", '{"files": []}', '{"files": {"../step.code": "0"}}'])
def test_a_package_of_compiled_code_with_a_damaged_manifest_is_absent(packages, manifest):
    ship, _, _ = packages
    ship(manifest=manifest)
    assert _cache.read("step.code") == b"of the user"
    assert _cache.shipped() == {}


def test_a_listed_file_that_is_not_there_is_absent(packages):
    ship, _, installed = packages
    ship()
    (installed / "ecume_compiled" / "step.code").unlink()
    assert _cache.read("step.code") == b"of the user"


def test_a_damaged_file_of_the_user_is_told(packages):
    _cache.write("step.code", b"x" * 40)
    file = _cache.root() / "step.code"
    for length in (0, 10, 50):
        file.write_bytes(file.read_bytes()[:length])
        with pytest.raises(_cache.DamagedError):
            _cache.read("step.code")


def test_where_nothing_can_be_written_a_temporary_folder_stands_in_and_goes_with_the_process(tmp_path):
    (tmp_path / "file").touch()
    line = "from ecume import _cache; print(_cache.root()); (_cache.root() / 'code').touch()"
    places = {
        "ECUME_CACHE_DIR": str(tmp_path / "file" / "below"),
        "TMPDIR": str(tmp_path),
        "PYTHONPATH": str(PACKAGE.parent),
    }
    done = subprocess.run(
        [sys.executable, "-c", line], env={**os.environ, **places}, capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith(str(tmp_path / "ecume-"))
    assert {path.name for path in tmp_path.iterdir()} == {"file"}


def test_a_user_without_a_home_compiles_in_a_temporary_folder_and_hears_of_it(monkeypatch):
    pwd = pytest.importorskip("pwd")
    for name in ("ECUME_CACHE_DIR", "HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", {}.__getitem__)  # no user has any id
    with pytest.warns(UserWarning, match="no home folder. Set ECUME_CACHE_DIR"):
        place = _cache.root.__wrapped__()
    assert place.is_dir()
    shutil.rmtree(place)
