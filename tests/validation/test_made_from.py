"""Records are stale exactly when something has changed that their numbers are made from."""

import functools
import random
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ecume import made_from
from ecume.made_from import MODELS, NO_NUMBERS, NOT_TIMED, age_of, digest_of, models_of, modules_of
from ecume_validation import CASES

ROOT = Path(__file__).parents[2]
SETTLING = CASES["settling"]
"""The case that is looked at: it reaches the fewest modules of those with a model."""


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """A checkout to edit."""
    home = tmp_path_factory.mktemp("checkout")
    shutil.copytree(ROOT / "src", home / "src", ignore=shutil.ignore_patterns("__pycache__", "static"))
    shutil.copytree(ROOT / "benchmarks", home / "benchmarks", ignore=shutil.ignore_patterns("__pycache__"))
    return home / "src" / "ecume"


@pytest.fixture
def package(copied):
    """The same, as it was, whatever the test before edited."""
    before = {path: path.read_bytes() for path in copied.parents[1].rglob("*") if path.is_file()}
    forget()
    yield copied
    for path, content in before.items():
        if path.read_bytes() != content:
            path.write_bytes(content)
    forget()


def forget():
    """Have all files read again. What follows from the text of a file alone stays."""
    for name, one in vars(made_from).items():
        if isinstance(one, functools._lru_cache_wrapper) and name != "_source_of":
            one.cache_clear()


def of_settling(package):
    forget()
    return digest_of(SETTLING.module, SETTLING.name, package)


def edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{path} was rewritten: choose another line"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_no_case_starts_from_a_file_of_another_program():
    """`scenes.starts` does not count for the digests of cases."""
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "src" / "ecume_validation").rglob("*.py")]
    texts += [path.read_text(encoding="utf-8") for path in (ROOT / "src" / "ecume_validation").rglob("*.toml")]
    assert len(texts) > 60
    assert not [text for text in texts if "start_from" in text or "particles_from" in text]


def files_of(names, package):
    return [made_from._path(name, package) for name in sorted(names)]


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("laws/drag.py", "return 6.0 * math.pi * viscosity", "return 6.1 * math.pi * viscosity"),
        ("simulation.py", "ROOMIER = 1.6", "ROOMIER = 1.7"),
        ("../ecume_validation/tracers.py", "GRAINS = 4000", "GRAINS = 4001"),
        ("../ecume_validation/data/settling/scene.toml", "100 um", "101 um"),
    ],
)
def test_an_edit_that_may_change_a_number_makes_a_record_stale(package, file, old, new):
    before = of_settling(package)
    edit(package / file, old, new)
    assert of_settling(package) != before


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("laws/drag.py", '"""', '"""Said in other words. '),
        ("../ecume_validation/data/settling/scene.toml", "density = 2500.0", "# quartz\ndensity  =  2500.0"),
        ("../ecume_validation/data/settling/README.md", "# ", "# On "),
        ("../ecume_validation/data/tank/scene.toml", "spacing", "title = 'other'\nspacing"),
        ("errors.py", "\nfrom", "# comment\n\n\nfrom"),
    ],
)
def test_an_edit_of_words_makes_no_record_stale(package, file, old, new):
    before = of_settling(package)
    edit(package / file, old, new)
    assert of_settling(package) == before


def test_a_message_of_an_error_is_words(package):
    before = of_settling(package)
    with (package / "laws" / "drag.py").open("a", encoding="utf-8") as file:
        file.write('\n\ndef refuse():\n    raise ValueError("no")\n')
    with_it = of_settling(package)
    assert with_it != before
    edit(package / "laws" / "drag.py", 'ValueError("no")', 'ValueError("never")')
    assert of_settling(package) == with_it


@pytest.mark.long
def test_all_files_that_are_reached_count_and_no_others(package):
    before, reached = of_settling(package), files_of(modules_of(SETTLING.module, SETTLING.name, package), package)
    for path in package.rglob("*.py"):
        with path.open("a", encoding="utf-8") as file:
            file.write("\n# a comment\n" if path in reached else "\nADDED = 1\n")
    assert of_settling(package) == before
    for path in random.Random(1).sample(reached, 8):
        edit(path, "# a comment", "ADDED = 1")
        assert of_settling(package) != before, path
        edit(path, "ADDED = 1", "# a comment")
    assert of_settling(package) == before


LOADED = """
import sys
from ecume.simulation import simulate
from ecume.scenes.load import load_scene
next(simulate(load_scene(sys.argv[1])))
print(*(name for name in sys.modules if name.startswith("ecume")))
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "scene"),
    [
        ("raft", "../ecume_validation/data/raft/scene.toml"),
        ("tank", "../ecume_validation/data/tank/scene.toml"),
        ("settling", "../ecume_validation/data/settling/scene.toml"),
        ("rheology", "templates/sheared-packing.toml"),
    ],
)
def test_what_a_scene_loads_is_reached(name, scene):
    done = subprocess.run(
        [sys.executable, "-c", LOADED, str(made_from.PACKAGE / scene)], capture_output=True, text=True, check=True
    )
    loaded = {each for each in done.stdout.split() if not (NOT_TIMED.match(each) or NO_NUMBERS.match(each))}
    models = models_of_case(name)
    others = {each for each in loaded if (of := made_from.OF_A_MODEL.match(each)) and of[1] not in models}
    assert not [each for each in others if ".models." in each]  # only scenes: their table has all models
    assert loaded - with_imports(others) <= modules_of(CASES[name].module, name)


def with_imports(modules):
    """These modules, and those that they import themselves."""
    return modules.union(*(made_from._imported(name, made_from.PACKAGE) for name in modules))


def models_of_case(name):
    return models_of(CASES[name].module, name)


def test_each_case_has_its_models():
    assert {name for name in CASES if not models_of_case(name)} == {"kernels"}
    assert models_of_case("tank-schemes") == {"sph"}
    assert models_of_case("suspensions") == {"soft"}
    assert models_of_case("reflection") == {"tracers"}
    assert {model for name in CASES for model in models_of_case(name)} == MODELS


def test_a_benchmark_is_made_from_its_script_its_neighbors_and_the_models_that_it_times():
    reached = modules_of("sph_peers")
    assert {"sph_peers", "timed_runs", "in_ecume", "in_lammps", "cube", "ecume.models.sph.record"} <= reached
    assert "soft" in models_of("sweeping")
    assert not any(name.startswith("ecume.models") for name in modules_of("reflection"))


def test_a_record_is_stale_when_its_digest_is_another_or_missing():
    entry = {"date": "2000-01-01", "made_from": digest_of(SETTLING.module, SETTLING.name)}
    given = SETTLING.module, SETTLING.name
    assert age_of(entry, *given) == "2000-01-01"
    assert age_of({**entry, "made_from": "0"}, *given) == age_of({"date": "2000-01-01"}, *given) == "stale: 2000-01-01"
    assert age_of(None, *given) == "not recorded"
