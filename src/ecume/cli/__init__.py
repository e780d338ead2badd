"""The command line: verbs, their help, and the end of each.

Start with the verbs: `scenes`, `runs`, `movies`, `plots`, `exports`, `browser`, `sweeps`, `fits`, `comparisons`; each
lists its own in `VERBS`. `output` prints, `progress` reports, and `endings` converts errors to messages and exit codes.
Slow modules are imported only when a verb runs, so that `ecume --help` is fast.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Annotated

import typer

from ecume.cli import browser, comparisons, exports, fits, movies, plots, progress, runs, scenes, sweeps
from ecume.cli.endings import Ending, warned
from ecume.cli.output import echo
from ecume.cli.scenes import own_process

app = typer.Typer(
    name="ecume",
    cls=Ending,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Particles on, in and between liquids: from a scene file to a movie.",
    epilog="""A first run: `ecume new cereal-bowl`, `ecume run cereal-bowl.toml`, `ecume movie runs/cereal-bowl`.

Exit codes: 0 success, 1 a validation, sweep or comparison failed, 2 invalid input, 3 the simulation diverged, 4 files
cannot be read or written, 75 stopped with a checkpoint (continue with `ecume resume`).""",
)

ALONE = (
    scenes.new,
    comparisons.validate,
    comparisons.reproduce,
    comparisons.bench,
    runs.resume,
    runs.info,
    runs.list_runs,
    runs.verify,
    runs.repair,
    movies.movie,
    plots.plot,
    browser.view,
    browser.play,
)
"""Verbs without required arguments: they list their choices or use the run in the current directory."""

NAMES: dict[Callable[..., None], str] = {runs.list_runs: "list", runs.import_run: "import"}
"""Verbs whose names are Python's own words."""

MODULES = (scenes, runs, movies, plots, exports, browser, sweeps, fits, comparisons)
for verb in (verb for module in MODULES for verb in module.VERBS):
    app.command(NAMES.get(verb), no_args_is_help=verb not in ALONE)(verb)


def _version(asked: bool) -> None:
    if asked:
        from ecume._version import __version__

        echo(f"ecume {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Particles on, in and between liquids: from a scene file to a movie."""
    progress.start()


def main() -> None:
    """Run the command line of this process."""
    warnings.showwarning = warned
    own_process.append(True)
    app(prog_name="ecume")
