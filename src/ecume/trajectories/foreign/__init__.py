"""Particles from files of other programs: GSD, LAMMPS data, XYZ and extended XYZ.

`particles.Particles` is what each reader returns, in the units of the file; `gsd`, `lammps` and `xyz` are the readers.
They check each announced size against the file before they allocate memory.
"""
