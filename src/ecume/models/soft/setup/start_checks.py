"""What a start must come up to, or a scene is refused: gaps, forces that balance, spheres that something holds."""

from __future__ import annotations

import numpy as np

from ecume.engine.walls import nearest_points
from ecume.errors import Fault, SceneError
from ecume.models.soft.contacts.contact_list import neighbors, pieces, wall_gaps
from ecume.models.soft.loading.cell import Box
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import State
from ecume.units import Array
from ecume.value_texts import with_prefix

UNBALANCED = 1e-9
"""Of the largest force: what the sum of all forces may be where nothing holds the spheres."""


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


def require_one_piece(state: State) -> None:
    """Raise SceneError for spheres without drag that no film connects to the rest: their position is undetermined."""
    piece = pieces(state)
    if piece.max() > 0:
        walled = state.touching.shape[1] > 0
        alone = int(np.flatnonzero(piece != piece[-1 if walled else 0])[0])
        message = f"sphere {alone} has no film to {'any wall' if walled else 'sphere 0'}, and nothing else holds it"
        raise SceneError([Fault("particles", f"{message}; set films.cutoff higher, or hydrodynamics.drag = 'stokes'")])
