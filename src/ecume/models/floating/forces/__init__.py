"""Forces between floats and on them.

Start with `interactions`, the table of forces that a scene combines. `pair_forces` has the loop over pairs of a pair
law, `ewald_grid` the sum of long-range forces, `multipoles` many-body forces, `magnets` magnetic forces, `films` the
lubrication between floats, and `flow_and_noise` the flow of the surface, thermal noise and moving dishes.
"""
