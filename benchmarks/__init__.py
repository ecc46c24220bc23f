"""Benchmarks of gsp against other polynomial solvers: `python -m benchmarks --help`."""

import os

# One thread for every library that would take more, here and in all processes that are started:
# threads for products of small matrices wait for each other, and their waiting counts as processor
# time. Libraries read this when they are loaded.
os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")})
