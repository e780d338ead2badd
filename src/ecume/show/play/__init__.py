"""A bowl in the browser, played with while it is simulated."""
