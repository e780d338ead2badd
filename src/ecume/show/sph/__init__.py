"""Pictures and figures of liquids made of particles.

Start with `picture.liquid_picture`, the entry in `FILMS`, and with `figures`, the table of figures. `liquid` makes a
continuous region of particles and draws it in 2D, `water` in 3D, with moving bodies and sides.
"""
