"""The instance file: YAML in and out; every mistake is reported with its place.

`load` and `loads` return an `Instance`, `read` and `read_text` also the warnings. `dump` and
`dumps` write one. `set_values` changes values like ``--set 1=5.2``. `sharing` and `bonds` return
the primitives that several constraints share, `out_of_proportion` lengths that differ too much.
"""

from gspcli.spec.meaning import bonds, out_of_proportion, sharing
from gspcli.spec.reading import Reading, load, loads, read, read_text
from gspcli.spec.settings import set_values
from gspcli.spec.writing import dump, dumps

__all__ = [
    "Reading",
    "bonds",
    "dump",
    "dumps",
    "load",
    "loads",
    "out_of_proportion",
    "read",
    "read_text",
    "set_values",
    "sharing",
]
