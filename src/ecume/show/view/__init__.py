"""The page of a run: one HTML file that plays it in any browser, without a server or a network.

Start with `page.save_page`, which writes it. `page` also shows frames in a notebook, and serves a run in progress.
`chunks` packs frames, `scenery` describes what is around the particles.
"""

from ecume.show.view.page import save_page

__all__ = ["save_page"]
