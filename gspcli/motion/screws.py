"""Screws of constraints, by plain formulas over enclosures of the vectors of a pose."""

from __future__ import annotations

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.enclosures import Enclosure


def screw(
    kind: Kind, arm: Enclosure, offset: Enclosure, w: Enclosure, v: Enclosure
) -> tuple[Enclosure, Enclosure | None]:
    """Return moment and force of a constraint, of some positive strength and either sense.

    Without a force the constraint is one of angles.

    Parameters
    ----------
    kind
        Of the constraint.
    arm
        From the point that moments are about to the point of the platform.
    offset
        From the point of the base to the one that moments are about; their sum is r.
    w, v
        Directions of the platform and of the base.
    """
    r = arm + offset
    if kind is DPP:
        return arm.cross(offset), r
    if kind is DPL:
        force = r.across(v)
        return arm.cross(force), force
    if kind is DLP:
        force = r.across(w)
        # It passes through the point of the base. Each form is the tighter one of its sort.
        if w.is_ball:
            return force.cross(offset), force
        return arm.cross(offset) - w.cross(offset) * w.dot(r), force
    if kind is DPH:
        return arm.cross(v), v
    if kind is DHP:
        return w.cross(offset), w
    if kind is DLL:
        # Of the moment m over the sine s, times s^3, with the cosine c: s^2 m' + m c c'.
        normal = w.cross(v)
        square, moment, cosine = normal.dot(normal), r.dot(normal), w.dot(v)
        turning = arm.cross(normal) + w.cross(v.cross(r))
        return turning * square + normal * (moment * cosine), normal * square
    return w.cross(v), None
