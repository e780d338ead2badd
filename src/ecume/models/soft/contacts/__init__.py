"""Contacts: films of liquid in series with surfaces that yield, between spheres and at walls.

Start with `contact`: one contact as numbers, by the laws that the scene chose, and how it answers small
changes. `films` does that for all contacts within a step, `contact_list` opens and closes them, `walls` holds
contacts with plane walls, and `rotation` lets spheres spin.
"""
