"""The evaluation of a sum over neighbors from filled fields."""

from __future__ import annotations

import numpy as np

from ecume.engine.vectors import VECTORS
from ecume.models.sph.fields import Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.kernel_loops import kernel_type
from ecume.models.sph.rates.neighbor_sums import NeighborSum, fill_records
from ecume.models.sph.state import Workspace


def evaluate_sum(
    taken: NeighborSum, parameters: Parameters, workspace: Workspace, target: Floats | None = None,
    settings: tuple[float, ...] = (),
) -> None:  # fmt: skip
    """Evaluate a sum for all particles of the liquid, from filled fields, into the target: by default the rates."""
    fields, constants = workspace.fields.table, parameters.constants
    if workspace.records.shape[1] < len(taken.rows):
        workspace.records = np.zeros((fields.shape[1], len(taken.rows)), fields.dtype)
    fill_records(fields, workspace.records, taken.rows, taken.signed)
    taken.loop(
        workspace.rates.table if target is None else target, fields, workspace.records, fields[taken.ninth],
        workspace.lists, constants, kernel_type(constants), VECTORS[parameters.dimension], settings,
    )  # fmt: skip
