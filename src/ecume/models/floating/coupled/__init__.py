"""Hydrodynamic interaction of floats: overdamped motion with a full mobility matrix.

`mobility` fills the matrix and multiplies by it, with the integrator, the contacts and the near field of pairs (read
first). More than a thousand floats have no matrix: `many_floats` computes products with it on a grid.
"""
