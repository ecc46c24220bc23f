"""Build and check `data/witnesses/counts.csv`: which numbers of real solutions occur.

    python -m tools.witnesses.counts build [--most SOLUTIONS] [--minutes N]
    python -m tools.witnesses.counts check [--sample N]

`build` goes along straight lines from random platforms to the best witness of each family with at
most this many solutions (`data/witnesses/real.csv`, to be written first). It halves a line where a
number is missing between two platforms, and certifies the real poses of each platform that it
records. It keeps those records that are right with the best witness of today. `check` certifies
every recorded_real_counts platform again; it exits with 1 if a number differs.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

from gspcli.catalogue.counts import (
    PlaceOnLine,
    all_families,
    best_real,
    family_counts,
    mirrored,
    platform_at,
    recorded_real_counts,
)
from gspcli.catalogue.kinds import ALL, DHP, DLL, DPH
from gspcli.catalogue.types import CONSTRAINTS, Family
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.reality.witness_proofs import certified_real, witness_instance
from gspcli.workers import Workers
from tools.oracle.poses_by_paths import solve_by_tracking
from tools.recording import CONFIRMED, add_sample, add_workers, workers_of
from tools.witnesses.record import FOLDER, Record

COUNTS = Record(FOLDER / "counts.csv", FOLDER / "counts.manifest.json", ("family", "platforms"))
#: Lines that are tried in vain for a family, and how often an interval is halved.
_LINES, _HALVINGS = 40, 16


def possible(family: Family) -> range:
    """Return the numbers of real solutions that can occur up to the best one on record.

    Complex solutions come in conjugate pairs. With three angles and no DPP, DPL or DLP each
    rotation has one position for each choice of sides and signs, always real.
    """
    best = best_real(family) or 0
    flat = all(kind in (DPH, DHP, DLL) for kind in family.distances)
    return range(0, best + 1, 16 if flat and family.platform_class.angles == 3 else 2)


def instance_at(family: Family, place: PlaceOnLine) -> Instance:
    """Return the platform of a place, its angles those of lines."""
    angles = (ALL,) * (CONSTRAINTS - len(family.distances))
    return witness_instance(platform_at(family, place), angles)


def found_at(family: Family, number: int, share: str) -> int | None:
    """Return how many real poses double precision finds at a place, None if that is unclear."""
    found = solve_by_tracking(
        Arrangement.of(instance_at(family, PlaceOnLine(0, number, share))), seed=SEED
    )
    return int(found.real.sum()) if found.account.verdict == "complete" else None


@dataclass
class Hunt:
    """The search for the numbers that occur in a family.

    Attributes
    ----------
    family
        The family.
    is_late
        Whether to stop.
    known
        The places that are certified, by their numbers.
    """

    family: Family
    is_late: Callable[[], bool]
    known: dict[int, PlaceOnLine] = field(default_factory=dict)

    @property
    def missing(self) -> set[int]:
        """The numbers that are not known yet."""
        return set(possible(self.family)) - set(self.known) - {best_real(self.family)}

    def go(self) -> None:
        """Follow lines until all numbers are known, or several lines gave nothing new."""
        number, idle = max((place.number for place in self.known.values()), default=-1) + 1, 0
        while self.missing and idle < _LINES and not self.is_late():
            before = len(self.known)
            first = self._at(number, Fraction(0))
            if first is not None:
                best = best_real(self.family) or 0
                self._between(number, (Fraction(0), first), (Fraction(1), best), _HALVINGS)
            number, idle = number + 1, 0 if len(self.known) > before else idle + 1

    def _at(self, number: int, share: Fraction) -> int | None:
        """Return how many there are at a place, and certify it if the number is a new one."""
        text = str(float(share)) if share else "0"
        count = found_at(self.family, number, text)
        if count in self.missing:
            place = PlaceOnLine(count, number, text)
            if certified_real(instance_at(self.family, place)) == count:
                self.known[count] = place
        return count

    def _between(
        self, number: int, low: tuple[Fraction, int], high: tuple[Fraction, int], halvings: int
    ) -> None:
        """Look for missing numbers between two places."""
        least, most = sorted((low[1], high[1]))
        wanted = any(least <= count <= most for count in self.missing)
        if not (wanted and halvings) or least == most or self.is_late():
            return
        share = _short(low[0], high[0])
        count = self._at(number, share)
        if count is None:
            return
        self._between(number, low, (share, count), halvings - 1)
        self._between(number, (share, count), high, halvings - 1)


def _short(low: Fraction, high: Fraction) -> Fraction:
    """Return the decimal with the fewest digits in the middle half between two numbers."""
    middle, quarter, digits = (low + high) / 2, (high - low) / 4, 0
    while True:
        digits += 1
        share = Fraction(round(middle * 10**digits), 10**digits)
        if abs(share - middle) <= quarter:
            return share


def build(most: int, minutes: float) -> None:
    """Hunt in the families with at most this many solutions, the small ones first."""
    end = time.monotonic() + 60 * minutes
    places = {
        family: {place.real: place for place in row} for family, row in recorded_real_counts()
    }
    families = [f for f in all_families() if not mirrored(f.distances) < f.distances]
    for family in sorted(families, key=lambda one: family_counts(one).two_sided):
        if family_counts(family).two_sided > most or time.monotonic() > end:
            break
        right = {
            real: place
            for real, place in places.get(family, {}).items()
            if real < (best_real(family) or 0) and not wrong((family, place))
        }
        hunt = Hunt(family, lambda: time.monotonic() > end, right)
        if hunt.missing or right != places.get(family):
            hunt.go()
            places[family] = hunt.known
            save(places)
            sys.stderr.write(f"{family.id}: {len(hunt.known)}, missing {sorted(hunt.missing)}\n")


def save(places: dict[Family, dict[int, PlaceOnLine]]) -> None:
    """Write the records and their manifest."""
    rows = [(f.id, sorted(places[f].values())) for f in all_families() if places.get(f)]
    COUNTS.write(
        [(name, " ".join(map(str, row))) for name, row in rows],
        {
            "what": "numbers of real solutions that occur, each with a platform between random"
            " numbers and the best witness of real.csv",
            "command": "python -m tools.witnesses.counts build --most N",
            "check": "python -m tools.witnesses.counts check",
            "families": len(places),
            "numbers": sum(map(len, places.values())),
        },
    )


def wrong(one: tuple[Family, PlaceOnLine]) -> str:
    """Return what is wrong with a record, after solving and certifying the platform again."""
    family, place = one
    real = certified_real(instance_at(family, place))
    return "" if real == place.real else f"{family.id}: {place.real} recorded, {real} certified"


def check(size: int | None, workers: Workers) -> int:
    """Certify the recorded_real_counts platforms again; return the exit code."""
    known = [(family, place) for family, row in recorded_real_counts() for place in row]
    return COUNTS.check(wrong, known, size, workers, said=lambda _: "numbers that occur certified")


def main() -> int:
    """Run the part that the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parts = parser.add_subparsers(dest="part", required=True)
    part = parts.add_parser("build")
    part.add_argument("--most", type=int, default=64, metavar="SOLUTIONS")
    part.add_argument("--minutes", type=float, default=60, metavar="N")
    part = parts.add_parser("check")
    add_sample(part)
    add_workers(part)
    arguments = parser.parse_args()
    if arguments.part == "check":
        return check(arguments.sample, workers_of(arguments))
    build(arguments.most, arguments.minutes)
    return CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
