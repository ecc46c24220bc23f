"""Paths from pose to pose that are proved on the whole way, and proofs that there is none."""
