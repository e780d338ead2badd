"""Numerical methods without physics, shared by the models.

Neighbor search (`cells` with images at borders, `neighbors`, `neighbor_rows`), contacts of rigid bodies (`contact`),
linear systems (`linear_solvers`), walls and solids, placement of particles at random, grids (`interpolation`). Start
reading with `cells`.
"""
