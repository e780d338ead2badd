"""Numerics without physics: what models share and what would be the same for other laws.

Neighbor search (`cells` with images at borders, `neighbors`, `neighbor_rows`), contacts of rigid bodies (`contact`),
linear systems (`linear_solvers`), walls and solids, placement of particles at random, grids (`interpolation`). Start
reading with `cells`.
"""
