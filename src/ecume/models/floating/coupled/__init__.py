"""Hydrodynamic interaction of floats: overdamped motion with a full mobility matrix.

`mobility` fills the matrix and multiplies by it, with the integrator, the contacts and the near field of pairs; read it
first. For more than a thousand floats no matrix is stored: `many_floats` computes its products with vectors on a grid.
"""
