"""The number of steps of a T1 process: the scheme of the paper, explicit steps of about eta/E = kappa t_S, and implicit
ones.

    python benchmarks/soft_steps.py [--most 300000]

Explicit runs are made where they take at most so many steps; elsewhere their number is duration over step, as the paper
would need it. A second table has the implicit steps, and the error of the duration, over the tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume.models.soft import T1, t1_process

GAPS = sized((1e-1, 1e-2, 1e-3, 1e-4, 1e-5), (1e-1,))
FORCES = sized((1e-5, 1e-4, 1e-3, 1e-2), (1e-2,))
TOLERANCES = sized((1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9), (1e-3, 1e-4))
EXPLICIT = ("paper", "rk2", "rk4")
STEP = 0.5
"""Of explicit methods, in kappa t_S: below the stability of the fastest contact, and accurate to 1e-4."""


def timed(call: Callable[[], T1]) -> tuple[T1, float]:
    """What a call gives, and its processor time (s)."""
    begin = time.process_time()
    result = call()
    return result, time.process_time() - begin


def ratios(most: int) -> None:
    """Steps and times of both ways over gap and force."""
    print("\n| gap | kappa | duration | implicit steps | s | explicit steps | ratio | runs: method, s, difference |")
    print("|---|---|---|---|---|---|---|---|")
    for gap in GAPS:
        for kappa in FORCES:
            given: dict[str, Any] = {"gap": gap, "reduced_force": kappa}
            ours, spent = timed(lambda given=given: t1_process(**given))
            steps = ours.duration / (STEP * kappa)
            ran = [explicit(method, ours, given) for method in EXPLICIT] if steps <= most else ["not run"]
            output = f"{gap:g} | {kappa:g} | {ours.duration:.6g} | {ours.steps} | {spent:.2f} | {steps:.2g}"
            print(f"| {output} | {steps / ours.steps:.2g} | {'; '.join(ran)} |", flush=True)


def explicit(method: str, ours: T1, given: dict[str, Any]) -> str:
    """One explicit run, beside ours."""
    theirs, spent = timed(lambda: t1_process(**given, method=method, time_step=STEP * given["reduced_force"]))
    return f"{method} {theirs.steps}, {spent:.2f} s, {theirs.duration / ours.duration - 1.0:+.1e}"


def tolerances() -> None:
    """Steps and errors of the implicit way over its tolerance."""
    given: dict[str, Any] = {"gap": 1e-2, "reduced_force": 1e-3}
    finest = t1_process(**given, rtol=1e-11)
    print("\n| rtol | steps | rejected | s | error of the duration |")
    print("|---|---|---|---|---|")
    for rtol in TOLERANCES:
        found, spent = timed(lambda rtol=rtol: t1_process(**given, rtol=rtol))
        error = found.duration / finest.duration - 1.0
        print(f"| {rtol:g} | {found.steps} | {found.rejected} | {spent:.2f} | {error:+.1e} |", flush=True)


def main() -> None:
    """Print both tables."""
    parser = parser_of(__doc__)
    parser.add_argument("--most", type=int, default=sized(300_000, 10_000), help="steps of an explicit run")
    asked = parser.parse_args()
    print(machine())
    t1_process(gap=0.1, reduced_force=1e-3)  # compiles
    for method in EXPLICIT:
        t1_process(gap=0.1, reduced_force=1e-2, method=method, time_step=5e-3)
    ratios(asked.most)
    tolerances()


if __name__ == "__main__":
    main()
