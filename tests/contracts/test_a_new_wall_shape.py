"""The recipe docs/extend/wall.md for a dish of a new shape, followed to the letter in a copy of the package."""

import re

import pytest
from tests.contracts.recipes import Copy

# Processes of their own: what they find does not depend on how this one runs, so once is enough.
pytestmark = pytest.mark.compiled

HEXAGON = """
model = "floating"
duration = 0.2
frame_every = 0.05
[[particles]]
count = 12
radius = "1 mm"
density = 600.0
contact_angle = "70 deg"
[dish]
shape = "hexagon"
radius = "2 cm"
law = "none"
"""
COMMANDS = """
import sys
from ecume.cli import main
for command in %r:
    sys.argv = ["ecume", *command]
    try:
        main()
    except SystemExit as end:
        assert not end.code, (command, end.code)
"""
STEPS = [
    ["run", "hexagon.toml", "--out", "run"],
    ["movie", "run", "--out", "film.gif"],
    ["plot", "run", "--what", "pair-distribution"],
    ["plot", "run", "--what", "bowl"],
    ["view", "run", "--save", "view.html"],
]


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with the new shape: one file is changed."""
    made, file = Copy(tmp_path_factory.mktemp("copy"), ("src", "tests", "docs")), "models/floating/dishes.py"
    made.follow(file, "hexagon")
    made.follow(file, "hexagon-row")
    (made.folder / "hexagon.toml").write_text(HEXAGON, encoding="utf-8")
    return made


@pytest.mark.long
def test_a_run_in_a_new_shape_can_be_filmed_plotted_and_viewed(copy):
    copy.printed(COMMANDS % STEPS, NUMBA_DISABLE_JIT="1")  # walls of any shape are compiled as those of a rectangle
    assert (copy.folder / "film.gif").stat().st_size > 1000
    assert "hexagon" in (copy.folder / "view.html").read_text(encoding="utf-8")


@pytest.mark.long
def test_the_usual_meniscus_is_refused_with_the_reason(copy):
    done = copy.python("-m", "ecume", "check", "hexagon.toml", "--set", 'dish.law="meniscus"')
    assert done.returncode != 0
    assert "120 degrees" in done.stdout + done.stderr


@pytest.mark.long
def test_a_new_shape_holds_what_all_others_hold(copy):
    chosen = "hexagon and not documentation"
    page = "tests/contracts/test_wall_shapes.py"
    done = copy.python(
        "-m", "pytest", "-v", "-p", "no:cacheprovider", "-k", chosen, "-m", "not compiled", page,
        NUMBA_DISABLE_JIT="1",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert re.search(r"[8-9] passed", done.stdout), done.stdout
