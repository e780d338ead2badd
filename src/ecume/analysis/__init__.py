"""Analysis: plain functions from frames and arrays to numbers.

For floats and packings: `clusters` (also their topologies), `structure`, `close_pairs` (also coordination),
`rearrangements` (T1 events, non-affine motion), `layers` (profiles across a cell), `rheology` and `transients`. For
tracers: `dispersion` (also residence and deposits). For liquids: `gauges`, `grids` (also profiles), `pressures`,
`free_surface` and `energies`. `series`, `boxes` (also sheared ones) and `curves` are for all models. Start with
`series`: one number per frame.
"""
