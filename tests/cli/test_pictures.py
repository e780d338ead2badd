"""The verbs movie, plot and export."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

import ecume.trajectories.exports
from ecume.cli import app
from ecume.cli.exports import ENDINGS, Format
from ecume.cli.progress import counted
from ecume.errors import BadInput
from ecume.show.curves import ONE_FRAME
from ecume.show.floating.figures import FLOATING_FIGURES
from ecume.show.publishing import Finish
from ecume.show.style import figure

cli = CliRunner()


def test_export_offers_what_trajectories_can_be_written_as() -> None:
    elsewhere = {"pvd", "heights", "heights-vtk", "ro-crate", "lammps"}
    assert {kind.value for kind in Format} == {*ecume.trajectories.exports.EXPORTS, *elsewhere}
    assert set(ENDINGS) == {*Format} - {Format.RO_CRATE, Format.LAMMPS}


@pytest.fixture(autouse=True)
def _a_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """An empty directory that looks like that of a run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bowl").mkdir()
    (tmp_path / "bowl" / "manifest.json").write_text('{"ecume": "0"}')


def test_export_writes_among_the_results_or_to_the_given_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        ecume.trajectories.exports, "export", lambda directory, kind, out: f"{directory} {kind} {out.as_posix()}"
    )
    assert cli.invoke(app, ["export", "bowl", "--to", "xyz"]).stdout == "wrote bowl xyz bowl/results/frames.xyz\n"
    assert cli.invoke(app, ["export", "bowl", "--to", "csv", "-o", "a.csv"]).stdout == "wrote bowl csv a.csv\n"
    assert cli.invoke(app, ["export", "bowl", "--to", "csv", "-q"]).output == ""
    assert cli.invoke(app, ["export", "bowl", "--to", "doc"]).exit_code == 2


def test_export_writes_text_to_the_standard_output(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def write(directory: Path, kind: str, out: Path) -> Path:
        out.write_text(f"{directory} {kind}")
        return out

    monkeypatch.setattr(ecume.trajectories.exports, "export", write)
    assert cli.invoke(app, ["export", "bowl", "--to", "numbers", "-o", "-"]).stdout == "bowl numbers"
    assert not (tmp_path / "-").exists()
    refused = cli.invoke(app, ["export", "bowl", "--to", "npz", "-o", "-"])
    assert refused.exit_code == 2
    assert "binary" in refused.stderr


def test_without_the_package_of_decks_a_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ecume_lammps", "ecume_lammps.decks", "ecume_lammps.engine"):
        monkeypatch.setitem(sys.modules, name, None)
    cli.invoke(app, ["new", "two-spheres"])
    for words in (["export", "two-spheres.toml", "--to", "lammps"], ["run", "two-spheres.toml", "--engine", "lammps"]):
        done = cli.invoke(app, words)
        assert done.exit_code == 2
        assert "pip install ./packaging/lammps" in done.stderr


def test_export_writes_decks_of_scenes(tmp_path: Path) -> None:
    cli.invoke(app, ["new", "two-spheres"])
    stokes = ["--set", "hydrodynamics.drag=stokes"]
    words = ["export", "two-spheres.toml", "--to", "lammps", *stokes]
    assert cli.invoke(app, words).stdout == "wrote two-spheres-lammps\n"
    words = [*words, "-o", "deck", "--set", "title=Mine"]
    assert cli.invoke(app, words).exit_code == 0
    assert (tmp_path / "deck" / "in.lammps").read_text().startswith("# Mine, written by ecume")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["bowl", "--to", "lammps"], "got the folder bowl; expected a scene file"),
        (["two-spheres.toml", "--to", "lammps", "-o", "-"], "a deck is a folder; expected the name of one"),
        (["two-spheres.toml", "--to", "lammps", "--license", "MIT"], "use them with --to ro-crate"),
        (["two-spheres.toml", "--to", "lammps", "--set", "contacts.restitution=0"], "expected 0.136 or more"),
        (["bowl", "--to", "csv", "--set", "title=Mine"], "--set changes a scene; use it with --to lammps"),
    ],
)
def test_impossible_decks_are_refused(words: list[str], expected: str) -> None:
    cli.invoke(app, ["new", "two-spheres"])
    refused = cli.invoke(app, ["export", *words])
    assert refused.exit_code == 2
    assert expected in refused.stderr


def test_export_makes_no_folder_that_was_perhaps_misspelt(tmp_path: Path) -> None:
    refused = cli.invoke(app, ["export", "bowl", "--to", "csv", "-o", "nodir/a.csv"])
    assert refused.exit_code == 2
    assert "the folder nodir does not exist" in refused.stderr
    assert not (tmp_path / "nodir").exists()


