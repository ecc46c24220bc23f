"""How many solutions can be real: sampling, and a search for platforms with many."""
