"""CASPR: cable-driven robots as two files, of bodies and of cables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.euler import rotation_from_euler
from gspcli.machines.frames import frame, from_quaternion
from gspcli.machines.graph import Body, Graph, NoPlatform
from gspcli.machines.markup import MarkupElement
from gspcli.machines.readers.legs import RowLeg, legs_graph
from gspcli.wording import counted, listed, shown

Array = NDArray[np.float64]


def read(bodies: MarkupElement, cables: MarkupElement, name: str) -> Graph:
    """Return the graph of a robot with one rigid body.

    Parameters
    ----------
    bodies, cables
        The roots ``bodies_system`` and ``cables``.
    name
        What the machine is called.

    Raises
    ------
    SpecError
        If something in the files is wrong.
    NoPlatform
        If there is more than one body, or the body is guided.
    """
    links = list(bodies.everywhere("link_rigid"))
    if len(links) != 1:
        names = listed([shown(link.get("name")) for link in links[:6]] or ["none"], "and")
        message = f"found {counted(len(links), 'moving body').replace('bodys', 'bodies')} ({names})"
        raise NoPlatform(f"{message}, expected one, the platform")
    link = links[0]
    pose = _pose(link.child("joint"))
    physical = link.child("physical")
    centre = _vector(physical.child("com_location"))
    chosen = cables.get("default_cable_set")
    sets = cables.all("cable_set")
    if not sets:
        raise cables.error("found no <cable_set>, expected one")
    cable_set = next((s for s in sets if s.get("id") == chosen), sets[0])
    legs, remarks = [], {}
    for cable in cable_set.children:
        leg = _cable(cable, centre)
        legs.append(leg)
        least, most = (cable.said(f"properties/force_{end}") for end in ("min", "max"))
        if least and most:
            low, high = cable.number(least), cable.number(most)
            remarks[leg.name] = f"tension {low:g} to {high:g} N"
    notes = []
    if len(sets) > 1:
        notes.append(f"of {len(sets)} sets of cables this is {shown(cable_set.get('id'))}")
    notes.append("CASPR states no unit of length: metres; cables only pull, gsp's legs also push")
    platform = Body("platform", pose, physical.decimal("mass"), centre, _inertia(physical))
    return legs_graph(
        "CASPR",
        link.get("name") or name,
        legs,
        pose,
        length="m",
        platform=platform,
        notes=notes,
        remarks=remarks,
    )


def _vector(element: MarkupElement) -> Array:
    return element.numbers(element.text, 3)


def _pose(joint: MarkupElement) -> Array:
    """Return the first pose of the body."""
    kind = joint.get("type")
    if kind == "SPATIAL_QUATERNION":
        q = joint.numbers(joint.needed("q_initial"), 7)
        if not np.any(q[3:]):
            raise joint.error("found the quaternion 0 0 0 0, expected any other")
        return frame(from_quaternion(q[3:]), q[:3])
    if kind == "SPATIAL_EULER_XYZ":
        q = joint.numbers(joint.needed("q_initial"), 6)
        return frame(rotation_from_euler("XYZ", q[3:]), q[:3])
    message = f"found a body guided by the joint {shown(kind)}, expected a free one (SPATIAL_...)"
    raise NoPlatform(message)


def _cable(cable: MarkupElement, centre: Array) -> RowLeg:
    name = cable.get("name") or cable.tag
    ends: dict[str, list[Array]] = {}
    attachments = list(cable.everywhere("attachment"))
    for attachment in attachments:
        link = (attachment.said("link") or "").strip()
        place = _vector(attachment.child("location"))
        if link == "1" and cable.get("attachment_reference") == "com":
            place = place + centre
        ends.setdefault(link, []).append(place)
    if set(ends) != {"0", "1"} or len(attachments) != 2:
        message = f"found {counted(len(attachments), 'attachment')} of the cable {shown(name)}, "
        raise NoPlatform(message + "expected two: one on the base (0), one on the platform (1)")
    return RowLeg(name, ends["0"][0], ends["1"][0])


def _inertia(physical: MarkupElement) -> Array:
    found = physical.first("inertia")
    if found is None:
        return np.zeros((3, 3))
    xx, yy, zz, xy, xz, yz = (
        found.decimal(f"I{axes}") for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
    )
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
