"""Time integration: implicit Runge-Kutta stages, each solved by Newton's method for all spheres at once.

Start with `time_stepping`, which chooses the length of steps, then `dirk` (the stages of a step; coefficients in
`dirk_schemes`) and `newton` (also forces and the matrix). `bordered_system` adds the unknowns that all spheres share (a
box or walls controlled by stresses), and `linear_solvers` chooses how the system is solved.
"""
