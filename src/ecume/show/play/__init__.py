"""Games: a bowl or a tank in the browser, played with while it is simulated.

`pages.game_of` makes a game of a scene; start there. `bowl` and `tank` are the simulations and what a user can do to
them; `pages` also has the server that answers the page and drives the clock.
"""
