"""Parameters and initial state from a scene.

Start with `building`, which makes the parameters. `choices` resolves the scene's liquid and methods, with their
defaults; `shapes` converts regions and solids to points, `walls_and_bodies` makes everything that confines the liquid,
and `initial_particles` places the liquid. Only this package and `report` read scenes: compiled loops do not depend on
it.
"""
