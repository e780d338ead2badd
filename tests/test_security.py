"""What SECURITY.md says: scenes run nothing and read nothing of others, servers are local, clusters encrypt."""

import ast
import contextlib
import math
import os
import re
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import ecume
from ecume import _jit
from ecume._cache import open_to_others
from ecume.errors import BadInput
from ecume.show import serving
from ecume.sweep import executors, sweep
from ecume.sweep.executors import ExecutorOptions, require_safe
from ecume.sweep.spec import Cluster
from tests.sources import source_files

PACKAGE = Path(ecume.__file__).parent
ROOT = Path(__file__).parents[1]
CALLS = {"eval", "exec", "compile", "__import__", "execfile"}
MODULES = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "yaml", "code"}
SHELLS = {"system", "popen", "spawnl", "execv"}


def named(node):
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def forbidden(tree):
    """What would run or unpickle something that comes from outside."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            words = {keyword.arg: keyword.value for keyword in node.keywords}
            bare = isinstance(node.func, ast.Name) and node.func.id in CALLS
            of_os = isinstance(node.func, ast.Attribute) and getattr(node.func.value, "id", "") == "os"
            unpickles = any(
                key in words and not (isinstance(words[key], ast.Constant) and words[key].value is False)
                for key in ("allow_pickle", "shell")
            )
            careless = named(node) == "load" and getattr(getattr(node.func, "value", None), "id", "") == "np"
            if bare or (of_os and named(node) in SHELLS) or unpickles or (careless and "allow_pickle" not in words):
                yield ast.unparse(node)
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = {alias.name for alias in node.names} | {getattr(node, "module", "") or ""}
            yield from names & MODULES


COMPILED = "compile('\\n'.join(lines), file, 'exec')"
WRITTEN = "compile(text, __file__, 'exec')"
COMPILED_CODE = {"_parts.py": ["pickle"]}
"""Machine code, from files that no other user could have written: see SECURITY.md."""
PACKED = "compile('\\n    '.join(text), __file__, 'exec')"
MADE_OF_TABLES = {
    "_jit.py": [f"exec({WRITTEN}, found)", f"exec({COMPILED}, found)", WRITTEN, COMPILED],
    "_variants.py": [f"exec({PACKED}, names)", PACKED],
}
"""`_jit.each_selected` writes a call for each part of a tuple, of numbered names only. `_jit.selection` makes a
function with a branch for each row of a table of laws, as `dataclasses` make `__init__`. `_variants.packing` writes
the addresses of so many arrays."""


def test_text_that_is_made_of_tables_holds_numbers_and_a_name_of_ours_only():
    calls = [
        node
        for path in source_files()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) == "selection"
    ]
    assert calls
    assert all(isinstance(call.args[0], ast.Constant) for call in calls)  # not of a scene, nor of anything read
    with pytest.raises(ValueError, match="format code"):
        _jit.selection("f", {"0: import os": math.sqrt, 1: math.exp}, __name__, __file__)


def test_nothing_in_the_package_evaluates_or_unpickles():
    found = {path.name: list(forbidden(ast.parse(path.read_text(encoding="utf-8")))) for path in source_files()}
    assert {name: calls for name, calls in found.items() if calls} == MADE_OF_TABLES | COMPILED_CODE


@pytest.mark.parametrize(
    "text",
    [
        "eval('1')",
        "np.load(f)",
        "np.load(f, allow_pickle=True)",
        "import pickle",
        "os.system('ls')",
        "run(x, shell=True)",
    ],
)
def test_the_search_for_such_calls_finds_them(text):
    assert list(forbidden(ast.parse(text)))


@pytest.mark.parametrize(
    "text", ["9**9**9 m", "1 m**9**9**9", "__import__('os').system('id') m", "1e999 m", "1 " + "m" * 99]
)
def test_units_are_never_worked_out_as_expressions(text):
    code = f"from ecume.units import Unit\ntry:\n  Unit('m').number({text!r})\nexcept ValueError: print('refused')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=200, check=True)
    assert done.stdout == "refused\n"


def test_a_sweep_reads_no_scene_outside_of_its_folder(tmp_path):
    (tmp_path / "inner").mkdir()
    (tmp_path / "secret.toml").write_text("a = 1")
    (tmp_path / "inner" / "sweep.toml").write_text('scene = "../secret.toml"\n[[axes]]\nkey = "seed"\nvalues = [1]')
    with pytest.raises(BadInput, match="leads out of the scene's folder"):
        sweep(tmp_path / "inner" / "sweep.toml", tmp_path / "out", ExecutorOptions(workers=1))
    assert not (tmp_path / "out").exists()


def test_servers_listen_to_this_machine_alone():
    assert serving.HOST == "127.0.0.1"
    bound = [
        line.strip()
        for path in source_files()
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r"Server\(\(|0\.0\.0\.0|[^e]\.bind\(|LocalCluster\(", line)
    ]
    assert len(bound) == 2
    assert all("HOST" in line or 'host="127.0.0.1"' in line for line in bound)


@pytest.mark.parametrize("address", ["tls://big:8786", "tcp://127.0.0.1:8786", "localhost:8786", "tcp://[::1]:8786"])
def test_a_scheduler_is_encrypted_or_here(address):
    require_safe(address)


@pytest.mark.parametrize(
    "address", ["tcp://big:8786", "10.0.0.7:8786", "ws://big:80", "tcp://127.0.0.1.evil.org:1", "big"]
)
def test_a_scheduler_across_a_network_without_encryption_is_refused(address, tmp_path):
    path = tmp_path / "bowls.toml"
    path.write_text('template = "cereal-bowl"\n[[axes]]\nkey = "seed"\nvalues = [1]')
    with pytest.raises(BadInput, match="not encrypted"):
        sweep(path, tmp_path / "out", ExecutorOptions(scheduler=address))


def test_workers_on_a_cluster_are_encrypted(monkeypatch, tmp_path):
    import dask_jobqueue

    asked = {}

    @contextlib.contextmanager
    def cluster(**given):
        asked.update(given)
        yield type("Scaled", (), {"scale": lambda self, jobs: None})()

    monkeypatch.setattr(dask_jobqueue, "SLURMCluster", cluster)
    with executors.slurm_cluster(Cluster(), tmp_path):
        assert asked["security"].require_encryption is True
        assert asked["security"].tls_scheduler_cert
        assert asked["shared_temp_directory"] == str(tmp_path)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_the_cache_of_compiled_code_is_made_for_its_owner_alone(tmp_path):
    code = "from ecume._cache import root; print(root())"
    environment = {**os.environ, "ECUME_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert stat.S_IMODE(Path(done.stdout.strip()).stat().st_mode) == 0o700


PLANTED = """
from ecume._jit import compiled

