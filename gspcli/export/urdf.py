"""URDF robots: a tree of links, and the loops in a YAML file beside it.

The first chain carries the platform; the others end at frames that the YAML file closes: at points
(``3d``) where a ball is at the platform, else wholly (``6d``). A ball is three hinges.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.export.jointed import BASE, PLATFORM, JointedModel, LinkJoint, light, numbers
from gspcli.export.simulated_masses import Inertial
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.instance import Instance
from gspcli.machines.stored import signed

Array = NDArray[np.float64]

_TYPES = {"hinge": "continuous", "slide": "prismatic"}
#: URDF needs a range for slides: this is none.
_FAR = "1e16"
_ENTRIES = (("xx", 0, 0), ("xy", 0, 1), ("xz", 0, 2), ("yy", 1, 1), ("yz", 1, 2), ("zz", 2, 2))


def urdf(instance: Instance, R: Array, T: Array) -> tuple[str, str]:
    """Return the loops in YAML, and the robot as XML, of an instance at a real pose.

    Parameters
    ----------
    instance
        The platform.
    R, T
        The pose: rotation, shape (3, 3), and translation, shape (3,), in its units.
    """
    robot = _Robot(JointedModel.of(instance, R, T))
    head = f"gsp {__version__}: {instance.type.id}; {robot.model.scale}; radians"
    loops = f"# {head}\n{robot.loops()}"
    return loops, f"<!-- {head} -->\n{signed(robot.root, robot.root, instance, loops)}"


class _Robot:
    """The XML of a robot."""

    def __init__(self, model: JointedModel) -> None:
        self.model = model
        instance = model.instance
        self.root = ET.Element("robot", name=instance.name or instance.type.id)
        #: Where the frames of links are in that of the base: all have its axes.
        self.origins: dict[str, Array] = {}
        self.pairs: list[tuple[str, str, str]] = []
        self.drives: list[str] = []
        #: What a link weighs that no link of a chain is: simulators need some mass.
        self.least = light(model.chains[0][0][0].inertial)
        self._link(BASE, np.zeros(3), None)
        for number, (links, joints) in enumerate(model.chains, 1):
            inertials = {link.name: link.inertial for link in links}
            for made in joints:
                if made.joint.value is not None:
                    self.drives.append(made.name)
                if made.child != PLATFORM:
                    self._jointed(made, made.child, inertials[made.child])
                elif number == 1:
                    self._platform(made)
                else:
                    self._closed(made, number)

    def loops(self) -> str:
        """Return the text of the YAML file."""
        rows = [
            "closed_loop: [" + ", ".join(f"[{a}, {b}]" for a, b, _ in self.pairs) + "]",
            "type: [" + ", ".join(kind for *_, kind in self.pairs) + "]",
            f"name_mot: [{', '.join(self.drives)}]",
        ]
        return "\n".join(rows) + "\n"

    def _link(self, name: str, origin: Array, inertial: Inertial | None) -> None:
        link = ET.SubElement(self.root, "link", name=name)
        self.origins[name] = origin
        if inertial is not None:
            body = ET.SubElement(link, "inertial")
            ET.SubElement(body, "origin", xyz=numbers(inertial.centre), rpy="0 0 0")
            ET.SubElement(body, "mass", value=numbers(inertial.mass))
            entries = {f"i{axes}": numbers(inertial.matrix[i, j]) for axes, i, j in _ENTRIES}
            ET.SubElement(body, "inertia", entries)

    def _between(
        self,
        name: str,
        kind: str,
        ends: tuple[str, str],
        axis: Array | None,
        limits: tuple[float, float] | None = None,
    ) -> None:
        """Add a joint at the origin of the second of two links."""
        if limits is not None and kind == "continuous":
            kind = "revolute"
        joint = ET.SubElement(self.root, "joint", name=name, type=kind)
        offset = self.origins[ends[1]] - self.origins[ends[0]]
        ET.SubElement(joint, "origin", xyz=numbers(offset), rpy="0 0 0")
        ET.SubElement(joint, "parent", link=ends[0])
        ET.SubElement(joint, "child", link=ends[1])
        if axis is not None:
            ET.SubElement(joint, "axis", xyz=numbers(axis))
        if kind in ("prismatic", "revolute"):
            span = (f"-{_FAR}", _FAR) if limits is None else map(numbers, limits)
            far = dict(zip(("lower", "upper"), span, strict=True))
            ET.SubElement(joint, "limit", far | {"effort": _FAR, "velocity": _FAR})

    def _jointed(self, made: LinkJoint, child: str, inertial: Inertial | None) -> None:
        """Add a joint and its second link, in the place of the joint."""
        parent, joint = made.parent, made.joint
        if joint.type != "ball":
            self._link(child, joint.point, inertial)
            ends = parent, child
            self._between(made.name, _TYPES[joint.type], ends, joint.axis, joint.range)
            return
        for axis, letter in zip(np.eye(3), "xyz", strict=True):
            name = child if letter == "z" else f"{child}_{letter}"
            self._link(name, joint.point, inertial if letter == "z" else self.least)
            self._between(f"{made.name}_{letter}", "continuous", (parent, name), axis)
            parent = name

    def _platform(self, made: LinkJoint) -> None:
        """Add the platform after the last joint of the first chain, in its own axes."""
        self._jointed(made, "carrier", self.least)
        self._link(PLATFORM, self.model.T, self.model.platform)
        self._between("carrier_platform", "fixed", ("carrier", PLATFORM), None)
        angles = euler_from_rotation("ZYX", self.model.R)
        origin = self.root[-1].find("origin")
        assert origin is not None
        origin.set("rpy", numbers(angles))

    def _closed(self, made: LinkJoint, number: int) -> None:
        """Add the frames that close the loop of a chain."""
        end, there = f"end_{number}", f"loop_{number}"
        if made.joint.type == "ball":
            self._link(end, made.joint.point, None)
            self._between(f"fixed_{end}", "fixed", (made.parent, end), None)
        else:
            self._jointed(made, end, self.least)
        # A frame with the axes of the base at the pose, fixed in the platform.
        self._link(there, made.joint.point, None)
        joint = ET.SubElement(self.root, "joint", name=f"fixed_{there}", type="fixed")
        R, T = self.model.R, self.model.T
        angles = euler_from_rotation("ZYX", R.T)
        offset = numbers(R.T @ (made.joint.point - T))
        ET.SubElement(joint, "origin", xyz=offset, rpy=numbers(angles))
        ET.SubElement(joint, "parent", link=PLATFORM)
        ET.SubElement(joint, "child", link=there)
        self.pairs.append((end, there, "3d" if made.joint.type == "ball" else "6d"))
