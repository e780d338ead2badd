"""The verb sweep: a scene that is simulated repeatedly with different values."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.endings import say
from ecume.cli.options import argument, option
from ecume.cli.output import Json, echo, print_json, print_table
from ecume.cli.progress import counted, lasting
from ecume.cli.runs import Quiet, use_at_most
from ecume.cli.scenes import Laws
from ecume.errors import BadInput, Stopped

if TYPE_CHECKING:
    from ecume.sweep import Outcome

SWEEPS = Path("sweeps")
"""The default parent folder of sweeps: `sweeps/durations` for `durations.toml`."""


def task_of(text: str) -> tuple[int, int]:
    """The number of a task and of all tasks of an array, from a text: `3/100`."""
    match = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", text)
    if match is None or not int(match[1]) < int(match[2]):
        raise typer.BadParameter(f"{text!r}: expected NUMBER/TASKS, such as 3/100")
    return int(match[1]), int(match[2])


def sweep(
    file: Annotated[Path, argument(metavar="SWEEP", help="File or directory of a sweep.")],
    *,
    out: Annotated[
        Path | None,
        option("-o", "--out", metavar="DIR", help="Directory of the sweep; default: sweeps/NAME for NAME.toml."),
    ] = None,
    workers: Annotated[
        int | None, option("--workers", min=1, max=4096, metavar="N", help="Number of workers; default: one per core.")
    ] = None,
    scheduler: Annotated[
        str | None, option("--scheduler", metavar="ADDRESS", help="Address of a running Dask scheduler.")
    ] = None,
    retries: Annotated[
        int, typer.Option("--retries", min=0, max=100, metavar="N", help="Retries of a point whose worker died.")
    ] = 2,
    slurm: Annotated[bool, typer.Option("--slurm", help="Run the workers as SLURM jobs.")] = False,
    array: Annotated[bool, typer.Option("--array", help="Write a job array for sbatch, and run nothing.")] = False,
    task: Annotated[Any, typer.Option("--task", parser=task_of, hidden=True)] = None,
    status: Annotated[bool, typer.Option("--status", help="Print the progress, and run nothing.")] = False,
    fit: Annotated[
        bool, typer.Option("--fit", help="Fit offset + K x^n to the first measure: table, figure and intervals.")
    ] = False,
    laws: Laws = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scene many times, each point in a separate directory.

    Finished points are not repeated.

    Examples: `ecume sweep durations.toml` · `ecume sweep durations.toml --workers 8`
    · `ecume sweep flow-curve.toml --fit` · `ecume sweep sweeps/durations --status`
    · `ecume sweep durations.toml --array && sbatch sweeps/durations/array.sh`
    """
    use_at_most(1)
    if sum((workers is not None, scheduler is not None, slurm, array, status)) > 1:
        raise BadInput("expected one of --workers, --scheduler, --slurm, --array and --status")
    if fit and (status or array or task is not None):
        raise BadInput("--fit is that of finished runs; expected it without --status and --array")
    if json and not status:
        raise BadInput("--json goes with --status")
    directory = out or (file if file.is_dir() else SWEEPS / file.stem)
    source = file / "sweep.toml" if file.is_dir() else file
    if status:
        _print_status(directory, json=json)
    elif task is not None:
        _work(directory, task, laws or [])
    elif array:
        _write_array(source, directory, absolute(laws or []))
    else:
        choices: dict[str, Any] = {"workers": workers, "scheduler": scheduler, "slurm": slurm, "retries": retries}
        choices["laws"] = tuple(absolute(laws or []))
        _run_all(source, directory, choices, quiet=quiet)
        if fit:
            _fit_all(directory, quiet=quiet)


def absolute(laws: Sequence[str]) -> list[str]:
    """The absolute paths of the files with user laws, which workers find from any folder."""
    return [str(Path(law).absolute()) for law in laws]


