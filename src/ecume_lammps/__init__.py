"""LAMMPS: scenes as decks, and as an engine of runs.

Start with `decks.write_deck` and `engine.lammps_engine`. `expressible` and `tanks` contain the tables of features that
a deck can contain. Floats: `numbers` computes the numbers of a deck from a scene, `pair_tables` tabulates pair laws,
`walls` generates the commands for walls and their menisci, and `script` writes the files. Tanks: `tanks`. `process`
finds LAMMPS and runs it, and `floats_in_engine` and `tanks_in_engine` connect it to the states of the models.
"""
