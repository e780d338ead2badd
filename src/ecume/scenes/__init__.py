"""Scenes: the description of a simulation, read and checked without compiling anything.

Start with `load.load_scene`, which reads a TOML file (`toml`, `overrides`) or reports all its faults at once (`faults`,
`valid_part`), and with `schema.SCENES`, the table of scenes by model. `floating`, `soft`, `sph` and `tracers` contain
the scenes of the models, `common` and `quantities` their common parts. `tables` reads particles from tables, `starts`
those of other runs and programs, and `templates` copies scenes of the package. `writing` converts Python objects to
scenes, and scenes to files.
"""
