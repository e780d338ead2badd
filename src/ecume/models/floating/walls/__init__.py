"""The walls of a dish.

`shapes` holds `SHAPES`, the table of shapes that a dish can have; it is the place to start and to add one. `menisci`
holds what the liquid at the walls does to floats: the laws that compiled code follows, their strengths and tables.
"""
