"""The programs that make `data/` and parts of the documentation, and those that look for mistakes.

Each is run from the root of a checkout by its name, ``python -m tools.build.counts``; ``--help``
says what it can do.

- `build`: data, pages and pictures; with ``--check`` they are compared instead of written
- `witnesses`: platforms with many real solutions, searched and recorded
- `verify`: everything recorded derived again (``python -m tools.verify``), and long comparisons
- `fuzz`: random questions, as many as one likes, until a wrong answer is found
- `special`: special and nearly special platforms with their exact counts
- `oracle`: other programs, and equations that share nothing with what is solved
- `equations`: the degrees and loci of the constraints, proved again, and their equations as text
- `view`: the sources of the page of `gsp view`
"""
