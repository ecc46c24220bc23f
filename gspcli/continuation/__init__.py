"""Homotopies on the Study quadric: all solutions of six quadrics or products of quadrics.

This room contains no words of platforms. Its public modules:

- `quadrics`: coefficients of the functions 1, R, T, U, T x R, T.T; the five spaces.
- `systems`: `Structure` and `System`, the equations to solve.
- `parameter_homotopy`: `follow`, from the solutions of one system to those of another.
- `solve`: `solve_systems`, which yields `SystemSolutions`.
"""
