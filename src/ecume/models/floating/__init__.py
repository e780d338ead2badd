"""Floats on a liquid surface: the Cheerios effect.

Start with `record`, the functions that a run calls, and with `parameters` (also the state). `forces` has the forces
between floats, `contacts` collisions and friction, `time_integration` the time step, `setup` computes parameters and
the initial state from a scene, `frames` and `check_report` contain the output, `dishes` the shapes of dishes and
menisci at their walls, and `shaped` floats that are not round. `options` states which parts can be combined, and
`user_laws` adds pair laws of the user.
"""

from ecume.models.floating.parameters import PairParameters
from ecume.models.floating.record import FLOATING

__all__ = ["FLOATING", "PairParameters"]
