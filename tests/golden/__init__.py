"""Runs of each version, stopped halfway, which later versions open and resume, or refuse with a reason."""
