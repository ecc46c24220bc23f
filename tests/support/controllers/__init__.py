"""Exported controllers compiled and called: what verification, benchmarks and tests measure."""
