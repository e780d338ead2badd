"""Floats that move one another by the flow of the liquid.

`mobility` has the mobility as an operator: of each float by itself, as a matrix, or for more than a thousand floats by
products on the grid of `many_floats`. `hydrodynamics` has the integrator and the contacts, for all of them; read it
first.
"""
