"""Instance files in YAML, in and out."""