@pytest.fixture
def cuts(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Record the options of movies instead of making movies."""
    import ecume.show.movies

    noted: list[Any] = []

    def movie(directory: Path, out: Path | None, cut: Any, *, progress: Any, workers: int) -> Path:
        noted.append((cut, (progress, workers)))
        return out or directory / "results" / "movie.mp4"

    monkeypatch.setattr(ecume.show.movies, "movie", movie)
    return noted


def test_movie_says_what_it_wrote(cuts: list[Any]) -> None:
    assert cli.invoke(app, ["movie", "bowl", "-o", "bowl.gif"]).stdout == "wrote bowl.gif\n"
    assert cli.invoke(app, ["movie", "bowl"]).stdout == f"wrote {Path('bowl/results/movie.mp4')}\n"
    assert cli.invoke(app, ["movie", "bowl", "-q"]).output == ""
    usual = (30, 1, None, None, (1.0, None), (None, 1))
    assert [(cut.fps, cut.every, cut.size, cut.eye, cut.aim, rest) for cut, rest in cuts] == 3 * [usual]


def test_a_movie_that_became_a_webp_says_why_and_the_way_to_an_mp4(monkeypatch: pytest.MonkeyPatch) -> None:
    import ecume.show.movies

    def movie(directory: Path, out: Path | None, cut: Any, **_: Any) -> Path:
        return (out or directory / "movie.mp4").with_suffix(".webp")

    monkeypatch.setattr(ecume.show.movies, "movie", movie)
    for asked in ([], ["-o", "a.webm"]):
        reported = cli.invoke(app, ["movie", "bowl", *asked])
        assert reported.exit_code == 0
        assert "no ffmpeg was found" in reported.stderr
        assert "install ffmpeg, or pip install 'imageio-ffmpeg" in reported.stderr
    assert not cli.invoke(app, ["movie", "bowl", "-o", "a.webp"]).stderr


def test_the_options_of_a_movie_reach_it(cuts: list[Any]) -> None:
    words = ["--fps", "10", "--every", "3", "--size", "640x480", "--from", "1500 ms", "--to", "2"]
    words += ["--zoom", "2.5", "--follow", "7", "--azimuth", "10", "--workers", "2"]
    assert cli.invoke(app, ["movie", "bowl", *words]).exit_code == 0
    ((cut, (_, workers)),) = cuts
    assert (cut.aim, cut.eye, workers) == ((2.5, 7), (10.0, 20.0), 2)
    assert (cut.fps, cut.every, cut.size, cut.start, cut.end) == (10, 3, (640, 480), 1.5, 2.0)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--from", "2 mm"], "measures length"),
        (["--from", "soon"], "'20 s'"),
        (["--size", "640"], "expected WIDTHxHEIGHT"),
        (["--fps", "0"], "1 to 240"),
        (["--from", "3 s", "--to", "2 s"], "there is no time"),
    ],
)
def test_an_impossible_option_of_a_movie_is_reported(words: list[str], says: str, cuts: list[Any]) -> None:
    done = cli.invoke(app, ["movie", "bowl", *words])
    assert (done.exit_code, cuts) == (2, [])
    assert says in " ".join(done.stderr.replace("│", " ").split())


def test_pictures_are_counted_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    with counted("pictures", quiet=False) as reported:
        assert reported is not None
        reported(12, 300)
    assert "12 of 300 pictures" in capsys.readouterr().err
    with counted("pictures", quiet=True) as reported:
        assert reported is None


def test_plot_wants_a_run_or_the_integrators() -> None:
    both = cli.invoke(app, ["plot", "bowl", "--integrators"])
    assert (both.exit_code, "needs no run" in both.stderr) == (2, True)
    neither = cli.invoke(app, ["plot"])
    assert (neither.exit_code, "the current directory holds no run" in neither.stderr) == (2, True)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Replace figures by functions that record their names; one of them fails."""
    import ecume.show.figures

    noted: list[str] = []

    def plot(directory: Path, what: str, out: Path | None, finish: Finish) -> Path:
        if what == "force-law":
            raise BadInput("there is no force to draw")
        noted.append(what)
        return out or Path(what)

    def drawn_of(directory: Path, what: str) -> Figure:
        if what == "force-law":
            raise BadInput("there is no force to draw")
        noted.append(what)
        axes = (made := figure()).add_subplot(xlabel="time (s)", ylabel="energy (J)")
        axes.plot([0.0, 1.0], [1.0, 2.0])
        return made

    monkeypatch.setattr(ecume.show.figures, "plot", plot)
    monkeypatch.setattr(ecume.show.figures, "drawn_of", drawn_of)
    monkeypatch.setattr(ecume.show.figures, "figures_of_run", lambda directory: ["paths", "force-law", "energies"])
    return noted


def test_plot_means_the_run_in_the_current_directory(drawn: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("bowl")
    assert cli.invoke(app, ["plot"]).exit_code == 0
    assert drawn == ["paths", "energies"]


def test_plot_draws_every_figure_that_can_be_drawn(drawn: list[str]) -> None:
    done = cli.invoke(app, ["plot", "bowl"])
    assert done.exit_code == 0
    assert drawn == ["paths", "energies"]
    assert done.stderr == ""
    explained = cli.invoke(app, ["plot", "bowl", "--verbose"])
    assert explained.stderr == "ecume: force-law omitted: there is no force to draw\n"


def test_plot_lists_the_figures_of_a_run_with_what_they_show(monkeypatch: pytest.MonkeyPatch) -> None:
    import ecume.show.figures

    run = contextlib.nullcontext(SimpleNamespace(scene=SimpleNamespace(model="floating")))
    monkeypatch.setattr(ecume.show.figures, "open_trajectory", lambda directory: run)
    done = cli.invoke(app, ["plot", "bowl", "--list"])
    assert (done.exit_code, done.stderr) == (0, "")
    lines = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    assert lines["force-law"].startswith("The force between two floats over their distance")
    assert set(lines) == {*FLOATING_FIGURES, "sizes", "samples"}
    assert not list(Path("bowl").glob("**/*.png"))


def test_plot_of_a_run_with_one_frame_reports_it_once(drawn: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    import ecume.show.figures

    def plot(directory: Path, what: str, out: Path | None, finish: Finish) -> Path:
        raise BadInput(f"{ONE_FRAME} at 0 s; a figure over time needs two frames or more")

    monkeypatch.setattr(ecume.show.figures, "plot", plot)
    done = cli.invoke(app, ["plot", "bowl"])
    assert done.stderr == "ecume: the run has a single frame, figures over time are omitted\n"


@pytest.mark.long
def test_plot_draws_the_named_figure_or_reports_why_not(drawn: list[str]) -> None:
    assert cli.invoke(app, ["plot", "bowl", "--what", "paths", "-o", "a.pdf"]).stdout == "wrote a.pdf\n"
    assert cli.invoke(app, ["plot", "bowl", "--what", "force-law"]).exit_code == 2
    two = cli.invoke(app, ["plot", "bowl", "--what", "paths", "--what", "energies", "-o", "a.pdf"])
    assert "2 figures do not fit into a.pdf" in two.stderr
    assert "a file holds one figure; name it with --what" in cli.invoke(app, ["plot", "bowl", "-o", "a.pdf"]).stderr
    assert drawn == ["paths"]


def test_plot_writes_all_figures_into_a_folder_in_a_format(drawn: list[str]) -> None:
    done = cli.invoke(app, ["plot", "bowl", "-o", "figures", "--format", "svg"])
    assert (done.exit_code, drawn) == (0, ["paths", "energies"])
    enabled = [f"wrote {Path('figures') / name}.svg" for name in ("paths", "energies")]
    assert done.stdout.splitlines() == enabled
    Path("there").mkdir()
    named = cli.invoke(app, ["plot", "bowl", "--what", "paths", "--what", "energies", "-o", "there", "--format", "pdf"])
    assert named.exit_code == 0
    assert {path.name for path in Path("there").iterdir()} == {"paths.pdf", "energies.pdf"}


def test_plot_joins_runs_and_an_experiment_and_writes_their_numbers(drawn: list[str]) -> None:
    Path("other").mkdir()
    Path("other/manifest.json").write_text('{"ecume": "0"}')
    Path("lab.csv").write_text("time [s],energy [J]\n0,1\n")
    words = [
        "plot",
        "bowl",
        "other",
        "lab.csv",
        "--what",
        "paths",
        "-o",
        "a.svg",
        "--data",
        "a.csv",
        "--width",
        "86 mm",
    ]
    done = cli.invoke(app, words)
    assert (done.exit_code, done.stdout) == (0, "wrote a.csv\nwrote a.svg\n")
    series = [line.split(",")[1] for line in Path("a.csv").read_text().splitlines()[1:]]
    assert series == ["bowl", "bowl", "other", "other", '"energy']


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-o", "a.csv"], "got the ending '.csv'; expected .png, .pdf or .svg, or a folder; --data writes"),
        (["--format", "doc"], "--format: got 'doc'; expected one of png, pdf, svg"),
        (["--width", "86"], "got 86 without a unit; write '86 mm'"),
        (["--data", "a.csv"], "expected --what with the name of the figure"),
        (["lab.csv"], "expected --what with the name of the figure"),
    ],
)
def test_what_plot_cannot_write_is_refused_before_it_draws(words: list[str], says: str, drawn: list[str]) -> None:
    done = cli.invoke(app, ["plot", "bowl", *words])
    assert (done.exit_code, drawn) == (2, [])
    assert says in " ".join(done.stderr.replace("│", " ").split())
