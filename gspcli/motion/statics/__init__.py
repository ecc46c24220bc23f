"""Screws, forces, stiffness and accuracy at a pose."""
