"""The verbs about runs: run, resume, info and repair."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume._compiler_events import watch
from ecume.cli.clock import elapsed
from ecume.cli.exit_codes import say
from ecume.cli.mpi_launcher import Engine, Ranks, integrating
from ecume.cli.output import Json, print_json
from ecume.cli.progress import ahead, lasting, shown
from ecume.cli.scenes import Laws, Overrides, SceneFile, placed

if TYPE_CHECKING:
    from ecume.run import Info, RunResult

RUNS = Path("runs")
"""Where runs go by default: `runs/bowl` for `bowl.toml`."""

HERE = Path()
RunFolder = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="Directory of a run; default: the current one.", show_default=False),
]
Threads = Annotated[
    int | None,
    typer.Option(
        "--threads",
        min=1,
        max=1024,
        metavar="N",
        help="Number of threads; the result does not depend on it.",
        show_default=False,
    ),
]
Violation = Annotated[
    str | None,
    typer.Option(
        "--on-violation",
        metavar="warn|stop",
        help="Reaction to a violated invariant (energy, mass, overlap ...); default: that of the scene, or warn.",
        show_default=False,
    ),
]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print only errors.")]


def run(
    scene: SceneFile,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            metavar="DIR",
            help="Directory of the run; default: runs/NAME for NAME.toml.",
            show_default=False,
        ),
    ] = None,
    overrides: Overrides = None,
    laws: Laws = None,
    threads: Threads = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing run.")] = False,
    view: Annotated[bool, typer.Option("--view", help="Show the run in the browser while it is computed.")] = False,
    on_violation: Violation = None,
    quiet: Quiet = False,
    engine: Engine = "local",
    ranks: Ranks = None,
) -> None:
    """Simulate a scene into a directory. Ctrl-C stops with a checkpoint.

    Examples: `ecume run bowl.toml` · `ecume run bowl.toml -o runs/syrup --set "liquid.viscosity=1 Pa*s" --threads 2`
    """
    use_at_most(threads)
    from ecume.run import RunOptions
    from ecume.run import run as simulate
    from ecume.run.user_laws import laws_from
    from ecume.scenes.load import load_scene

    changes = overrides or []
    directory = out or RUNS / scene.stem
    with integrating(engine, ranks) as led:
        asked = load_scene(scene, changes)
        # With changes from the command line the file is not the simulated scene; the resolved scene is.
        source = None if changes else scene.read_bytes()
        with placed(scene, changes), watched(directory, wanted=view), shown(quiet=quiet) as reporter:
            done = simulate(
                asked,
                directory,
                extra_laws=laws_from(laws or []),
                force=force,
                options=RunOptions(
                    threads=threads, progress=reporter, source=source, on_violation=on_violation, engine=led
                ),
            )
        _end(done, quiet=quiet)


def resume(
    directory: RunFolder = HERE,
    laws: Laws = None,
    threads: Threads = None,
    on_violation: Violation = None,
    strict: Annotated[
        bool,
        typer.Option("--strict", help="Stop if a recomputed frame differs in any bit, even on another processor."),
    ] = False,
    quiet: Quiet = False,
    engine: Engine = "local",
    ranks: Ranks = None,
) -> None:
    """Continue a run that was stopped or killed.

    With the same processor and versions the result is bit-for-bit that of an uninterrupted run. Otherwise the last
    digits may differ; a warning states by how much. A run with user laws needs their file again (--laws).

    Examples: `ecume resume runs/bowl` · `ecume resume runs/bowl --threads 2 --quiet`
    """
    use_at_most(threads)
    from ecume.run import RunOptions
    from ecume.run import resume as go_on
    from ecume.run.user_laws import laws_from

    with integrating(engine, ranks) as led, shown(quiet=quiet) as reporter:
        options = RunOptions(threads=threads, progress=reporter, on_violation=on_violation, engine=led, strict=strict)
        _end(go_on(directory, extra_laws=laws_from(laws or []), options=options), quiet=quiet)


def _end(done: RunResult, *, quiet: bool) -> None:
    """Print the result of a run, and the invariants that it violated."""
    from ecume.run.directory import RunDirectory
    from ecume.run.invariant_monitor import BROKEN, summary_line

    if not quiet:
        typer.echo(summary(done))
    if (watch := summary_line(RunDirectory(done.directory))).startswith(BROKEN):
        say(f"warning: {done.directory}: {watch}; see {RunDirectory(done.directory).watch.name}")


def info(directory: RunFolder = HERE, json: Json = False) -> None:
    """Report the content and the progress of a run.

    Works during the run and after it was killed, too.

    Example: `ecume info runs/bowl`
    """
    from ecume.run import info as look

    found = look(directory)
    if json:
        print_json(found._asdict())
        return
    rows = described(found)
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        typer.echo(f"{name:<{width}}  {value}")


def repair(directory: RunFolder = HERE) -> None:
    """Repair a damaged run: complete frames are kept.

    Prints each damaged frame.

    Recreates a damaged `resolved.json` from `scene.toml`. Damaged files that a resumed run writes again are renamed.

    Example: `ecume repair runs/bowl`
    """
    from ecume.run import repair as mend

    mended = mend(directory)
    for fault in (*mended.faults, *(f"{path}: set aside, no frame in it is whole" for path in mended.unusable)):
        typer.echo(fault)
    typer.echo(f"{mended.good} frames are good")


@contextlib.contextmanager
def watched(directory: Path, *, wanted: bool) -> Iterator[None]:
    """Let the browser follow the run that is made inside."""
    if not wanted:
        yield
        return
    from ecume.run.stop_requests import ask_to_stop
    from ecume.show.view.live import Source, serving

    ended: list[str] = []
    source = Source(directory, lambda: ended[0] if ended else "running", lambda: ask_to_stop(os.getpid()))
    with serving(source) as address:
        offer(address)
        try:
            yield
            ended.append("done")
        finally:
            ended.append("stopped")


def offer(address: str) -> None:
    """Open an address in the browser, and say it."""
    import webbrowser

    typer.echo(f"open {address} to follow the run")
    webbrowser.open(address)


def use_at_most(threads: int | None) -> None:
    """Numba fixes the most threads it will ever use when it is first imported."""
    if threads is not None and "numba" not in sys.modules:
        os.environ["NUMBA_NUM_THREADS"] = str(max(threads, os.cpu_count() or 1))


def summary(done: RunResult) -> str:
    """A line about a completed run."""
    reached = f"{done.directory}: {done.frames} frames, {done.time:.6g} s in {done.steps} steps"
    return f"{reached}, {_spent(done)}" if done.seconds else f"{reached}; it was complete already"


LARGE = 0.2
"""Of the wall time: setup and compilation that take more of it are named."""


def _spent(done: RunResult) -> str:
    """The wall time of the command: `4.5 s (3.6 s for setup and compilation)`."""
    total = max(elapsed(), done.seconds)
    apart = 0.0 if done.integrating is None else total - done.integrating
    what = "setup and compilation" if watch.count else "setup"
    return f"{lasting(total)} ({lasting(apart)} for {what})" if apart > LARGE * total else lasting(total)


def described(run: Info) -> list[tuple[str, str]]:
    """The information about a run, as names and values."""
    rows = [
        ("run", str(run.directory)),
        ("model", str(run.manifest.get("model", ""))),
        ("user laws", ", ".join(law["name"] for law in run.manifest.get("extra_laws", []))),
        ("state", f"{run.state}, {ahead(run.remaining)}" if run.remaining is not None else run.state),
        ("simulated", f"{run.time:.6g} s of {run.duration:.6g} s"),
        ("steps", str(run.step) if run.steps is None else f"{run.step} of {run.steps}"),
        ("frames", str(run.frames)),
        ("checkpoint", "none" if run.checkpoint is None else f"at step {run.checkpoint}"),
        ("wall time", _wall_time(run.manifest.get("sessions", []))),
        ("replaced", "; ".join(replacements(run.manifest))),
        ("size", f"{run.size / 1e6:.3g} MB"),
        ("invariants", run.watch),
        ("remark", run.why),
    ]
    return [(name, value) for name, value in rows if value]


def _wall_time(sessions: Sequence[dict[str, Any]]) -> str:
    """The wall time and the number of sessions; a killed session did not record its time."""
    seconds = sum(session.get("seconds", 0.0) for session in sessions)
    worked = lasting(seconds)
    return f"{worked}, in {len(sessions)} sessions" if len(sessions) > 1 else worked if seconds else ""


def replacements(manifest: dict[str, Any]) -> list[str]:
    """The frames that were replaced because another processor or other versions computed them with other bits."""
    found = [session["replaced"] for session in manifest.get("sessions", []) if "replaced" in session]
    return [
        f"from frame {one['frame']} (t = {one['time']:g} s) on, which differed in {one['difference']} "
        f"({'; '.join(one['changed'])})"
        for one in found
    ]


VERBS = (run, resume, info, repair)
