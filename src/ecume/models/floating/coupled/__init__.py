"""Floats that move one another by the flow of the liquid: overdamped motion with a full mobility matrix.

`mobility` fills the matrix and multiplies by it, with the integrator and the contacts (read first), and `films` adds
the near field of pairs. More than a thousand floats have no matrix: `many_floats` computes products with it on a grid.
"""
