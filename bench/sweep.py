"""How the cost grows with the number of solutions: one platform of each of the 896 signatures."""

from __future__ import annotations

import csv
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from itertools import islice
from math import log10
from pathlib import Path

from bench.cases import random_instances
from bench.homotopy import structure_of
from gspcli.catalogue.counts import all_families, family_counts
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.continuation.start import start_system
from gspcli.solver import solve

#: Platforms solved more quickly than this (in seconds) are solved again, and the least counts.
_QUICK = 0.05


@dataclass(frozen=True)
class Cost:
    """The cost of one random one-sided platform, solved alone after loading, uncertified."""

    family: str
    method: str
    expected: int
    found: int
    real: int
    verdict: str
    milliseconds: float
    """Processor time."""


def costs(seed: int, step: int) -> Iterator[Cost]:
    """Yield the cost for every `step`-th signature that has a finite number of solutions."""
    finite = (family for family in all_families() if family_counts(family).one_sided)
    for family in islice(finite, 0, None, step):
        gsp_type = family.types[0]
        instance = next(random_instances(gsp_type.id, seed))
        if len(gsp_type.angles) < MAX_ANGLES:
            # Now, because it is derived on first use, which does not count.
            start_system(structure_of(instance)[0])
        times: list[float] = []
        while not times or (len(times) < 3 and times[-1] < _QUICK):
            began = time.process_time()
            result = solve(instance, certify=False)
            times.append(time.process_time() - began)
        yield Cost(
            family.id,
            "paths" if len(gsp_type.angles) < MAX_ANGLES else "closed form",
            result.expected,
            result.counts.found,
            result.counts.real,
            result.verdict,
            round(min(times) * 1e3, 3),
        )


def peak_memory() -> float:
    """Return the peak memory of this process so far, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def write_csv(rows: Sequence[Cost], path: Path) -> None:
    """Write the costs as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Cost))
        writer.writerows(map(astuple, rows))


_WIDTH, _HEIGHT, _LEFT, _TOP, _BOTTOM = 640, 420, 60, 20, 50
_COLOURS = {"closed form": "#d95f02", "paths": "#1b6ca8"}


def plot(rows: Sequence[Cost]) -> str:
    """Return the costs over the counts as SVG, both on logarithmic axes."""
    counts = [row.expected for row in rows]
    times = [row.milliseconds for row in rows]
    x = _axis(min(counts), max(counts), _LEFT, _WIDTH - 20)
    y = _axis(min(times), max(times), _HEIGHT - _BOTTOM, _TOP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="white"/>',
    ]
    for value in _powers(min(counts), max(counts), 4, 2):
        parts.append(_line(x(value), _TOP, x(value), _HEIGHT - _BOTTOM))
        parts.append(_text(x(value), _HEIGHT - _BOTTOM + 18, f"{value:g}", "middle"))
    for value in _powers(min(times), max(times), 10, 0.001):
        parts.append(_line(_LEFT, y(value), _WIDTH - 20, y(value)))
        parts.append(_text(_LEFT - 6, y(value) + 4, f"{value:g}", "end"))
    parts += [
        f'<circle cx="{x(row.expected):.1f}" cy="{y(row.milliseconds):.1f}" r="2.5" '
        f'fill="{_COLOURS[row.method]}" fill-opacity="0.5"><title>{row.family}</title></circle>'
        for row in rows
    ]
    parts.append(_text(_WIDTH / 2, _HEIGHT - 12, "generic number of solutions", "middle"))
    parts.append(_text(_LEFT + 6, _TOP + 12, "milliseconds", "start"))
    for i, (method, colour) in enumerate(_COLOURS.items()):
        parts.append(f'<g fill="{colour}">{_text(_LEFT + 6, _TOP + 32 + 16 * i, method, "start")}')
        parts.append("</g>")
    return "\n".join([*parts, "</svg>\n"])


def _axis(low: float, high: float, first: float, last: float) -> Callable[[float], float]:
    """Return the map from values to pixels on a logarithmic axis, with a margin of 5 %."""
    begin, end = log10(low), log10(high)
    margin = 0.05 * ((end - begin) or 1.0)
    scale = (last - first) / (end - begin + 2 * margin)
    return lambda value: first + scale * (log10(value) - begin + margin)


def _powers(low: float, high: float, base: float, first: float) -> Iterator[float]:
    value = first
    while value <= high:
        if value >= low:
            yield value
        value *= base


def _line(x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="#ddd"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'
