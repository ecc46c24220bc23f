"""Singular poses: clearances from them, folds, the discriminant, scans."""
