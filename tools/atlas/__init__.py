"""The evidence for the generic counts: Gröbner bases, tracked paths, trace tests."""
