"""The verbs movie, plot and export."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import ecume.trajectories.exports
from ecume.cli import app
from ecume.cli.pictures import ENDINGS, Format

cli = CliRunner()


def test_export_offers_what_trajectories_can_be_written_as() -> None:
    assert {kind.value for kind in Format} == set(ecume.trajectories.exports.EXPORTS)
    assert set(ENDINGS) == set(Format)


def test_export_writes_into_the_directory_or_where_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        ecume.trajectories.exports, "export", lambda directory, kind, out: f"{directory} {kind} {out.as_posix()}"
    )
    assert cli.invoke(app, ["export", "bowl", "--to", "xyz"]).stdout == "wrote bowl xyz bowl/frames.xyz\n"
    assert cli.invoke(app, ["export", "bowl", "--to", "csv", "-o", "a.csv"]).stdout == "wrote bowl csv a.csv\n"
    assert cli.invoke(app, ["export", "bowl", "--to", "doc"]).exit_code == 2


def test_movie_says_what_it_wrote(monkeypatch: pytest.MonkeyPatch) -> None:
    import ecume.show.movies

    monkeypatch.setattr(ecume.show.movies, "movie", lambda directory, out: out or directory / "movie.mp4")
    assert cli.invoke(app, ["movie", "bowl", "-o", "bowl.gif"]).stdout == "wrote bowl.gif\n"
    assert cli.invoke(app, ["movie", "bowl"]).stdout == f"wrote {Path('bowl/movie.mp4')}\n"


def test_plot_wants_a_run_or_the_integrators() -> None:
    for words in ([], ["bowl", "--integrators"]):
        done = cli.invoke(app, ["plot", "--what", "energy", *words])
        assert done.exit_code == 2
        assert "wanted either the directory of a run or --integrators" in done.stderr
