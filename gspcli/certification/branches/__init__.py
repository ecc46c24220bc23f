"""Proofs of branches: arcs, folds, Taylor polynomials and cones, for poses that move."""
