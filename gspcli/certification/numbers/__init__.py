"""Balls, doubled numbers and rounding: the arithmetic of proofs."""
