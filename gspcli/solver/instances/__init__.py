"""Platforms to begin with."""