def _write_array(source: Path, directory: Path, laws: Sequence[str]) -> None:
    from ecume.run.user_code import entries, laws_from
    from ecume.sweep.directory import open_or_create
    from ecume.sweep.executors import write_array

    sweeping = open_or_create(source, directory, entries(laws_from(laws)))
    echo(f"wrote {write_array(sweeping, laws)}; submit it with sbatch")


def _run_all(source: Path, directory: Path, choices: dict[str, Any], *, quiet: bool) -> None:
    """Run the missing points, and report their results."""
    from ecume.sweep import ExecutorOptions, results

    def failed(folder: Path, why: str) -> None:
        say(f"{folder}: {why}")

    with counted("points", quiet=quiet, lines=True) as reporter:
        done = results.sweep(source, directory, ExecutorOptions(**choices, progress=reporter, failed=failed))
    _end(done, quiet=quiet)


def _fit_all(directory: Path, *, quiet: bool) -> None:
    """Draw and write the fit of the first measure, and print its parameters with their intervals; for two curves, also
    their largest difference.
    """
    import numpy as np

    from ecume.analysis.curves import largest_difference
    from ecume.sweep.figures import fitted_curves, plot_sweep
    from ecume.sweep.fits import PARAMETERS, fit_of

    (picture,) = plot_sweep(directory, "fit")
    measure, curves = fitted_curves(directory)
    if quiet:
        return
    rows = []
    for points in curves:
        found, name = fit_of(points), points.label or measure
        for parameter in PARAMETERS:
            value, error = getattr(found, parameter)
            half = points.width * error
            rows.append((name, parameter, f"{value:.4g}", f"{value - half:.4g} to {value + half:.4g}"))
        rows.append((name, "misfit", f"{found.misfit:.3g}", "1 where curve and errors are right"))
    print_table(("curve", "of offset + factor x^exponent", "value", "95 % interval"), rows)
    omitted = sum(points.omitted for points in curves)
    if omitted:
        say(f"{omitted} runs are omitted: {measure} is not stationary there, or not a number; run these for longer")
    if len(curves) == 2 and np.intersect1d(curves[0].at, curves[1].at).size:
        apart = largest_difference(*(points.curve for points in curves))
        said = f"{100.0 * apart.relative:+.2g} %, {apart.errors:.2g} standard errors"
        echo(f"{curves[1].label} differs from {curves[0].label} most at {apart.at:.4g}: by {said}")
    echo(f"wrote {picture} and {picture.with_suffix('.csv')}")


def _end(done: Outcome, *, quiet: bool) -> None:
    """Report the outcome of a sweep. The exit code is 1 if points failed."""
    if not quiet:
        busy = f", {done.busy} elsewhere at work" if done.busy else ""
        echo(f"{done.directory}: {done.done} points done, {len(done.failed)} failed{busy}; table.csv has them all")
    if done.lost:
        raise Stopped(
            f"{done.lost} of the points are missing: their workers died again and again, of too little memory perhaps; "
            "finished points are kept; the same command continues the sweep"
        )
    if done.failed:
        raise typer.Exit(1)


def _print_status(directory: Path, *, json: bool) -> None:
    from ecume.sweep.directory import standing

    now = standing(directory)
    if json:
        print_json(now._asdict())
        return
    left = f"; {lasting(now.remaining)} left at the pace of the last points" if now.remaining is not None else ""
    echo(f"{directory}: {now.done} done, {len(now.failed)} failed, {now.running} running, {now.missing} missing{left}")
    for folder, why in now.failed:
        say(f"{folder}: {why}")


def _work(directory: Path, task: tuple[int, int], laws: Sequence[str]) -> None:
    """Run a task of a job array."""
    from ecume.sweep.directory import existing_sweep
    from ecume.sweep.executors import work_task

    words = work_task(existing_sweep(directory), *task, laws)
    if "failed" in words:
        raise BadInput(f"{words.count('failed')} of {len(words)} points failed; see ecume sweep {directory} --status")


VERBS = (sweep,)
