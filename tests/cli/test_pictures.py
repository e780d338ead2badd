"""The verbs movie, plot and export."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import ecume.trajectories.exports
from ecume.cli import app
from ecume.cli.pictures import ENDINGS, Format
from ecume.errors import BadInput

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


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[str]:
    """A run with nothing in it, and figures that only note their names; one of them cannot be drawn."""
    import ecume.show.figures

    noted: list[str] = []

    def plot(directory: Path, what: str, out: Path | None) -> Path:
        if what == "force-law":
            raise BadInput("there is no force to draw")
        noted.append(what)
        return out or Path(what)

    monkeypatch.chdir(tmp_path)
    (tmp_path / "bowl").mkdir()
    (tmp_path / "bowl" / "manifest.json").write_text('{"ecume": "0"}')
    monkeypatch.setattr(ecume.show.figures, "plot", plot)
    return noted


def test_plot_draws_every_figure_that_can_be_drawn(drawn: list[str]) -> None:
    from ecume.show.figures import FIGURES

    done = cli.invoke(app, ["plot", "bowl"])
    assert done.exit_code == 0
    assert drawn == [name for name in FIGURES if name != "force-law"]
    assert done.stderr == "ecume: force-law left out: there is no force to draw\n"


def test_plot_draws_what_it_is_told_or_says_why_not(drawn: list[str]) -> None:
    assert cli.invoke(app, ["plot", "bowl", "--what", "paths", "-o", "a.pdf"]).stdout == "wrote a.pdf\n"
    assert cli.invoke(app, ["plot", "bowl", "--what", "force-law"]).exit_code == 2
    two = cli.invoke(app, ["plot", "bowl", "--what", "paths", "--what", "energies", "-o", "a.pdf"])
    assert "2 figures do not fit into a.pdf" in two.stderr
    assert "say with --what" in cli.invoke(app, ["plot", "bowl", "-o", "a.pdf"]).stderr
    assert drawn == ["paths"]
