"""The invariants of a run: checked in each frame, summarized in a line, and recorded beside the run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ecume.errors import Diverged
from ecume.models.invariants import DISSIPATED, ENERGY, INJECTED, NUMERICAL, Invariant, NumberHistory, Numbers, with_own
from ecume.run.directory import RunDirectory, read, write
from ecume.run.scalars import lines_of
from ecume.trajectories.records import WATCH

POLICIES = ("warn", "stop")
"""Reactions to an invariant that a run violates."""
BROKEN = "broken"
WORKS = "injected", "dissipated"
BY_METHOD = "by the numerical method"


class Verdict(NamedTuple):
    """The state of an invariant: its largest value so far, and the time."""

    name: str
    says: str
    limit: float
    worst: float
    time: float

    @property
    def held(self) -> bool:
        """Whether the largest value is within the limit; false for NaN."""
        return self.worst <= self.limit


class Watch:
    """The monitor of the invariants of a run. It starts with the frames on disk, so that a resumed run includes
    them.
    """

    def __init__(self, home: RunDirectory, invariants: Sequence[Invariant], policy: str) -> None:
        self._home, self._invariants, self._policy = home, list(invariants), policy
        self._seen: NumberHistory | None = None
        self._time = 0.0
        self._unit = "J"
        self._worst = {one.name: (-math.inf, 0.0) for one in invariants}
        for line in lines_of(home):
            self._take(line["time"], line)

    def take(
        self, time: float, numbers: Mapping[str, float], step: int, units: Mapping[str, str] | None = None
    ) -> list[Verdict]:
        """Check a frame; return the invariants that are violated for the first time. Raises Diverged if this stops the
        run.
        """
        self._unit = (units or {}).get("total_energy", self._unit)
        before = {one.name for one in self.verdicts() if not one.held}
        self._take(time, {**numbers, "step": float(step)})
        broken = [one for one in self.verdicts() if not one.held and one.name not in before]
        if broken and self._policy == "stop":
            raise Diverged(
                f"{'; '.join(map(sentence, broken))}. Use shorter steps, or continue with --on-violation warn"
            )
        return broken

    def _take(self, time: float, given: Mapping[str, float | None]) -> None:
        now = with_own({name: math.nan if value is None else float(value) for name, value in given.items()})
        first, least, largest = (self._seen.first, self._seen.least, self._seen.largest) if self._seen else (now,) * 3
        least = {name: min(least.get(name, value), value) for name, value in now.items()}
        largest = {name: max(largest.get(name, value), value) for name, value in now.items()}
        self._seen, self._time = NumberHistory(first, now, least, largest), time
        for one in self._invariants:
            value = one.value(self._seen)
            worst = self._worst[one.name][0]
            if math.isnan(value) or value > worst:
                self._worst[one.name] = (value, time)

    def verdicts(self) -> list[Verdict]:
        """The state of each invariant."""
        return [Verdict(one.name, one.says, one.limit, *self._worst[one.name]) for one in self._invariants]

    def keep(self) -> None:
        """Write the state of all invariants, and the energy budget, into the run directory."""
        report: dict[str, Any] = {"until": self._time, "policy": self._policy}
        report["invariants"] = [
            {**one._asdict(), "worst": _number(one.worst), "held": one.held} for one in self.verdicts()
        ]
        if self._seen is not None and "total_energy" in self._seen.now:
            report["energy_unit"] = self._unit
            report["energy"] = budget(self._seen.first, self._seen.now, closed=ENERGY in self._worst)
        write(self._home, self._home.watch, report)


def budget(first: Numbers, now: Numbers, *, closed: bool) -> dict[str, float | None]:
    """The energy budget (J; in 2D tanks J/m). Initial and injected energy that is no longer present was dissipated,
    unless the energy budget already includes dissipation. A part of the injected energy may be that of the numerical
    method.

    If a driven system has no energy budget, only the difference of injected and dissipated energy is known.
    """
    change = now["total_energy"] - first["total_energy"]
    injected = now.get(INJECTED, 0.0) - first.get(INJECTED, 0.0)
    lost = now[DISSIPATED] - first.get(DISSIPATED, 0.0) if DISSIPATED in now else injected - change
    apart = (injected, lost) if closed else (None, None)
    by_method = {BY_METHOD: now[NUMERICAL] - first.get(NUMERICAL, 0.0)} if NUMERICAL in now else {}
    report = {"at the start": first["total_energy"], "now": now["total_energy"], "change": change}
    return report | by_method | dict(zip(WORKS, apart, strict=True))


def sentence(one: Verdict) -> str:
    """The text `energy: its rise ... is 0.2, more than 0.001, at t = 3 s`."""
    return f"{one.name}: {one.says}, is {one.worst:.3g}, more than {one.limit:g}, at t = {one.time:.6g} s"


def summary_line(home: RunDirectory) -> str:
    """A line with the invariants that were satisfied, and the injected work; empty for a run without records of
    invariants.
    """
    if not home.watch.exists():
        return ""
    kept = read(home, home.watch, WATCH)
    rows, work = kept.get("invariants", []), _work(kept.get("energy", {}), kept.get("energy_unit", "J"))
    broken = [
        f"{row['name']} ({_shown(row['worst'])}, limit {row['limit']:g}: {row['says']})"
        for row in rows
        if not row["held"]
    ]
    if broken:
        return f"{BROKEN}: {', '.join(broken)}{work}"
    held = ", ".join(f"{row['name']} ({_shown(row['worst'])} of {row['limit']:g})" for row in rows)
    return f"held: {held}{work}" if rows else ""


def _work(energy: Mapping[str, float | None], unit: str) -> str:
    """The text `; injected 3e-06 J (1e-06 J by the numerical method), dissipated 2e-06 J`, as far as these are
    known.
    """
    known = [f"{name} {energy[name]:.3g} {unit}" for name in WORKS if energy.get(name) is not None]
    part = energy.get(BY_METHOD)
    if known and part is not None and energy.get(WORKS[0]) is not None:
        known[0] += f" ({part:.3g} {unit} {BY_METHOD})"
    return f"; {', '.join(known)}" if known else ""


def _shown(worst: float | None) -> str:
    return "no number" if worst is None else f"{worst:.3g}"


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
