"""Equations, varieties and triangular sets, derived in sympy."""
