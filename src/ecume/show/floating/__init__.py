"""How the floating model is shown."""
