"""Pictures and figures of soft spheres.

`packing.soft_picture` is the entry in `FILMS`, `figures` the table of figures; start there. `packing` draws a layer
with its films and forces, `measures` draws what is measured in sheared packings.
"""
