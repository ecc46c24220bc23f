"""A platform at one pose as bodies and single joints between them, for SDF and URDF.

Each constraint is its chain of joints (`chains`) from the base to the platform, taken apart: every
joint has two bodies. Frames of links have the axes of the base; lengths are metres.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.errors import ArgumentError
from gspcli.export.chains import Carrier, ChainJoint, ball, carriers, chain, driven_leg, socket
from gspcli.export.simulated_masses import Inertial, SimulatedMasses
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.frames import Placement, PoseFrame
from gspcli.geometry.instance import METRES, Instance
from gspcli.machines.graph import ENTRIES
from gspcli.machines.stored import signed
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: A rotation and a translation.
Pose: TypeAlias = "tuple[Array, Array]"
#: The bodies that all chains join.
BASE, PLATFORM = "base", "platform"
#: What a link between two joints of one place weighs of another link.
_BETWEEN = 1e-3


@dataclass(frozen=True, eq=False)
class JointedLink:
    """A link of a chain."""

    #: Its name.
    name: str
    #: The origin of its frame in that of the base, shape (3,).
    origin: Array
    #: Its mass.
    inertial: Inertial


@dataclass(frozen=True, eq=False)
class LinkJoint:
    """A joint between two bodies."""

    #: Its name: ``value_k`` if it is the value of constraint k, ``drive_k`` if it is the crank or
    #: slide that moves its point.
    name: str
    #: The bodies, from the base to the platform.
    parent: str
    child: str
    #: Its type, axis and point in the frame of the base.
    joint: ChainJoint


Jointed: TypeAlias = "tuple[tuple[JointedLink, ...], tuple[LinkJoint, ...]]"


@dataclass(frozen=True, eq=False)
class JointedModel:
    """A platform at one pose."""

    #: The platform.
    instance: Instance
    #: The pose; metres.
    R: Array
    T: Array
    #: The mass of the platform, in its frame.
    platform: Inertial
    #: The acceleration of what falls, m/s^2, shape (3,).
    gravity: Array
    #: The links and the joints of each constraint; the last joint leads to the platform.
    chains: tuple[Jointed, ...]

    @staticmethod
    def of(instance: Instance, R: Array, T: Array) -> JointedModel:
        """Return the model of an instance at a real pose, R and T in its units."""
        numbers = Arrangement.of(instance)
        metre = METRES.get(instance.units.length, 1.0)
        own = numbers.y * metre
        masses = SimulatedMasses(instance, own.mean(axis=0), numbers.length * metre)
        T = T * metre
        ends = numbers.x * metre, numbers.v, own @ R.T + T, numbers.u @ R.T
        moved = {k: one for one in carriers(instance, masses, metre) for k in one.constraints}
        chains = []
        for k, kind in enumerate(numbers.kinds):
            x, v, y, w = (end[k] for end in ends)
            if k in moved:
                chains.append(_driven(k, moved[k], (x, y), masses, (R, T)))
                continue
            if masses.has_leg(k):
                links = driven_leg(x, y, masses.leg_axis(k))
                bodies = list(masses.leg_bodies(k, links[1].joints[0].axis))
                joints = [(link.joints, body) for link, body in zip(links, bodies, strict=True)]
                joints.append(((ChainJoint("ball", np.eye(3)[2], y),), masses.link))
            else:
                joints = [(link.joints, masses.link) for link in chain(kind, x, v, y, w)]
            chains.append(_chain(k + 1, joints))
        gravity = masses.gravity(None)
        return JointedModel(instance, R, T, masses.platform, gravity, tuple(chains))

    @property
    def scale(self) -> str:
        """What a unit of length of the instance became."""
        unit = self.instance.units.length
        known = unit in METRES
        return f"1 {unit} = {METRES[unit]:g} m" if known else f"1 {unit} is taken for 1 m"


def _driven(
    k: int, carrier: Carrier, ends: tuple[Array, Array], masses: SimulatedMasses, at: Pose
) -> Jointed:
    """Return the links and joints of a rod (from 0) with the arm or carriage that moves it."""
    x, y = ends
    e = (y - x) / np.linalg.norm(y - x)
    rod, drive = masses.rod(k, e), carrier.joint
    first = k == carrier.constraints[0]
    links: list[tuple[tuple[ChainJoint, ...], Inertial]] = []
    if not carrier.on_platform:
        links += [((drive,), carrier.inertial)] if first else []
        links += [(ball(x), rod), (ball(y), masses.link)]
        return _chain(k + 1, links, carrier.name, BASE if first else carrier.name)
    if not first:
        names = " and ".join(str(one + 1) for one in carrier.constraints[:2])
        message = f"rods {names} share a drive on the platform, which these models do not have"
        raise ArgumentError(message)
    axis = masses.leg_axis(k) if masses.has_leg(k) else None
    # The platform turns against its arm.
    R, T = at
    turning = replace(drive, axis=-R @ drive.axis, point=R @ drive.point + T)
    links += [(ball(x) if axis is None else socket(x, y, axis), rod), (ball(y), carrier.inertial)]
    return _chain(k + 1, [*links, ((turning,), masses.link)], carrier.name)


def _chain(
    number: int,
    links: list[tuple[tuple[ChainJoint, ...], Inertial]],
    carrier: str = "",
    parent: str = BASE,
) -> Jointed:
    """Return the links and joints of a constraint: each joint of a link has a body of its own.

    Parameters
    ----------
    number
        The number of the constraint, from 1.
    links
        The joints before each link, and what it weighs; the last one is the platform.
    carrier
        The name of the link that a crank or slide moves; empty if there is none.
    parent
        The link that the chain begins at.
    """
    made: list[JointedLink] = []
    joints: list[LinkJoint] = []
    for place, (own, inertial) in enumerate(links):
        for order, joint in enumerate(own):
            last = order + 1 == len(own)
            end = last and place + 1 == len(links)
            child = PLATFORM if end else f"chain_{number}_{place + 1}_{order + 1}"
            if carrier and joint.value is not None and not end:
                child = carrier
            name = f"joint_{child}"
            if joint.value is not None:
                name = f"{'drive' if carrier else 'value'}_{number}"
            if end and joint.value is None:
                name = f"joint_{number}_platform"
            joints.append(LinkJoint(name, parent, child, joint))
            if not end:
                body = inertial if last else light(inertial)
                made.append(JointedLink(child, joint.point, body))
            parent = child
    return tuple(made), tuple(joints)


def light(inertial: Inertial) -> Inertial:
    """Return what a link between two joints of one place weighs: little, but not nothing."""
    mass = _BETWEEN * inertial.mass
    size = float(np.trace(inertial.matrix)) / 3 / inertial.mass
    return Inertial(mass, np.zeros(3), mass * size * np.eye(3), falls=False)


def numbers(values: object) -> str:
    """Return numbers that read back as the same doubles."""
    return " ".join(repr(float(x) + 0.0) for x in np.ravel(np.asarray(values, dtype=float)))


_TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "ball"}
_CONTROLLER = {
    "filename": "gz-sim-joint-position-controller-system",
    "name": "gz::sim::systems::JointPositionController",
}


def sdf(instance: Instance, R: Array, T: Array) -> str:
    """Return the model of an instance at a real pose as XML.

    Parameters
    ----------
    instance
        The platform.
    R, T
        The pose: rotation, shape (3, 3), and translation, shape (3,), in its units.
    """
    made = JointedModel.of(instance, R, T)
    root = ET.Element("sdf", version="1.9")
    model = ET.SubElement(root, "model", name=instance.name or instance.type.id)
    ET.SubElement(model, "link", name=BASE)
    fixed = ET.SubElement(model, "joint", name="base_to_world", type="fixed")
    ET.SubElement(fixed, "parent").text = "world"
    ET.SubElement(fixed, "child").text = BASE
    angles = euler_from_rotation("ZYX", made.R)
    _link(model, PLATFORM, np.concatenate((made.T, angles)), made.platform)
    frame = PoseFrame.of(instance)
    for name, body, stated in (("tool", PLATFORM, frame.tool), ("work", BASE, frame.work)):
        if not stated.is_identity:
            _frame(model, name, body, stated, METRES.get(instance.units.length, 1.0))
    for links, joints in made.chains:
        for link in links:
            _link(model, link.name, np.concatenate((link.origin, np.zeros(3))), link.inertial)
        for joint in joints:
            _joint(model, joint)
    for _, joints in made.chains:
        for joint in joints:
            if joint.joint.value is not None:
                plugin = ET.SubElement(model, "plugin", _CONTROLLER)
                ET.SubElement(plugin, "joint_name").text = joint.name
    head = f"<!-- gsp {__version__}: {instance.type.id}; {made.scale}; radians -->\n"
    return head + signed(root, model, instance)


def _frame(model: ET.Element, name: str, body: str, stated: Placement, metre: float) -> None:
    """Mark a frame of a body that the instance states."""
    marked = ET.SubElement(model, "frame", name=name, attached_to=body)
    angles = euler_from_rotation("ZYX", stated.matrix)
    pose = np.concatenate((stated.origin * metre, angles))
    ET.SubElement(marked, "pose").text = numbers(pose)


def _link(model: ET.Element, name: str, pose: Array, inertial: Inertial) -> None:
    link = ET.SubElement(model, "link", name=name)
    ET.SubElement(link, "pose").text = numbers(pose)
    if not inertial.falls:
        ET.SubElement(link, "gravity").text = "false"
    body = ET.SubElement(link, "inertial")
    ET.SubElement(body, "pose").text = numbers([*inertial.centre, 0, 0, 0])
    ET.SubElement(body, "mass").text = numbers(inertial.mass)
    matrix = ET.SubElement(body, "inertia")
    for axes, i, j in ENTRIES:
        ET.SubElement(matrix, f"i{axes}").text = numbers(inertial.matrix[i, j])


def _joint(model: ET.Element, made: LinkJoint) -> None:
    joint = ET.SubElement(model, "joint", name=made.name, type=_TYPES[made.joint.type])
    place = numbers([*made.joint.point, 0, 0, 0])
    ET.SubElement(joint, "pose", relative_to="__model__").text = place
    ET.SubElement(joint, "parent").text = made.parent
    ET.SubElement(joint, "child").text = made.child
    if made.joint.type != "ball":
        axis = ET.SubElement(joint, "axis")
        ET.SubElement(axis, "xyz", expressed_in="__model__").text = numbers(made.joint.axis)
        if made.joint.range is not None:
            limit = ET.SubElement(axis, "limit")
            for name, end in zip(("lower", "upper"), made.joint.range, strict=True):
                ET.SubElement(limit, name).text = numbers(end)


# URDF robots: a tree of links, and the loops in a YAML file beside it.
#
# The first chain carries the platform; the others end at frames that the YAML file closes: at
# points (``3d``) where a ball is at the platform, else wholly (``6d``). A ball is three hinges.


_URDF_TYPES = {"hinge": "continuous", "slide": "prismatic"}
#: URDF needs a range for slides: this is none.
_FAR = "1e16"


def urdf(instance: Instance, R: Array, T: Array) -> tuple[str, str]:
    """Return the loops in YAML, and the robot as XML, of an instance at a real pose, as `sdf`."""
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
            entries = {f"i{axes}": numbers(inertial.matrix[i, j]) for axes, i, j in ENTRIES}
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
            self._between(made.name, _URDF_TYPES[joint.type], ends, joint.axis, joint.range)
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
