"""The number of solutions that can be real: sampling, and a search for platforms with many."""
