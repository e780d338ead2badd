"""Contacts between floats and with walls.

Start with `contact_models`, the table from which a scene chooses one row. `collisions` solves contacts as impulses,
twice per step, also with Coulomb friction and spins, and `springs` replaces impulses by springs and dashpots.
"""
