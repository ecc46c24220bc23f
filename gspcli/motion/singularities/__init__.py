"""Where poses stop being regular: clearances, folds, the discriminant, scans."""
