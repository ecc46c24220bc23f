"""Solved systems from which paths to the poses of platforms begin."""
