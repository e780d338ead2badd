"""Analysis: plain functions from frames and arrays to numbers.

Of floats and packings: `clusters` (also their topologies), `structure`, `close_pairs` (also coordination),
`rearrangements` (T1 events, non-affine motion), `layers` (profiles across a cell), `rheology` and `transients`. Of
tracers: `dispersion` (also residence and deposits). Of liquids: `gauges`, `grids` (also profiles), `pressures`,
`free_surface` and `energies`. `series`, `boxes` (also sheared ones) and `curves` serve all of them. Start with
`series`: one number per frame.
"""
