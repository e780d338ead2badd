"""The verbs for the browser: view and play."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.options import argument, option
from ecume.cli.output import echo, wrote
from ecume.cli.runs import HERE, Quiet, offered
from ecume.cli.scenes import Overrides, without_compiler_for
from ecume.errors import BadInput

if TYPE_CHECKING:
    from ecume.show.view.page import Parts

LOOK_EVERY = 0.5
"""Seconds between two checks whether a followed run has ended."""


Viewed = Annotated[
    Path, argument(metavar="DIR", help="Directory of a run, or the file of a scene; default: the current directory.")
]


def view(
    directory: Viewed = HERE,
    save: Annotated[
        Path | None, option("--save", metavar="FILE", help="Write the page to a file instead of opening it.")
    ] = None,
    max_size: Annotated[
        float,
        typer.Option(
            "--max-size", min=0.5, max=2000.0, metavar="MB", help="Largest page; long runs show fewer frames."
        ),
    ] = 50.0,
    live: Annotated[bool, typer.Option("--live", help="Follow a run in progress.")] = False,
    quiet: Quiet = False,
) -> None:
    """Play a run in the browser, or simulate a scene there.

    The page is a single HTML file that needs neither a server nor a network. Of a scene it simulates floats in a dish,
    with the same compiled laws: drop and drag floats, tilt the dish, change the liquid; a tank of water in 2D: pour,
    open a gate, tilt; or the four spheres of a T1 process: change their gap and the forces.

    Examples: `ecume view runs/bowl` · `ecume view runs/bowl --save bowl.html --max-size 8`
    · `ecume view runs/bowl --live` · `ecume view bowl.toml --save bowl.html`
    """
    if directory.is_file():
        if live:
            raise BadInput(f"--live follows a run; {directory} is a file: leave --live out")
        _simulate(directory, save, max_size, quiet=quiet)
        return
    from ecume.run.directory import existing

    existing(directory)
    if live:
        if save is not None:
            raise BadInput("--live follows a run and writes no page; leave --save out")
        _follow(directory)
        return
    without_compiler_for(directory)
    from ecume.show.view import save_page

    page = save_page(directory, save, max_size)
    if not quiet:
        shown = (
            f"{page.frames} frames" if page.every == 1 else f"{page.frames} frames, each {_nth(page.every)} of the run"
        )
        wrote(page.path, quiet=quiet)
        echo(f"{page.size / 1e6:.1f} MB, {shown}")
    if save is None:
        typer.launch(page.path.resolve().as_uri())


def _simulate(scene: Path, save: Path | None, max_size: float, *, quiet: bool) -> None:
    """Write the page that simulates a scene."""
    from ecume.scenes.load import load_scene
    from ecume.show.play.alone import save_alone

    target = save or scene.with_suffix(".html")
    size = save_alone(load_scene(scene), target, max_size)
    wrote(target, quiet=quiet)
    if not quiet:
        echo(f"{size / 1e6:.1f} MB")
    if save is None:
        typer.launch(target.resolve().as_uri())


def _nth(number: int) -> str:
    return {2: "2nd", 3: "3rd"}.get(number, f"{number}th")


def _follow(directory: Path) -> None:
    """Serve a run until it ends or Ctrl-C is pressed."""
    from ecume.run import RunDirectory, lock
    from ecume.run import info as look
    from ecume.show.view.page import Source, serving

    def stop() -> None:
        lock.stop(RunDirectory(directory))

    def state() -> str:
        return look(directory).state

    with serving(Source(directory, state, stop)) as address, offered(address):
        while state() == "running":
            time.sleep(LOOK_EVERY)
    echo(f"{directory}: {state()}")


def play(
    scene: Annotated[
        Path | None,
        argument(
            metavar="SCENE",
            help="Scene of floats in a dish, of a tank in 2D, or of a T1 process; default: one of each on one page.",
        ),
    ] = None,
    tank: Annotated[bool, typer.Option("--tank", help="Use a small tank of water instead of a scene.")] = False,
    save: Annotated[
        Path | None, option("--save", metavar="FILE", help="Write the page to a file instead of opening it.")
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Play with a simulation in the browser while it runs.

    A bowl: drop and drag floats, tilt the dish, change the liquid. A tank: pour liquid, open a gate, push a wall, tilt.
    A T1 process: change the gap and the forces.
    All are simulated in the page where their laws are compiled into pages, otherwise by this program.

    Ends with Ctrl-C. `save as scene` on the page writes the present state as a scene in TOML.

    Examples: `ecume play` · `ecume play --tank` · `ecume play --save play.html`
    · `ecume play bowl.toml --set dish.contact_angle='"110 deg"'`
    """
    from ecume.scenes.load import load_scene
    from ecume.scenes.templates import folder
    from ecume.show.play.alone import alone, parts_of, refusal, templates, together
    from ecume.show.view.page import ALL
    from ecume.trajectories.records import write_whole

    if tank and scene is not None:
        raise BadInput("got SCENE and --tank, which has a built-in tank; expected one of them")
    echo("starting; the first start compiles, which can take minutes ...")
    changes = overrides or []
    if tank or scene is not None:
        shown = [load_scene(scene or (folder() / "small-tank.toml").read_text(encoding="utf-8"), changes)]
        parts = parts_of(shown[0])
    else:
        shown, parts = templates("particles[0].count=12", *changes), ALL
    if save is None and refusal(shown[0]):
        _run_game(shown[0])
        return
    page = together(shown) if len(shown) > 1 else alone(shown[0])  # which refuses what pages cannot simulate
    if save is None:
        _offer_page(page, parts)
        return
    write_whole(save, page)
    wrote(save, quiet=False)


def _offer_page(page: str, parts: Parts) -> None:
    """Serve a page that simulates by itself until Ctrl-C."""
    from ecume.show.play.pages import Written
    from ecume.show.serving import served

    with served(Written(page, parts)) as address, offered(address, "play; Ctrl-C ends it"):
        _wait()


def _run_game(scene: Any) -> None:
    """Serve a scene that this program simulates until Ctrl-C."""
    from ecume.show.play.pages import game_of
    from ecume.show.serving import served

    game = game_of(scene)
    game.toy.moving.play(0.0)
    with served(game) as address, offered(address, "play"):
        try:
            game.run()
        except KeyboardInterrupt:
            echo("stopped: the time limit of a game is reached")


def _wait() -> None:
    """Wait until Ctrl-C is pressed."""
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            time.sleep(LOOK_EVERY)


VERBS = (view, play)
