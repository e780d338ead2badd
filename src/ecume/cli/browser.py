"""The verbs for the browser: view and play."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import Annotated

import typer

from ecume.cli.options import argument, option
from ecume.cli.output import echo, wrote
from ecume.cli.runs import HERE, Quiet, offered
from ecume.cli.scenes import Overrides, without_compiler_for
from ecume.errors import BadInput

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
            help="Scene of floats in a dish, of a tank in 2D, or of a T1 process; default: a small bowl.",
        ),
    ] = None,
    tank: Annotated[bool, typer.Option("--tank", help="Use a small tank of water instead of a scene.")] = False,
    overrides: Overrides = None,
) -> None:
    """Play with a simulation in the browser while it runs.

    A bowl: drop and drag floats, tilt the dish, change the liquid. A tank: pour liquid, open a gate, push a wall, tilt.
    A T1 process: change the gap and the forces.
    A bowl or a tank is simulated in the page where its laws are compiled into pages, otherwise by this program.

    Ends with Ctrl-C. `save as scene` on the page writes the present state as a scene in TOML.

    Examples: `ecume play` · `ecume play --tank` · `ecume play bowl.toml --set dish.contact_angle='"110 deg"'`
    """
    from ecume.scenes.load import load_scene
    from ecume.scenes.templates import folder
    from ecume.show.play.alone import alone, parts_of, refusal
    from ecume.show.play.pages import Written, game_of
    from ecume.show.serving import served

    if tank and scene is not None:
        raise BadInput("got SCENE and --tank, which has a built-in tank; expected one of them")
    name = "small-tank" if tank else "cereal-bowl"
    usual = [] if tank or scene else ["particles[0].count=12"]
    given = scene or (folder() / f"{name}.toml").read_text(encoding="utf-8")
    asked = load_scene(given, [*usual, *(overrides or [])])
    echo("starting; the first start compiles, which can take minutes ...")
    if not refusal(asked):
        with served(Written(alone(asked), parts_of(asked))) as address, offered(address, "play; Ctrl-C ends it"):
            _wait()
        return
    game = game_of(asked)
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
