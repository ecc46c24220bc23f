"""Proofs about poses that move: branches, folds, Taylor polynomials and cones."""
