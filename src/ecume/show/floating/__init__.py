"""Pictures of the floating model."""
