import ast
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
    for elsewhere in ("laws/states.py", "models/floating/record.py", "show/movies.py"):
        with (copy / elsewhere).open("a") as file:
            file.write("\n# one line more\n")
    assert run().split() == ["6.0", "1"]
    law = copy / "laws" / "friction.py"
    law.write_text(law.read_text().replace("(1.0 + restitution)", "(2.0 + restitution)"))
    assert run().split() == ["10.0", "0"]


def test_a_time_step_depends_on_its_laws_and_on_nothing_that_draws_or_reads():
    step = PACKAGE / "models/floating/time_integration/integration.py"
    names = {path.relative_to(PACKAGE).as_posix() for path in _cache.sources(step)}
    assert {
        "_jit.py",
        "engine/contact/contacts.py",
        "laws/capillarity.py",
        "laws/special.py",
    } <= names
    assert {name.split("/")[0] for name in names}.isdisjoint({"show", "run", "cli", "scenes", "analysis"})
    assert "laws/states.py" not in names


def test_no_loop_of_tanks_depends_on_how_a_scene_is_read():
    loops = [path for path in (PACKAGE / "models/sph").rglob("*.py") if "\n@s" in path.read_text(encoding="utf-8")]
    assert {"sums.py", "walls.py", "passive_particles.py"} <= {path.name for path in loops}
    for path in loops:
        names = {source.relative_to(PACKAGE).as_posix() for source in _cache.sources(path)}
        assert {name.split("/")[0] for name in names}.isdisjoint({"show", "run", "cli", "scenes", "analysis"}), path


@pytest.mark.parametrize(
    ("line", "reaches"),
    [
        ("from ecume.laws import friction", {"laws/friction.py"}),
        ("def late():\n    import ecume.laws.friction as c", {"laws/friction.py"}),
        ("from ecume.laws.flotation import Liquid", {"laws/flotation/__init__.py", "laws/flotation/balance.py"}),
        ("if TYPE_CHECKING:\n    from ecume.laws import friction\n\nX = 1", set()),
        ("import ecume.laws.friction", {"laws/friction.py", "show/movies.py"}),
        ("from ecume import simulate", {"laws/friction.py", "show/movies.py"}),
    ],
)
def test_every_form_of_import_counts(tmp_path, line, reaches):
    (tmp_path / "mine.py").write_text(line + "\n")
    sources = _cache.sources(tmp_path / "mine.py")
    names = {path.relative_to(PACKAGE).as_posix() for path in sources if path.is_relative_to(PACKAGE)}
    assert reaches <= names
    assert ("show/movies.py" in names) == ("show/movies.py" in reaches)


def imports(statements):
    return [ast.dump(node) for node in statements if isinstance(node, ast.Import | ast.ImportFrom)]


def for_types(node):
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING" and not node.orelse


@pytest.mark.long
def test_no_import_of_the_package_is_overlooked():
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text)
        tree.body = [node for node in tree.body if not for_types(node)]
        assert set(imports(ast.walk(tree))) <= set(imports(_cache._statements(text))), path


@pytest.mark.parametrize(
    "text",
    [
        "if True: import math",
        "x = 1; import math",
        "from math import \\\n    pi",
        '"""\nfrom a to b.\n"""\nimport math',
    ],
)
def test_imports_that_hide_are_found(text):
    assert imports(_cache._statements(text)) == imports(ast.walk(ast.parse(text))) != []


def test_a_relative_import_counts_in_the_package():
    assert _cache._above(PACKAGE / "laws" / "flotation" / "balance.py", 1) == ("ecume", "laws", "flotation")
    assert _cache._above(PACKAGE / "laws" / "flotation" / "balance.py", 2) == ("ecume", "laws")


def test_folders_unused_for_a_month_are_thrown_away_once_a_day_and_nothing_else(tmp_path):
    def old(name):
        (tmp_path / name).mkdir()
        (tmp_path / name / "code.nbc").touch()
        month_ago = time.time() - 31 * _cache.DAY
        os.utime(tmp_path / name, (month_ago, month_ago))

    old("march-0123456789abcdef")
    old("holidays")
    (tmp_path / "cells-0123456789abcdef").mkdir()
    _cache._prune(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"holidays", "cells-0123456789abcdef", "pruned"}
    old("march-fedcba9876543210")
    _cache._prune(tmp_path)
    assert (tmp_path / "march-fedcba9876543210").exists()


def test_a_folder_in_use_stays_young(tmp_path, monkeypatch):
    monkeypatch.setattr(_cache, "root", lambda: tmp_path)
    used = _cache.folder(PACKAGE / "units.py", "a compiler")
    used.mkdir()
    os.utime(used, (0.0, 0.0))
    assert _cache.folder(PACKAGE / "units.py", "a compiler") == used
    assert time.time() - used.stat().st_mtime < _cache.DAY
    assert _cache.folder(PACKAGE / "units.py", "another compiler") != used


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
