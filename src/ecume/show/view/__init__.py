"""One HTML file that plays a run in any browser: no server, no network, nothing to install."""

from ecume.show.view.page import save_page

__all__ = ["save_page"]
