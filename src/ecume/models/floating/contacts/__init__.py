"""Contacts between floats and with walls.

Start with `contact_models`, the table from which a scene chooses one row; it also has springs and dashpots in
place of impulses. `collisions` solves contacts as impulses, twice per step, also with Coulomb friction and spins.
"""
