"""How the soft model is shown."""
