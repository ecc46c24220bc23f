"""Proofs that poses exist, are simple, are real and are different."""
