"""Pictures and figures of liquids made of particles."""
