"""Runs of each version, stopped half-way: later versions open them and go on with them, or say why not."""
