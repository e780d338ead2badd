"""Every figure of every model takes every option of `ecume plot`: a format, a width, no title, its numbers, two runs.

The runs are recorded ones, and others of a few frames for figures that those have nothing of.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.show.test_frame_reads import runs  # noqa: F401  # a fixture
from tests.show.test_tank import FRAMES, measured
from tests.show.test_tank import SCENE as OPEN
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import BadInput
from ecume.scenes.schema import from_plain, to_plain
from ecume.show.figures import FIGURES
from ecume.show.publishing import Finish, curves_of, finished, points_of, together, written_data
from ecume.show.style import save
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory

GOLDEN = Path(__file__).parents[1] / "golden" / "0.1.0"
NAMES = [(model, name) for model in FIGURES for name in FIGURES[model]]
COLUMN = Finish(width=0.086, title=False)
POINT = 0.0254 / 72.0
UNTRIED = {(model, "samples") for model in FIGURES}
"""Figures of which no run here has anything; samples are files of a run."""
PROTOCOL = [
    {"time": 0.0, "shear_rate": 1.0}, {"time": 4.0, "shear_rate": 0.0}, {"time": 8.0, "shear_stress": 0.2},
    {"time": 12.0, "shear_stress": 0.0},
    {"time": 16.0, "shear_rate": 0.0, "oscillation": {"frequency": 0.5, "amplitude": 0.05}},
]  # fmt: skip
cli = CliRunner()


def driven(few: tuple[Any, Sequence[Frame]]) -> tuple[Any, Sequence[Frame]]:
    """A packing that starts up, rests, creeps, recovers and oscillates, by numbers that stand for stresses."""
    scene, (first, *_) = few
    whole = from_plain({**to_plain(scene), "duration": 24.0, "protocol": PROTOCOL})
    now = np.linspace(0.0, 24.0, 241)
    rise, wave = np.minimum(now, 4.0), np.where(now > 16.0, 0.05 * np.sin(np.pi * now), 0.0)
    crept = rise + 0.5 * np.clip(now - 8.0, 0.0, 4.0) - 0.6 * (1.0 - 2.0 ** -np.maximum(now - 12.0, 0.0)) + wave
    stress = (1.0 + rise * np.exp(-rise)) * 2.0 ** -np.maximum(now - 4.0, 0.0) + 3.0 * wave
    rows = zip(now.tolist(), crept.tolist(), stress.tolist(), strict=True)
    return whole, [
        first._replace(time=time, numbers={**first.numbers, "strain": strain, "shear_stress": load})
        for time, strain, load in rows
    ]


def drawn(few: Mapping[str, Any], touching: tuple[Any, Sequence[Frame]], model: str, name: str) -> Figure | None:
    """The figure of a recorded run, or of a few frames; None if neither has anything of the kind."""
    further = {
        "floating": lambda: [touching],
        "soft": lambda: [driven(few["soft"])],
        "tracers": lambda: [(OPEN, [measured(time) for time in (0.0, 0.5, 1.0)]), (OPEN, FRAMES)],
    }
    with open_trajectory(GOLDEN / model) as golden:
        sources: list[tuple[Any, Sequence[Frame]]] = [(golden.scene, golden), few[model]]
        sources += further[model]() if model in further else []
        for scene, frames in sources:
            try:
                return FIGURES[model][name](frames, scene)
            except BadInput:
                continue
    return None


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("model", "name"), NAMES)
def test_a_figure_takes_each_option(
    runs: Any,  # noqa: F811
    scene: Any,
    frames: Any,
    model: str,
    name: str,
    tmp_path: Path,
) -> None:
    closer = [one._replace(arrays={**one.arrays, "position": 0.94 * one.arrays["position"]}) for one in frames]
    figures = [drawn(runs, (scene, closer), model, name) for _ in range(2)]
    one, other = (figure or Figure() for figure in figures)
    if figures[0] is None:
        assert (model, name) in UNTRIED
        return
    require_data_and_two_runs(one, other, tmp_path)
    require_narrow(other, tmp_path)


def require_narrow(narrow: Figure, tmp_path: Path) -> None:
    """A figure takes the width of a column, and no title."""
    titles = [axes.get_title(place) for axes in narrow.axes for place in ("left", "center", "right")]
    assert [*filter(None, titles), narrow.get_suptitle()]
    svg = save(finished(narrow, COLUMN), tmp_path / "narrow.svg").read_text(encoding="utf-8")
    width = re.search(r'width="([0-9.]+)pt"', svg)
    assert width is not None
    assert float(width[1]) * POINT == pytest.approx(0.086, abs=1e-4)
    assert not any(axes.get_title(place) for axes in narrow.axes for place in ("left", "center", "right"))
    if len(narrow.axes) == 1:
        assert narrow.axes[0].get_position().width > 0.6


def require_data_and_two_runs(one: Figure, other: Figure, tmp_path: Path) -> None:
    """The numbers of curves are written, and those of two runs drawn together; pictures refuse both."""
    curves = [curve for axes in one.axes for curve in curves_of(axes)]
    if not curves:
        with pytest.raises(BadInput, match="picture without curves"):
            written_data(one, tmp_path / "none.csv")
        with pytest.raises(BadInput, match="is a picture"):
            together([("one", one), ("other", other)])
        return
    rows = list(csv.DictReader(written_data(one, tmp_path / "data.csv").read_text().splitlines()))
    assert len(rows) == sum(len(points_of(curve.line)) for curve in curves)
    both = together([("one", one), ("other", other)])
    assert sum(len(curves_of(axes)) for axes in both.axes) == 2 * len(curves)
    assert save(both, tmp_path / "both.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.long
@pytest.mark.parametrize("model", FIGURES)
@pytest.mark.parametrize(("form", "start"), [("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")])
def test_figures_of_a_run_go_to_a_folder_in_a_format(model: str, form: str, start: bytes, tmp_path: Path) -> None:
    chosen = {"floating": "energies", "sph": "center", "soft": "elastic-energy", "tracers": "displacement"}[model]
    words = ["plot", str(GOLDEN / model), "-o", str(tmp_path / "figures"), "--format", form, "--width", "120 mm"]
    whole = (model, form) == ("tracers", "svg")  # all figures of other models are written above
    done = cli.invoke(app, words if whole else [*words, "--what", chosen])
    assert done.exit_code == 0, done.stderr
    made = list((tmp_path / "figures").iterdir())
    assert (tmp_path / "figures" / f"{chosen}.{form}") in made
    assert len(made) == done.stdout.count("wrote ") >= (5 if whole else 1)
    assert all(path.suffix == f".{form}" and path.read_bytes().startswith(start) for path in made)
