"""Pictures of runs: movies, figures, interactive pages, and games.

Start with the tables by model: `movies.FILMS` (the `picture.Picture` that a movie shows), `figures.FIGURES` (what
`ecume plot` draws), `view.scenery.STAGES` (the page) and `play.pages.TOYS` (games). `floating`, `soft`, `sph` and
`tracers` draw their model; `style`, `picture` and `tank` are shared.
"""
