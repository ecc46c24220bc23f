"""Gaps between legs and bodies."""
