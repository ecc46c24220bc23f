"""A platform at one pose as bodies and single joints between them, for SDF and URDF.

Each constraint is its chain of joints (`chains`) from the base to the platform, taken apart: every
joint has two bodies. Frames of links have the axes of the base; lengths are metres.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.export.carriers import Carrier, carriers
from gspcli.export.chains import ChainJoint, ball, chain, driven_leg, socket
from gspcli.export.simulated_masses import Inertial, SimulatedMasses
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.lengths import METRES
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
    """A link of a chain.

    Attributes
    ----------
    name
        Its name.
    origin
        The origin of its frame in that of the base, shape (3,).
    inertial
        Its mass.
    """

    name: str
    origin: Array
    inertial: Inertial


@dataclass(frozen=True, eq=False)
class LinkJoint:
    """A joint between two bodies.

    Attributes
    ----------
    name
        Its name: ``value_k`` if it is the value of constraint k, ``drive_k`` if it is the crank or
        slide that moves its point.
    parent, child
        The bodies, from the base to the platform.
    joint
        Its type, axis and point in the frame of the base.
    """

    name: str
    parent: str
    child: str
    joint: ChainJoint


Jointed: TypeAlias = "tuple[tuple[JointedLink, ...], tuple[LinkJoint, ...]]"


@dataclass(frozen=True, eq=False)
class JointedModel:
    """A platform at one pose.

    Attributes
    ----------
    instance
        The platform.
    R, T
        The pose; metres.
    platform
        The mass of the platform, in its frame.
    gravity
        The acceleration of what falls, m/s^2, shape (3,).
    chains
        The links and the joints of each constraint; the last joint leads to the platform.
    """

    instance: Instance
    R: Array
    T: Array
    platform: Inertial
    gravity: Array
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
