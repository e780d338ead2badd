"""Floats that are longer than wide, or have corners: charges inside their contact lines, contacts that turn."""
