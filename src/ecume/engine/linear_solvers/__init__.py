"""Linear systems of many particles: a sparse matrix of small blocks, one per particle and one per pair of neighbors.

`block_matrix` contains pattern and blocks, `solvers` the table of solvers and the comparison of their costs: BiCGStab
with symmetric Gauss-Seidel preconditioning (`bicgstab`), SuperLU along a nested dissection (`sparse_lu`), CHOLMOD as an
option, and dense elimination for a few particles. Start reading with `block_matrix`, then `solvers`.
"""
