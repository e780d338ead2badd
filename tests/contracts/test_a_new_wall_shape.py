"""CONTRIBUTING's recipe for a dish of a new shape, followed to the letter in a copy of the package."""

import re

import pytest
from tests.contracts.test_a_new_pair_law import block, copy_of_the_package, python

HEXAGON = '''
from pathlib import Path
Path("hexagon.toml").write_text("""
model = "floating"
duration = 0.2
frame_every = 0.05
[[floats]]
count = 12
radius = "1 mm"
density = 600.0
contact_angle = "70 deg"
[dish]
shape = "hexagon"
radius = "2 cm"
law = "none"
""")
'''
COMMANDS = [
    ["run", "hexagon.toml", "--out", "run"],
    ["movie", "run", "--out", "film.gif"],
    ["plot", "run", "--what", "pair-distribution"],
    ["plot", "run", "--what", "bowl"],
    ["view", "run", "--save", "view.html"],
]


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with the new shape: one file is changed."""
    folder = copy_of_the_package(tmp_path_factory.mktemp("copy"))
    path = folder / "src" / "ecume" / "models" / "floating" / "walls" / "shapes.py"
    before, table, rows = path.read_text(encoding="utf-8").partition("SHAPES = {\n")
    assert table
    path.write_text(before + block("hexagon") + "\n\n" + table + block("hexagon-row") + rows, encoding="utf-8")
    return folder


def test_a_run_in_a_new_shape_can_be_filmed_plotted_and_viewed(copy):
    made = python(copy, "-c", HEXAGON)
    assert made.returncode == 0, made.stderr
    for command in COMMANDS:
        done = python(copy, "-m", "ecume", *command)
        assert done.returncode == 0, (command, done.stdout, done.stderr)
    assert (copy / "film.gif").stat().st_size > 1000
    assert "hexagon" in (copy / "view.html").read_text(encoding="utf-8")


def test_the_usual_meniscus_is_refused_with_the_reason(copy):
    done = python(copy, "-m", "ecume", "check", "hexagon.toml", "--set", 'dish.law="meniscus"')
    assert done.returncode != 0
    assert "120 degrees" in done.stdout + done.stderr


def test_a_new_shape_holds_what_all_others_hold(copy):
    chosen = "hexagon and not documentation"
    page = "tests/contracts/test_wall_shapes.py"
    done = python(
        copy, "-m", "pytest", "-v", "-p", "no:cacheprovider", "-k", chosen, "-m", "not compiled", page,
        NUMBA_DISABLE_JIT="1",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert re.search(r"[8-9] passed", done.stdout), done.stdout
