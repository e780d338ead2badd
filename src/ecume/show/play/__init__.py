"""Games: a bowl or a tank in the browser, which a user can change while it is simulated.

Start with `pages.game_of`, which makes a game of a scene. `bowl` and `tank` contain the simulations and the actions of
a user; `pages` also has the server of the page, which advances the simulation with the clock.
"""