@compiled
def doubled(number):
    return 2 * number

print(doubled(21), sum(doubled.stats.cache_hits.values()))
"""


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_compiled_code_in_a_folder_that_others_may_write_to_is_not_read(tmp_path):
    """Numba unpickles what lies there: whoever writes it is run."""
    script, place = tmp_path / "script.py", tmp_path / "cache"
    script.write_text(PLANTED)
    environment = {**os.environ, "ECUME_CACHE_DIR": str(place), "PYTHONPATH": str(PACKAGE.parent), "PYTHONWARNINGS": ""}

    def output():
        return subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=True)

    assert (output().stdout, output().stdout) == ("42 0\n", "42 1\n")
    files = {path: path.stat().st_mtime_ns for path in place.rglob("*")}
    for mode in (0o770, 0o1777):
        (place / "compiled").chmod(mode)
        done = output()
        assert done.stdout == "42 0\n"
        assert done.stderr.count("can be written by others") == 1
        assert "ECUME_CACHE_DIR" in done.stderr
    assert {path: path.stat().st_mtime_ns for path in place.rglob("*")} == files


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
@pytest.mark.parametrize(("owner", "user", "fault"), [(7, 7, ""), (0, 7, ""), (8, 7, "user 8"), (8, 0, "user 8")])
def test_compiled_code_is_its_users_own_or_the_administrators(monkeypatch, tmp_path, owner, user, fault):
    monkeypatch.setattr(os, "getuid", lambda: user)
    monkeypatch.setattr(Path, "stat", lambda self: os.stat_result((0o40700, 0, 0, 0, owner, 0, 0, 0, 0, 0)))
    assert fault in open_to_others(tmp_path)
    assert bool(open_to_others(tmp_path)) == bool(fault)


def test_every_pinned_package_has_its_digest():
    for lock in ROOT.glob("*.lock"):
        text = re.sub(r"\\\n\s*", " ", lock.read_text(encoding="utf-8"))
        pins = [line for line in text.splitlines() if line and not line.startswith(("#", " "))]
        assert len(pins) > 20
        assert all("==" in line and "--hash=sha256:" in line for line in pins)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_compiled_code_in_a_file_that_others_may_write_to_is_not_read(tmp_path):
    """Whatever the umask, folders and files are their owner's; a file that was opened to others is compiled again."""
    script, place = tmp_path / "script.py", tmp_path / "cache"
    script.write_text("import os; os.umask(0o002)\n" + PLANTED)
    environment = {**os.environ, "ECUME_CACHE_DIR": str(place), "PYTHONPATH": str(PACKAGE.parent), "PYTHONWARNINGS": ""}
    (place / "compiled").mkdir(parents=True)
    place.chmod(0o755)
    (place / "compiled").chmod(0o755)

    def output():
        return subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=True)

    assert (output().stdout, output().stdout) == ("42 0\n", "42 1\n")
    below = list((place / "compiled").rglob("*"))
    assert {path for path in below if open_to_others(path)} <= {place / "compiled" / "pruned"}
    for path in (place / "compiled").rglob("*.code"):
        path.chmod(0o664)
    assert (output().stdout, output().stdout) == ("42 0\n", "42 1\n")


def test_all_that_verbs_print_is_cleaned():
    """Nothing but `output` reaches the terminal by another way."""
    for path in (PACKAGE / "cli").glob("*.py"):
        text = path.read_text(encoding="utf-8")
        ways = re.findall(r"typer\.(?:echo|secho)\(|(?<![\w.])print\(|sys\.std(?:out|err)\.write\(", text)
        assert ways == (["typer.echo("] if path.name == "output.py" else []), path


def test_local_workers_are_encrypted(monkeypatch):
    """Other users of the machine can connect to their ports."""
    distributed = pytest.importorskip("distributed")
    asked = {}

    def made(**options):
        asked.update(options)
        raise BadInput("enough")

    monkeypatch.setattr(distributed, "LocalCluster", made)
    with pytest.raises(BadInput, match="enough"), executors._client(executors.ExecutorOptions(), None, 2):
        pass
    assert asked["protocol"] == "tls://"
    assert asked["security"].tls_scheduler_cert
