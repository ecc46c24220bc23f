"""Certify the platforms of `data/witnesses/` again: their real poses are proved to exist.

    python -m tools.data.witnesses --check [--sample N] [--jobs N]

``real.csv`` has a platform with many real poses for each family, ``counts.csv`` one for each number
of real poses that occurs. docs/verification.md names the programs that found them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from gspcli.catalogue.counts import (
    PlaceOnLine,
    Witness,
    family_counts,
    platform_at,
    recorded,
    recorded_real_counts,
)
from gspcli.catalogue.kinds import ALL
from gspcli.catalogue.types import CONSTRAINTS, Family
from gspcli.geometry.instance import Instance
from gspcli.reality.witness_proofs import certified_real, witness_instance
from gspcli.resources import data_json, data_path
from tools.recording import add_workers, parser, report, sampled, sha256, workers_of

#: The files with their manifests.
FILES = {"real.csv": "manifest.json", "counts.csv": "counts.manifest.json"}
Record = Witness | tuple[Family, PlaceOnLine]


def records() -> list[Record]:
    """Return the rows of both files."""
    places = [(family, place) for family, row in recorded_real_counts() for place in row]
    return [*recorded(), *places]


def instance_of(found: Witness) -> Instance:
    """Return the platform of a witness, its angles those of lines."""
    return witness_instance(found, (ALL,) * (CONSTRAINTS - len(found.family.distances)))


def wrong(record: Record) -> str:
    """Return what is wrong with a record, after solving and certifying the platform again."""
    if isinstance(record, Witness):
        name, recorded = record.family.id, record.real
        real = certified_real(instance_of(record), recorded)
        good = recorded <= real <= family_counts(record.family).two_sided
    else:
        family, place = record
        name, recorded = family.id, place.real
        real = certified_real(instance_of(platform_at(family, place)))
        good = real == recorded
    return "" if good else f"{name}: {recorded} recorded, {real} certified"


def other_files() -> Iterator[str]:
    """Yield the files that are not those of their manifests."""
    for file, manifest in FILES.items():
        content = data_path("witnesses", file).read_bytes()
        if data_json("witnesses", manifest)["sha256"][file] != sha256(content):
            yield f"{file} is not the file of the manifest"


def main() -> int:
    """Certify the records; return the exit code."""
    options = parser(__doc__, sample=True)
    add_workers(options)
    arguments = options.parse_args()
    every = records()
    chosen = sampled(every, arguments.sample)
    found = workers_of(arguments).in_order(wrong, chosen)
    text = f"{len(chosen)} of {len(every)} platforms, real poses certified"
    return report([*other_files(), *filter(None, found)], text)


if __name__ == "__main__":
    sys.exit(main())
