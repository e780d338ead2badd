"""Floats with hydrodynamic interaction: each float moves the others by the flow of the liquid.

Start with `hydrodynamics`, the integrator and the contacts. `mobility` has the mobility as an operator: of single
floats, as a matrix, or for more than a thousand floats by products on the grid of `many_floats`.
"""
