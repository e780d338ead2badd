"""The drawn force between two floats, by each theory."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import BadInput
from ecume.laws import flotation
from ecume.models.liquids import liquid_of
from ecume.scenes.load import load_scene
from ecume.show.floating.law_figures import drawn_forces, force_law, pair_forces

TWO = """
model = "floating"
duration = 1
frame_every = 1
[[particles]]
name = "heavy"
radius = "1 mm"
density = 1300
contact_angle = "90 deg"
[[particles]]
name = "light"
radius = "1 mm"
density = 300
contact_angle = "90 deg"
"""


@pytest.fixture(scope="module")
def scene():
    """A heavy sphere and a light one."""
    return load_scene(TWO)


@pytest.fixture(scope="module")
def forces(scene):
    """Of all pairs of the two."""
    return pair_forces(scene)


@pytest.mark.long
@pytest.mark.compiled
def test_all_pairs_are_there_and_like_ones_attract(forces):
    assert [pair.label for pair in forces] == ["heavy – heavy", "heavy – light", "light – light"]
    for pair, sign in zip(forces, (-1.0, 1.0, -1.0), strict=True):
        assert set(pair.by_method) == {"superposition", "pair-corrected", "multipole"}
        assert all(np.all(sign * force > 0.0) for force in pair.by_method.values())


@pytest.mark.long
@pytest.mark.compiled
def test_superposition_is_the_pair_law_and_far_away_all_agree(scene, forces):
    spheres = [flotation.Sphere(1e-3, density, 0.5 * np.pi) for density in (1300.0, 300.0)]
    for pair, (a, b) in zip(forces, ((0, 0), (0, 1), (1, 1)), strict=True):
        wanted = [
            flotation.pair_force(spheres[a], spheres[b], float(each), liquid_of(scene), "nonlinear")
            for each in pair.distance
        ]
        assert pair.by_method["superposition"] == pytest.approx(wanted, rel=1e-9)
        # Near is a gap of 6 % of a diameter: where spheres touch, series of any order creep.
        near, far = (
            {method: force[place] / wanted[place] for method, force in pair.by_method.items()} for place in (4, -1)
        )
        assert far["multipole"] == pytest.approx(1.0, abs=2e-3)
        assert far["pair-corrected"] == pytest.approx(1.0, abs=2e-3)
        assert abs(near["multipole"] - 1.0) > 0.02
        assert near["pair-corrected"] == pytest.approx(near["multipole"], abs=5e-3)


@pytest.mark.long
@pytest.mark.compiled
def test_the_figure_has_a_curve_for_each_pair_and_method(scene):
    (axes,) = drawn_forces(scene).axes
    drawn = [line for line in axes.lines if len(line.get_xdata())]
    assert len(drawn) == 9
    assert axes.get_yscale() == "log"
    assert axes.get_ylabel().endswith("N)")


@pytest.mark.long
@pytest.mark.compiled
def test_the_command_draws_the_forces_of_a_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("two.toml").write_text(TWO)
    done = CliRunner().invoke(app, ["plot", "--force-law", "two.toml"])
    assert (done.exit_code, done.output) == (0, "wrote two-forces.png\n")
    assert Path("two-forces.png").read_bytes().startswith(b"\x89PNG")
    refused = CliRunner().invoke(app, ["plot", "--force-law", "two.toml", "--what", "paths"])
    assert (refused.exit_code, "--force-law needs no run" in refused.stderr) == (2, True)


def test_scenes_without_menisci_have_no_forces_to_draw(tmp_path):
    (tmp_path / "none.toml").write_text(TWO + '[interaction]\nlaw = "none"\n')
    with pytest.raises(BadInput, match=r"interaction\.law = 'capillary'"):
        force_law(tmp_path / "none.toml", tmp_path / "none.png")
