"""Benchmarks of gsp against other polynomial solvers: `python -m bench --help`."""
