"""Homotopies on the Study quadric: all solutions of six quadrics or products of quadrics.

Nothing here knows platforms. Read `quadrics` (coefficients of 1, R, T, U, T x R, T.T; the five
spaces), `systems` (the equations), `tracker`, then `tracked_paths` (all solutions of systems).
"""
