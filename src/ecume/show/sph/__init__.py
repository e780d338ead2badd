"""Pictures and figures of liquids made of particles.

`picture.liquid_picture` is the entry in `FILMS`, `figures` the table of figures; start there. `solids` draws moving
bodies and sides, `kernel_sum` makes a continuous region of particles, `liquid` draws it in 2D, `water` in 3D.
"""
