"""Particles from files of other programs: GSD, LAMMPS data and dumps, DCD, XYZ and extended XYZ.

`particles.Particles` is what each reader returns, in the units of the file; `gsd`, `lammps` (data files), `dumps`,
`dcd` and `xyz` are the readers.
They check each announced size against the file before they allocate memory.
"""
