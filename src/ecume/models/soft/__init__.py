"""Soft spheres close to contact in a viscous liquid, without inertia: Soft Dynamics [rognon2009].

Start with `record`, the functions that a run calls, and `state`. `contacts` contains films and surfaces, `integration`
the implicit time steps, `cell` the box and `protocol` its loading, `setup` the parameters and the initial state,
`report` frames and the energy budget, and `t1` the process of four spheres that the papers study.
"""

from ecume.models.soft.record import SOFT
from ecume.models.soft.t1 import T1, t1_process

__all__ = ["SOFT", "T1", "t1_process"]
