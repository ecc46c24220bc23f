"""Points of one body on a line, or nearly, with distances from one line of the other body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gspcli.catalogue.kinds import DLP, DPL, Kind
from tools.special.hexapods import Named
from tools.special.legs import Draw, legs, planes_of
from tools.special.parts import Draws, Leg, Vector, assembled, plus, tenth

#: What holds the platform beside the four distances from one line.
_BESIDE = ("DPP DPP", "DPP DPH", "DPH DPH", "DPP ALL")


def points_on_lines(draws: Draw) -> Iterator[Named]:
    """Yield four points on a line up to this distance, at distances from a line of the other body.

    The fourth distance follows from three of them if the points are on a line: then there are
    infinitely many poses. Others are eps^-1 and eps^-2 lengths away.
    """
    for kind in (DPL, DLP):
        for names in _BESIDE:
            text = f"{kind.short}-{names.replace('D', '').replace(' ', '-')}"
            random = draws(text)
            six, at = [*_four(kind, random), *legs(names, random)], random.motion()
            for power in (4, 10, 14, 20, 30):
                shake = draws(f"{text} {power}")
                nearly = [*six]
                nearly[3] = _moved(six[3], shake.point(), power)
                nearly.sort(key=lambda one: one.kind.order)
                yield f"{text}/1e-{power}", assembled(nearly, at, one_sided=planes_of(nearly))


def _four(kind: Kind, random: Draws) -> list[Leg]:
    """Return four constraints between points on a line and one line."""
    start, along, other, direction = (
        random.point(),
        random.point(),
        random.point(2),
        random.direction(),
    )
    points = [plus(start, along, place) for place in (-2, 0, 1, 3)]
    if kind is DPL:
        return [Leg(kind, point, other, v=direction) for point in points]
    return [Leg(kind, other, point, u=direction) for point in points]


def _moved(leg: Leg, by: Vector, power: int) -> Leg:
    if leg.kind is DPL:
        return replace(leg, y=plus(leg.y, by, tenth(power)))
    return replace(leg, x=plus(leg.x, by, tenth(power)))


GROUPS = {"points-on-lines": points_on_lines}
