"""Homotopies on the Study quadric: all solutions of six quadrics or products of quadrics.

The engine knows no platform words. Its public face:

- `quadrics`: coefficients of the functions 1, R, T, U, T x R, T.T; the five families.
- `systems`: `Structure` and `TargetSystem`, what is to be solved.
- `solve`: `solve_system` and `solve_systems`, which return `SystemSolutions`.
"""
