"""Where floats go by multipoles, the surface that is drawn is the solver's."""

import numpy as np
import pytest

from ecume.laws import multipole
from ecume.models import MODELS
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.liquids import liquid_of
from ecume.scenes.load import load_scene
from ecume.show.floating.surface import SOLVED_CELLS, sheet, surface, typical_meniscus
from ecume.show.picture import View

ORDER = 6
DISCS = """
model = "floating"
duration = "1 s"
frame_every = "1 s"
[[particles]]
radius = "1 mm"
density = 300.0
disc = {{ thickness = "0.4 mm"{rim} }}
positions = [["{left} mm", "0 mm"], ["1.5 mm", "0.4 mm"]]
[interaction]
method = "multipole"
order = 6
charge = "linear"
{walls}
"""
UNDULATED = ', undulation = "20 um", mode = 2, angle = "30 deg"'
VIEW = View(-4e-3, 4e-3, -3e-3, 3e-3)
WALLS = {
    "no walls": ("", None),
    "dish": ('[dish]\nradius = "6 mm"\ncontact_angle = "60 deg"', multipole.Dish(6e-3, np.pi / 3)),
    "basin": ('[dish]\nsize = ["10 mm", "9 mm"]\ncontact_angle = "60 deg"', multipole.Basin(10e-3, 9e-3, np.pi / 3)),
}


def framed(rim="", walls="", left=-1.3):
    """The scene, and its first frame."""
    scene, model = load_scene(DISCS.format(rim=rim, walls=walls, left=left)), MODELS["floating"]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    return scene, model.observe(parameters, state, model.workspace(parameters, state, 1.0))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("rim", ["", UNDULATED], ids=["flat rims", "saddles"])
@pytest.mark.parametrize(
    "walls", ["no walls", *(pytest.param(name, marks=pytest.mark.compiled) for name in ("dish", "basin"))]
)
def test_the_drawn_surface_is_that_of_the_solver(walls, rim):
    scene, frame = framed(rim, WALLS[walls][0])
    grid = sheet(scene, VIEW, cells=30, closest=1e-3)
    body = float_kinds(scene)[0].body
    bodies = [multipole.Undulated(body, ((2, 20e-6, np.pi / 6),)) if rim else body] * 2
    found = multipole.solve(frame.arrays["position"], bodies, liquid_of(scene), ORDER, walls=WALLS[walls][1])
    x, y = np.meshgrid(grid.x, grid.y)
    places = frame.arrays["position"][:, None, None]
    wet = (np.hypot(x - places[..., 0], y - places[..., 1]) > 1e-3).all(axis=0)
    wanted = multipole.height(found, x, y)[wet]
    assert surface(frame, grid)[wet] == pytest.approx(wanted, abs=2e-3 * np.ptp(wanted))


@pytest.mark.compiled
def test_rims_without_weight_bend_what_is_drawn():
    scene, frame = framed(UNDULATED.replace("undulation", 'rim = "top", undulation'))
    grid = sheet(scene, VIEW, cells=300, closest=1e-3)
    assert max(grid.still.shape) <= SOLVED_CELLS
    assert typical_meniscus(frame, grid) > 5e-6
    assert np.ptp(surface(frame, grid)) > 20e-6


@pytest.mark.compiled
def test_beyond_a_round_wall_the_surface_is_as_at_it():
    scene, frame = framed(walls=WALLS["dish"][0], left=-4.95)
    grid = sheet(scene, View(-6e-3, 6e-3, -6e-3, 6e-3), cells=40, closest=1e-3)
    x, y = np.meshgrid(grid.x, grid.y)
    height, outside = surface(frame, grid), np.hypot(x, y) > 6e-3
    assert outside.any()
    assert np.abs(height[outside]).max() <= 1.02 * np.abs(height).max(where=~outside, initial=0.0)
