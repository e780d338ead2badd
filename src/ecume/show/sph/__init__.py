"""Pictures and figures of liquids made of particles.

`picture.liquid_picture` is the entry in `FILMS`, `figures` the table of figures; start there. `solids` draws moving
bodies and sides, `rendering` draws liquids in 3D with PyVista, an optional extra.
"""
