"""`sh scripts/mutate`: which small faults in the models and the engine do the tests catch?

Tries the drawn faults that have no result yet, one after the other, in a copy of the checkout. A long run can be broken
off at any time and goes on from there the next time.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.mutation import results, review
from tests.mutation.faults import changed
from tests.mutation.sample import PACKAGES, Mutant, drawn
from tests.mutation.tree import ROOT, Tree
from tests.mutation.trial import EVERY_TEST, TESTS, Passes, trial


def main() -> int:
    """Zero if all that was tried was caught."""
    chosen = _arguments()
    mutants = [mutant for mutant in drawn(ROOT / "src" / "ecume") if chosen.package in (None, mutant.package)]
    if chosen.verb == "list":
        print(*mutants, sep="\n")
        return 0
    if chosen.verb == "report":
        print(results.summary(mutants, results.latest(chosen.results), results.equivalent()))
        return 0
    tree = Tree(chosen.folder)
    tree.update()
    if chosen.verb == "review":
        return review.tried(tree, chosen.only, Passes(not chosen.plain))
    wanted = _wanted(mutants, chosen)
    return int(try_all(tree, wanted, chosen.results, chosen.hours, Passes(not chosen.plain, chosen.tests)) > 0)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="scripts/mutate", description=__doc__)
    parser.add_argument(
        "verb", nargs="?", default="run", choices=["run", "list", "report", "review"],
        help="try the drawn faults (run), show them (list), count what was caught (report), or try the faults that "
        "a review put in by hand (review)",
    )  # fmt: skip
    parser.add_argument("--hours", type=float, default=2.0, help="begin no trial after this time (2)")
    parser.add_argument("--package", choices=list(PACKAGES), help="the faults of this package only")
    parser.add_argument("--only", nargs="*", default=[], help="the faults with these names only, tried again")
    parser.add_argument("--survivors", action="store_true", help="try again what survived the last time")
    parser.add_argument("--plain", action="store_true", help="plain Python only; its survivors are not recorded")
    parser.add_argument("--tests", nargs="*", default=[], help="these tests alone; their survivors are not recorded")
    parser.add_argument("--folder", type=Path, default=ROOT / ".venv" / "mutation", help="of the copy")
    parser.add_argument("--results", type=Path, default=results.RESULTS, help="the file of the results")
    return parser.parse_args()


def pending(mutants: Sequence[Mutant], rows: Mapping[str, Mapping[str, Any]]) -> list[Mutant]:
    """What has no result yet: a few of each package in turn, so that a piece of the work tells of all."""
    totals, before = Counter(mutant.package for mutant in mutants), Counter[str]()
    places = {}
    for mutant in mutants:
        before[mutant.package] += 1
        places[mutant.name] = before[mutant.package] / totals[mutant.package]
    return sorted((one for one in mutants if one.name not in rows), key=lambda one: places[one.name])


def _wanted(mutants: Sequence[Mutant], chosen: argparse.Namespace) -> list[Mutant]:
    if chosen.only:
        return [mutant for mutant in mutants if mutant.name in chosen.only]
    rows = results.latest(chosen.results)
    if chosen.survivors:
        return [mutant for mutant in mutants if rows.get(mutant.name, {}).get("verdict") == "survived"]
    return pending(mutants, rows)


def try_all(tree: Tree, mutants: Iterable[Mutant], file: Path, hours: float = 2.0, passes: Passes = EVERY_TEST) -> int:
    """Try these faults one after the other and append what comes of each to a file; how many survived. What survives
    a part of the tests is not recorded: the others may catch it.
    """
    begin, survived = time.monotonic(), 0
    for mutant in mutants:
        if time.monotonic() - begin > 3600.0 * hours:
            break
        started = time.monotonic()
        text = changed((tree.package / mutant.path).read_text(encoding="utf-8"), mutant.fault)
        outcome = trial(tree, TESTS[mutant.package], mutant.path, [mutant.fault.line], text, passes)
        seconds = round(time.monotonic() - started, 1)
        survived += outcome.verdict == "survived"
        print(f"{outcome.verdict:9} {seconds:6.0f} s  {mutant}  {outcome.by}", flush=True)
        if outcome.verdict != "survived" or passes == EVERY_TEST:
            results.append(file, mutant, {**outcome._asdict(), "seconds": seconds, "commit": tree.commit()})
    return survived


if __name__ == "__main__":
    raise SystemExit(main())
