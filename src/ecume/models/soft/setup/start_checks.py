"""What a start must come up to, or a scene is refused: gaps, forces that balance, spheres that something holds."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine.walls import nearest_points
from ecume.errors import Fault, SceneError
from ecume.models.soft.contacts.contact_list import neighbors, wall_gaps
from ecume.models.soft.contacts.pieces import UNBALANCED, loose_spheres, pieces
from ecume.models.soft.loading.cell import Box
from ecume.models.soft.loading.protocol import LOAD, SCALE, drive_at
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import State
from ecume.units import Array
from ecume.value_texts import with_prefix

MOST_FORCE = 2.0
"""Over modulus and radius squared: it deflects a surface by more than a radius."""
MOST_FILLED = 1.5
"""The largest volume fraction, of undeformed spheres."""


def require_balance(parameters: Parameters) -> None:
    """Forces that nothing balances would push all spheres away together."""
    if parameters.drag.any() or len(parameters.walls.modulus):
        return
    force = parameters.force + parameters.weight
    total, largest = np.abs(force.sum(axis=0)).max(), np.abs(force).max()
    if total > UNBALANCED * largest * len(force):
        raise SceneError(
            [
                Fault(
                    "particles",
                    f"the forces on all spheres sum to {with_prefix(total, 'N', 3)}, and nothing holds them; "
                    "expected a sum of zero, walls, or hydrodynamics.drag = 'stokes'",
                )
            ]
        )


def require_no_torque(parameters: Parameters, state: State) -> None:
    """Spinning spheres that nothing holds would be turned all together without resistance."""
    if parameters.torque.shape[1] == 0 or parameters.box.any() or len(parameters.walls.modulus):
        return
    arm, force = np.zeros((2, len(state.position), 3))
    arm[:, : parameters.dimensions], force[:, : parameters.dimensions] = state.position, parameters.force
    own = parameters.torque * parameters.radius[:, None]
    moment = np.cross(arm - arm.mean(axis=0), force)[:, -own.shape[1] :] + own
    total, largest = np.abs(moment.sum(axis=0)).max(), np.abs(moment).max()
    size = np.abs(parameters.force).max() * parameters.radius.max()
    if total > UNBALANCED * max(largest, size) * len(moment):
        cause = f"the total torque on all spheres is {with_prefix(total, 'N m', 3)}, and nothing balances it"
        raise SceneError([Fault("particles", f"{cause}; expected 0, or hydrodynamics.drag = 'stokes'")])


def require_gaps(parameters: Parameters, position: Array, box: Box) -> None:
    """Undeformed spheres that overlap have no film between them."""
    touching = parameters._replace(contacts=parameters.contacts._replace(fade_from=0.0))
    pair, _, between = neighbors(touching, position, box)
    if len(pair):
        first, second = pair[0]
        overlap = with_prefix(parameters.radius[pair[0]].sum() - np.linalg.norm(between[0]), "m", 3)
        message = f"spheres {first} and {second} overlap by {overlap} before they are deformed"
        raise SceneError([Fault("particles", f"{message}; expected a gap for the film")])
    gap = wall_gaps(parameters, position, nearest_points(parameters.walls.surfaces))
    if not (gap > 0.0).all():
        sphere, wall = (int(index[0]) for index in np.nonzero(~(gap > 0.0)))
        message = f"sphere {sphere} is in wall {wall} or beyond it; expected a gap for the film"
        raise SceneError([Fault("particles", message)])


def require_hold(parameters: Parameters, state: State) -> None:
    """Raise SceneError for spheres without drag that something pulls at and no film connects to the rest."""
    _, pulled = loose_spheres(parameters, state)
    if len(pulled):
        walled = state.touching.shape[1] > 0
        piece = pieces(state)
        others = [one for one in pulled if walled or piece[one] != piece[0]]
        alone = int((others or pulled)[0])
        message = f"sphere {alone} has no film to {'any wall' if walled else 'sphere 0'}, and nothing else holds it"
        raise SceneError([Fault("particles", f"{message}; set films.cutoff higher, or hydrodynamics.drag = 'stokes'")])


def require_moderate_forces(parameters: Parameters) -> None:
    """Raise SceneError for external forces that would deflect a surface by more than a radius."""
    load = float(np.abs(parameters.protocol.courses[:, LOAD, 0]).max())
    forces = {"particles": load * parameters.force, "gravity": parameters.weight}
    for path, force in forces.items():
        part = np.sqrt((force**2).sum(axis=1)) / (parameters.modulus * parameters.radius**2)
        sphere = int(np.argmax(part))
        if part[sphere] > MOST_FORCE:
            size = with_prefix(float(np.linalg.norm(force[sphere])), "N", 3)
            most = with_prefix(float(MOST_FORCE * parameters.modulus[sphere] * parameters.radius[sphere] ** 2), "N", 3)
            message = f"a force of {size} on sphere {sphere} would deflect its surface by more than a radius"
            raise SceneError([Fault(path, f"{message}; expected at most {most}, twice the modulus times radius^2")])


def fillings(parameters: Parameters) -> float:
    """The largest volume fraction of the protocol, if it prescribes the size of the box; 0 without a box."""
    box, dimensions = parameters.box[: parameters.dimensions], parameters.dimensions
    if not box.all():
        return 0.0
    unit, power = (math.pi, 2) if dimensions == 2 else (4.0 / 3.0 * math.pi, 3)
    times = parameters.protocol.times
    scale = min(drive_at(parameters.protocol, float(time)).scale for time in times)
    return float(unit * (parameters.radius**power).sum() / np.prod(box) / scale**dimensions)


def require_room(parameters: Parameters) -> None:
    """Raise SceneError for boxes into which spheres do not fit, however they are deformed."""
    filled = fillings(parameters)
    if filled > MOST_FILLED:
        path = "protocol" if parameters.protocol.courses[:, SCALE, 0].min() < 1.0 else "cell.size"
        message = f"spheres would fill {filled:.3g} times the cell; expected at most {MOST_FILLED:g} times"
        raise SceneError([Fault(path, message)])
