"""Parameters and initial state from a scene.

Start with `scene_parameters`. `kinds` computes equilibrium, charge, mass and drag of each kind of float, and
`initial_state` places the floats.
"""
