"""Decks for LAMMPS: a scene as an input script with its data file and tables.

Start with `decks.write_deck`. `expressible` is the table of what a deck can contain, `numbers` computes the numbers of
a deck from a scene, `pair_tables` tabulates pair laws, `walls` holds walls and their menisci as commands, and `script`,
`data_file` and `readme` write the files.
"""
