"""Pictures and figures of liquids made of particles.

`picture.liquid_picture` is the entry in `FILMS`, `figures` the table of figures; start there. `liquid` makes a
continuous region of particles and draws it in 2D, `water` in 3D, with moving bodies and sides.
"""
