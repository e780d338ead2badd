"""The verb sweep: many runs of one scene."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.output import Json, print_json, say
from ecume.cli.progress import counted, lasting
from ecume.cli.runs import Quiet, use_at_most
from ecume.errors import BadInput, Stopped

if TYPE_CHECKING:
    from ecume.sweep import Outcome

SWEEPS = Path("sweeps")
"""Where sweeps go by default: `sweeps/durations` for `durations.toml`."""


def task_of(text: str) -> tuple[int, int]:
    """A task of an array: `3/100`."""
    match = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", text)
    if match is None or not int(match[1]) < int(match[2]):
        raise typer.BadParameter(f"{text!r}: expected NUMBER/TASKS, such as 3/100")
    return int(match[1]), int(match[2])


def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP", help="File or directory of a sweep.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            metavar="DIR",
            help="Directory of the sweep; default: sweeps/NAME for NAME.toml.",
            show_default=False,
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            min=1,
            max=4096,
            metavar="N",
            help="Number of workers; default: one per core.",
            show_default=False,
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Address of a running Dask scheduler.", show_default=False),
    ] = None,
    retries: Annotated[
        int, typer.Option("--retries", min=0, max=100, metavar="N", help="Retries of a point whose worker died.")
    ] = 2,
    slurm: Annotated[bool, typer.Option("--slurm", help="Run the workers as SLURM jobs.")] = False,
    array: Annotated[bool, typer.Option("--array", help="Write a job array for sbatch, and run nothing.")] = False,
    task: Annotated[Any, typer.Option("--task", parser=task_of, hidden=True)] = None,
    status: Annotated[bool, typer.Option("--status", help="Print the progress, and run nothing.")] = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scene many times, each point in a separate directory.

    Finished points are not repeated.

    Examples: `ecume sweep durations.toml` · `ecume sweep durations.toml --workers 8` · `ecume sweep sweeps/durations
    --status` · `ecume sweep durations.toml --array && sbatch sweeps/durations/array.sh`
    """
    use_at_most(1)
    if sum((workers is not None, scheduler is not None, slurm, array, status)) > 1:
        raise BadInput("expected one of --workers, --scheduler, --slurm, --array and --status")
    if json and not status:
        raise BadInput("--json goes with --status")
    directory = out or (file if file.is_dir() else SWEEPS / file.stem)
    source = file / "sweep.toml" if file.is_dir() else file
    if status:
        _print_status(directory, json=json)
    elif task is not None:
        _work(directory, *task)
    elif array:
        _write_array(source, directory)
    else:
        hands = {"workers": workers, "scheduler": scheduler, "slurm": slurm, "retries": retries}
        _run_all(source, directory, hands, quiet=quiet)


def _write_array(source: Path, directory: Path) -> None:
    from ecume.sweep.directory import begun_or_laid_out
    from ecume.sweep.executors import write_array

    typer.echo(f"wrote {write_array(begun_or_laid_out(source, directory))}; submit it with sbatch")


def _run_all(source: Path, directory: Path, hands: dict[str, Any], *, quiet: bool) -> None:
    """Run what is missing, and say what became of it."""
    from ecume.sweep import ExecutorOptions, runner

    def failed(folder: Path, why: str) -> None:
        say(f"{folder}: {why}")

    with counted("points", quiet=quiet, lines=True) as reporter:
        done = runner.sweep(source, directory, ExecutorOptions(**hands, progress=reporter, failed=failed))
    _end(done, quiet=quiet)


def _end(done: Outcome, *, quiet: bool) -> None:
    """Report the outcome of a sweep; one with failures ends with 1."""
    if not quiet:
        busy = f", {done.busy} elsewhere at work" if done.busy else ""
        typer.echo(
            f"{done.directory}: {done.done} points done, {len(done.failed)} failed{busy}; table.csv has them all"
        )
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
    typer.echo(
        f"{directory}: {now.done} done, {len(now.failed)} failed, {now.running} running, {now.missing} missing{left}"
    )
    for folder, why in now.failed:
        say(f"{folder}: {why}")


def _work(directory: Path, number: int, of: int) -> None:
    """A task of a job array."""
    from ecume.sweep.directory import existing_sweep
    from ecume.sweep.executors import work_task

    words = work_task(existing_sweep(directory), number, of)
    if "failed" in words:
        raise BadInput(f"{words.count('failed')} of {len(words)} points failed; see ecume sweep {directory} --status")


VERBS = (sweep,)
