"""Pictures of runs: movies, figures, interactive pages, and games.

Start with the tables by model: `movies.FILMS` (the `picture.Picture` that a movie shows), `figures.FIGURES` (the
figures of `ecume plot`), `view.scenery.STAGES` (the page) and `play.pages.TOYS` (games). `floating`, `soft`, `sph` and
`tracers` draw these models; `style`, `picture` and `tank` are common to all.
"""
