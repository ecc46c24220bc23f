"""Generalized Stewart platforms: classify all 3850 types, bound and find their assembly modes."""

__version__ = "0.1.0"
