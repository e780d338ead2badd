"""Floats that move one another by the flow of the liquid: overdamped motion with a full mobility matrix.

`mobility` fills the matrix and multiplies by it (read first), `motion` is the integrator, `contacts` solves contacts
and friction, `films` adds the near field of pairs. More than a thousand floats have no matrix: `flow_grid` computes
products with it, and `many_floats` is the integrator and the contacts.
"""
