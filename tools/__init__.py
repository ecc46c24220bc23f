"""The programs that make `data/`, and other programs' counts and equations as evidence.

Each is run from the root of a checkout by its name, ``python -m tools.data.constraints``; with
``--check`` it compares instead of writing.

- `data`: makers of the files in `data/`
- `equations`: the degrees and loci of the constraints, proved again, and their equations as text
- `oracle`: Singular, msolve, and equations that share nothing with what is solved
- `verify`: everything recorded derived again, or a sample of it
"""
