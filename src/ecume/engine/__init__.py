"""Numerics without physics: what models share and what would be the same for other laws.

Neighbor search (`cells`, `neighbors`, `neighbor_rows`, `boundary_images`), contacts of rigid bodies (`contact`), linear
systems (`linear_solvers`), walls and solids, placement of particles at random, grids for Ewald sums (`grid_splines`).
Start reading with `cells`.
"""
