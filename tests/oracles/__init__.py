"""Exact solutions and closed forms that tests compare with, and the package does not need."""
