"""Contacts: films of liquid in series with elastic surfaces, between spheres and at walls.

Start with `contact`: one contact as numbers, by the laws that the scene chose, and its linear response. `films` holds
the responses of all contacts in a step, `contact_list` opens and closes contacts, `walls` contains contacts with plane
walls, and `rotation` the spins.
"""
