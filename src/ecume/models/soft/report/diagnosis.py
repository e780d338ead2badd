"""The reason why a run of soft spheres ends: the sphere or contact, the time, and the remedy."""

from __future__ import annotations

import numpy as np

from ecume._portable import exp
from ecume.models.diagnosis import DEEP, first_broken
from ecume.models.soft.contacts.tree_search import box_in
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import interval_at, rules_at
from ecume.models.soft.report.balance_report import remedies, unborne
from ecume.models.soft.report.observation import deflections, remedy, worst_contact
from ecume.models.soft.state import ACCEPTED, CLOCK, LENGTH, State
from ecume.units import with_prefix

ATOM = 1e-10
"""The size of an atom (m)."""


def thinnest(state: State) -> float:
    """The narrowest gap between spheres (m); infinite without films."""
    return float(exp(state.log_gap[: state.contacts[0]]).min(initial=np.inf))


def diagnosis(parameters: Parameters, state: State) -> str:
    """The message on the sphere that left the range of validity, with the time and the remedy."""
    when = f"at t = {state.pace[CLOCK]:.6g} s (step {state.tally[ACCEPTED]})"
    broken = first_broken({"position": state.position, "velocity": state.velocity, "spin": state.spin})
    report = f"sphere {broken.particle} has no finite {broken.term} any more" if broken else _closest(parameters, state)
    found = deflections(parameters, state)
    rules = rules_at(parameters.protocol, interval_at(parameters.protocol, float(state.pace[CLOCK])))
    if not broken and (cause := unborne(parameters, state, rules)):
        return f"{when} no step is short enough; {cause}"
    if broken or not np.isfinite(found.magnitude).all():
        cure = "look for forces that the surfaces cannot balance, or set integration.tolerance lower"
    else:
        report = "; ".join(filter(None, (report, worst_contact(found))))
        cure = remedy(found, parameters.contacts)
    if any(rules) and not parameters.drag.any():
        cure += f"; a packing too loose for its stress: {remedies(parameters)}"
    if thinnest(state) < ATOM and not parameters.laws.remote.acts:
        cure += "; films have thinned to less than an atom: a long_range_forces.law keeps them open"
    return f"{when} no step is short enough, {state.pace[LENGTH]:.3g} s neither; {report}: {cure}"


def _closest(parameters: Parameters, state: State) -> str:
    """The film with an invalid gap, the overlapping spheres, or the smallest gap."""
    contacts, box = int(state.contacts[0]), box_in(parameters, state)
    if contacts == 0:
        return "no sphere has a film with another"
    pair, image = state.pair[:contacts], state.image[:contacts]
    with np.errstate(over="ignore"):
        gap = exp(state.log_gap[:contacts])
    between = state.position[pair[:, 1]] - state.position[pair[:, 0]] + image * box.sides
    between[:, 0] += box.tilt * image[:, 1]
    depth = parameters.radius[pair].sum(axis=1) - np.linalg.norm(between, axis=1)
    none, deepest = first_broken({"gap": gap}), int(np.argmax(depth))
    if none is None and depth[deepest] > DEEP * parameters.radius.min():
        return f"spheres {pair[deepest, 0]} and {pair[deepest, 1]} overlap by {with_prefix(depth[deepest], 'm', 3)}"
    at = int(np.argmin(gap)) if none is None else none.particle
    what = (
        f"the narrowest gap, {with_prefix(gap[at], 'm', 3)}, is" if none is None else "there is no finite gap any more"
    )
    return f"{what} between spheres {pair[at, 0]} and {pair[at, 1]}"
