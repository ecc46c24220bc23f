"""Proofs that approximate poses are solutions, in ball arithmetic (python-flint, only here)."""
