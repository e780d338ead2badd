"""What an MPI rank knows of the others: its number, its share of the particles, and how arrays are gathered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers


class Share(NamedTuple):
    """The rank of this process, and its communicator."""

    rank: int
    ranks: int
    gather: Callable[[Any, Integers], None]
    """gather(row, bounds): fill in the others' parts of a row; part k reaches from bounds[k] up to bounds[k + 1]"""

    def parts(self, count: int) -> Integers:
        """The offsets of the ranks' parts of so many items, and the end."""
        return np.arange(self.ranks + 1) * count // self.ranks
