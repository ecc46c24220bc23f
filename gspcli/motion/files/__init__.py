"""Poses and values in files and on the command line."""
