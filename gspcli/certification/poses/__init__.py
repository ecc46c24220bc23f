"""Proofs of poses: that they exist, are simple, are real, are different."""
