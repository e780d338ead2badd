"""Pictures and figures of soft spheres.

Start with `packing.soft_picture`, the entry in `FILMS`, and with `figures`, the table of figures. `packing` draws a
layer with its films and forces, `measures` draws measured quantities of sheared packings.
"""
