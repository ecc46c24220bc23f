"""The paper's tables, examples and errata, recomputed."""
