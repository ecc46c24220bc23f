"""How many solutions can be real: sampling, and a search for many; why none of a platform is."""
