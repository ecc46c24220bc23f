"""MuJoCo models: the platform at one pose, held by six chains of joints.

The platform is a free body; each constraint is a chain of joints from the base (`chains`), welded
to the platform. The coordinate of the joint ``value_k`` is what constraint k measures, in metres or
radians. A joint equality ``hold_k`` holds it: its first coefficient is the change of the value
(``model.eq_data``), so that moving it moves the platform; without it (``data.eq_active``) the
actuator ``drive_k`` pulls towards the same change, within the stated range. The text ``gsp`` is
the instance itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.catalogue.kinds import Kind
from gspcli.export.chains import (
    Carrier,
    Chain,
    ChainJoint,
    Link,
    ball,
    carriers,
    chain,
    driven_leg,
    socket,
)
from gspcli.export.simulated_masses import Inertial, SimulatedMasses
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.frames import Placement, PoseFrame
from gspcli.geometry.instance import METRES, Instance
from gspcli.geometry.primitives import Line, Plane
from gspcli.machines.stored import store_custom
from gspcli.ties import definite_sign

Array = NDArray[np.float64]

#: Seconds a step. MuJoCo's constraints give way by its square: docs/export.md says how much.
TIME_STEP = 5e-4
_SOLIMP = "0.9999 0.9999 0.001 0.5 2"
#: In sizes: how far the floor is below the lowest point, half of its side, what is flat, and half
#: of the thickness of a plate.
_BELOW, _FLOOR, _FLAT, _PLATE = 0.1, 4.0, 2e-2, 0.012
#: Corners of a hull that has an area.
_TRIANGLE = 3
_BASE, _PLATFORM, _CHAIN = "0.45 0.5 0.55 1", "0.2 0.45 0.8 1", "0.85 0.5 0.15 1"
_CARRIER = "0.3 0.6 0.3 1"
_HELD = '<!-- drive_k moves nothing while hold_k holds its joint: active="false" releases it. -->\n'


def mjcf(
    instance: Instance, R: Array, T: Array, *, gravity: float | None = None, step: float = TIME_STEP
) -> str:
    """Return the model of an instance at a real pose as XML.

    Parameters
    ----------
    instance
        The platform.
    R, T
        The pose: rotation, shape (3, 3), and translation, shape (3,), in its units.
    gravity
        Acceleration against z, in m/s^2; by default what the instance states, else 9.81.
    step
        Seconds a step.
    """
    return _Model(instance, R, T, gravity, step).text()


class _Model:
    """The XML of one model."""

    def __init__(
        self, instance: Instance, R: Array, T: Array, gravity: float | None, step: float
    ) -> None:
        self.instance = instance
        numbers = Arrangement.of(instance)
        self.metre = METRES.get(instance.units.length, 1.0)
        self.size = numbers.length * self.metre
        self.R, self.T = R, T * self.metre
        self.x, self.v = numbers.x * self.metre, numbers.v
        self.own = numbers.y * self.metre
        self.y, self.w = self.own @ R.T + self.T, numbers.u @ R.T
        self.kinds = numbers.kinds
        self.masses = SimulatedMasses(instance, self.own.mean(axis=0), self.size)
        self.carriers = carriers(instance, self.masses, self.metre)
        self.root = ET.Element("mujoco", model=_name(instance))
        self._settings(self.masses.gravity(gravity), step)
        self.world = ET.SubElement(self.root, "worldbody")
        self._floor(self.masses.gravity(gravity))
        self._bodies()

    def text(self) -> str:
        """Return the XML, with the instance in it."""
        store_custom(self.root, self.instance)
        ET.indent(self.root)
        unit = self.instance.units.length
        known = unit in METRES
        scale = f"1 {unit} = {self.metre:g} m" if known else f"1 {unit} is taken for 1 m"
        head = f"<!-- gsp {__version__}: {self.instance.type.id}; {scale}; radians -->\n"
        return head + _HELD + ET.tostring(self.root, encoding="unicode") + "\n"

    def _settings(self, gravity: Array, step: float) -> None:
        ET.SubElement(self.root, "compiler", angle="radian", autolimits="true")
        ET.SubElement(
            self.root,
            "option",
            timestep=f"{step:g}",
            gravity=_numbers(gravity),
            integrator="implicitfast",
            tolerance="1e-15",
            iterations="100",
        )
        # Bodies pass through each other: only the constraints act.
        default = ET.SubElement(self.root, "default")
        ET.SubElement(default, "geom", contype="0", conaffinity="0")
        equality = ET.SubElement(default, "equality")
        # The stiffest reference that is stable: its time constant is two steps.
        equality.set("solref", f"{2 * step:g} 1")
        equality.set("solimp", _SOLIMP)
        asset = ET.SubElement(self.root, "asset")
        sky = {"type": "skybox", "builtin": "gradient", "rgb1": "0.93 0.95 0.97", "rgb2": "1 1 1"}
        ET.SubElement(asset, "texture", sky, width="64", height="64")
        floor = {"name": "floor", "type": "2d", "builtin": "checker", "rgb1": "0.86 0.88 0.9"}
        ET.SubElement(asset, "texture", floor, rgb2="0.8 0.83 0.86", width="256", height="256")
        ET.SubElement(asset, "material", name="floor", texture="floor", texrepeat="12 12")
        for name, points in (("base", self.x), ("platform", self.own)):
            corners = self._corners(points, platform=name == "platform")
            if corners is not None:
                ET.SubElement(asset, "mesh", name=name, vertex=_numbers(corners), inertia="convex")
        size = ET.SubElement(self.root, "statistic", extent=_numbers([3 * self.size]))
        size.set("center", _numbers(self.x.mean(axis=0)))

    def _floor(self, gravity: Array) -> None:
        """Put a floor under everything, on the side to which gravity pulls."""
        pull = float(np.linalg.norm(gravity))
        up = -gravity / pull if pull else np.eye(3)[2]
        heights = np.concatenate((self.x, self.y)) @ up
        middle = self.x.mean(axis=0)
        at = middle + (heights.min() - _BELOW * self.size - middle @ up) * up
        floor = {"name": "floor", "type": "plane", "material": "floor", "pos": _numbers(at)}
        half = _numbers([_FLOOR * self.size, _FLOOR * self.size, self.size])
        ET.SubElement(self.world, "geom", floor, zaxis=_numbers(up), size=half)

    def _corners(self, points: Array, *, platform: bool) -> Array | None:
        """Return points whose convex hull MuJoCo draws, shape (n, 3); None if it has no area.

        A flat body is made a thin plate. Planes are not corners; they are drawn separately.
        """
        rows = self.instance.constraints
        primitives = [row.platform if platform else row.base for row in rows]
        corners = points[[not isinstance(each, Plane) for each in primitives]]
        if len(corners) < _TRIANGLE:
            return None
        _, extents, axes = np.linalg.svd(corners - corners.mean(axis=0))
        if extents[1] < _FLAT * self.size:
            return None
        if extents[2] >= _FLAT * self.size:
            return corners
        thick = _PLATE * self.size * definite_sign(axes[2])
        return np.concatenate((corners - thick, corners + thick))

    def _bodies(self) -> None:
        for geom in self._shapes(self.x, self.v, platform=False):
            self.world.append(geom)
        ET.SubElement(
            self.world,
            "light",
            pos=_numbers(self.T + 5 * self.size * np.eye(3)[2]),
            castshadow="false",
        )
        platform = ET.SubElement(
            self.world,
            "body",
            name="platform",
            pos=_numbers(self.T),
            quat=_numbers(_quaternion(self.R)),
        )
        ET.SubElement(platform, "freejoint", name="platform")
        _inertia(platform, self.masses.platform)
        for geom in self._shapes(self.own, self.w @ self.R, platform=True):
            platform.append(geom)
        frame = PoseFrame.of(self.instance)
        self._site("tool", platform, frame.tool)
        self._site("work", self.world, frame.work)
        self.equality = ET.SubElement(self.root, "equality")
        self.actuator = ET.SubElement(self.root, "actuator")
        moved = {k: one for one in self.carriers for k in one.constraints}
        for k, kind in enumerate(self.kinds):
            carrier = moved.get(k)
            if carrier is None:
                value = self._chain(k + 1, kind)
                lever = 1.0 if kind.is_distance else self.size
                stiffness = self.masses.stiffness(k, lever=lever)
                damping = self.masses.damping(stiffness)
                span = self._change(k, value)
                self._drive(k + 1, f"value_{k + 1}", value, span, stiffness, damping)
            elif k == carrier.constraints[0]:
                self._carrier(carrier, platform)

    def _site(self, name: str, body: ET.Element, frame: Placement) -> None:
        """Mark a frame of a body that the instance states."""
        if not frame.is_identity:
            place, turn = _numbers(frame.origin * self.metre), _numbers(_quaternion(frame.matrix))
            size = _numbers([0.01 * self.size])
            ET.SubElement(body, "site", name=name, pos=place, quat=turn, size=size)

    def _change(self, k: int, value: float) -> tuple[float, float] | None:
        """Return by how much a value can change within its range; None if none is stated."""
        limits = self.instance.constraints[k].limits
        if limits is None:
            return None
        in_radians = self.instance.units.angle.in_radians
        unit = self.metre if self.kinds[k].is_distance else in_radians
        return limits[0].value * unit - value, limits[1].value * unit - value

    def _drive(
        self,
        number: int,
        joint: str,
        value: float,
        span: tuple[float, float] | None,
        stiffness: float,
        damping: float,
    ) -> None:
        """Hold a joint by an equality, and add the actuator that moves it without."""
        ET.SubElement(
            self.equality, "joint", name=f"hold_{number}", joint1=joint, polycoef="0 0 0 0 0"
        )
        # The control is the change of the value: stiffness (value + control - q).
        actuator = ET.SubElement(
            self.actuator,
            "general",
            name=f"drive_{number}",
            joint=joint,
            gainprm=_numbers([stiffness]),
            biastype="affine",
            biasprm=_numbers([stiffness * value, -stiffness, -damping]),
        )
        # MuJoCo refuses a range of one number.
        if span is not None and span[0] < span[1]:
            actuator.set("ctrlrange", _numbers(span))

    def _carrier(self, made: Carrier, platform: ET.Element) -> None:
        """Add an arm or a carriage with its drive and its rods."""
        parent, first = platform if made.on_platform else self.world, made.constraints[0]
        body = ET.SubElement(parent, "body", name=made.name, pos=_numbers(made.joint.point))
        if not made.inertial.falls:
            body.set("gravcomp", "1")
        joint = {"name": f"drive_{made.number}", "type": made.joint.type}
        joint["axis"] = _numbers(made.joint.axis)
        joint["armature"] = _numbers([self.masses.armature(made.joint.type, first)])
        if made.joint.range is not None:
            joint["range"] = _numbers(made.joint.range)
        ET.SubElement(body, "joint", joint)
        _inertia(body, made.inertial)
        for k in made.constraints:
            self._driven_rod(k, made, body)
        if made.lever is None:
            stiffness = self.masses.stiffness(first)
            damping = self.masses.damping(stiffness)
        else:
            stiffness = self.masses.stiffness(first, lever=made.lever)
            damping = self.masses.arm_damping(stiffness, made.lever)
        span = made.joint.range
        self._drive(made.number, f"drive_{made.number}", 0.0, span, stiffness, damping)

    def _driven_rod(self, k: int, made: Carrier, carrier: ET.Element) -> None:
        """Add the rod of a constraint (from 0) between two balls, one of which is closed."""
        x, y = self.x[k], self.y[k]
        length = float(np.linalg.norm(y - x))
        e = (y - x) / length
        inertial = self.masses.rod(k, e)
        own = self.own[k] if made.on_platform else x
        if np.linalg.norm(own - made.joint.point) > 1e-6 * self.size:
            arm = self._rod(np.zeros(3), own - made.joint.point)
            ET.SubElement(carrier, "geom", arm, rgba=_CARRIER)
        parent, origin = (self.world, x) if made.on_platform else (carrier, x - made.joint.point)
        rod = ET.SubElement(parent, "body", name=f"rod_{k + 1}", pos=_numbers(origin))
        if not inertial.falls:
            rod.set("gravcomp", "1")
        axis = self.masses.leg_axis(k) if self.masses.has_leg(k) else None
        for order, joint in enumerate(ball(x) if axis is None else socket(x, y, axis), 1):
            own_joint = {"name": f"rod_{k + 1}_{order}", "type": joint.type}
            own_joint["armature"] = _numbers([self.masses.armature(joint.type, None)])
            if joint.type == "ball":
                own_joint["damping"] = _numbers([self.masses.spin_damping(inertial, e)])
            else:
                own_joint["axis"] = _numbers(joint.axis)
            ET.SubElement(rod, "joint", own_joint)
        _inertia(rod, inertial)
        ET.SubElement(rod, "geom", self._rod(np.zeros(3), y - x), rgba=_CHAIN)
        loop = {"name": f"loop_{k + 1}", "body2": f"rod_{k + 1}"}
        if made.on_platform:
            loop |= {"body1": made.name, "anchor": _numbers(own - made.joint.point)}
        else:
            loop |= {"body1": "platform", "anchor": _numbers(self.own[k])}
        ET.SubElement(self.equality, "connect", loop)

    def _chain(self, number: int, kind: Kind) -> float:
        """Add the chain of a constraint, closed at the platform, and return its value."""
        vectors = [a[number - 1] for a in (self.x, self.v, self.y, self.w)]
        weighs = self.masses.has_leg(number - 1)
        if weighs:
            x, _, y, _ = vectors
            links = driven_leg(x, y, self.masses.leg_axis(number - 1))
            bodies = list(self.masses.leg_bodies(number - 1, links[1].joints[0].axis))
        else:
            links = chain(kind, *vectors)
            bodies = [self.masses.link] * len(links)
        self._links(number, links, bodies)
        loop = {"name": f"loop_{number}", "body1": "platform"}
        end = f"chain_{number}_{len(links)}"
        if weighs:
            anchor = _numbers(self.own[number - 1])
            ET.SubElement(self.equality, "connect", loop, body2=end, anchor=anchor)
        else:
            scale = _numbers([self.size])
            ET.SubElement(self.equality, "weld", loop, body2=end, torquescale=scale)
        (value,) = (j.value for link in links for j in link.joints if j.value is not None)
        return value

    def _links(self, number: int, links: Chain, bodies: list[Inertial]) -> None:
        parent, origin = self.world, np.zeros(3)
        for position, (link, inertial) in enumerate(zip(links, bodies, strict=True), 1):
            name = f"chain_{number}_{position}"
            pos = _numbers(link.origin - origin)
            body = ET.SubElement(parent, "body", name=name, pos=pos)
            if not inertial.falls:
                body.set("gravcomp", "1")
            for order, joint in enumerate(link.joints, 1):
                self._joint(body, joint, link, f"{name}_{order}", number)
            _inertia(body, inertial)
            if position > 1 and np.linalg.norm(link.origin - origin) > 1e-6 * self.size:
                rod = self._rod(np.zeros(3), link.origin - origin)
                ET.SubElement(parent, "geom", rod, rgba=_CHAIN)
            parent, origin = body, link.origin

    def _joint(
        self, body: ET.Element, joint: ChainJoint, link: Link, name: str, number: int
    ) -> None:
        attributes = {"name": name, "type": joint.type, "pos": _numbers(joint.point - link.origin)}
        driven = None if joint.value is None else number - 1
        attributes["armature"] = _numbers([self.masses.armature(joint.type, driven)])
        if joint.type != "ball":
            attributes["axis"] = _numbers(joint.axis)
        if joint.value is not None:
            attributes |= {"name": f"value_{number}", "ref": _numbers([joint.value])}
        ET.SubElement(body, "joint", attributes)

    def _rod(self, start: Array, end: Array) -> dict[str, str]:
        """Return the attributes of a thin rod between two points."""
        ends = _numbers([*start, *end])
        return {"type": "capsule", "size": _numbers([0.01 * self.size]), "fromto": ends}

    def _shapes(self, points: Array, directions: Array, *, platform: bool) -> Iterator[ET.Element]:
        """Yield what is seen of the primitives of a body, in its frame."""
        colour = _PLATFORM if platform else _BASE
        rows = self.instance.constraints
        if self._corners(points, platform=platform) is not None:
            hull = "platform" if platform else "base"
            yield ET.Element("geom", type="mesh", mesh=hull, rgba=colour[:-1] + "0.6")
        else:
            centre = points.mean(axis=0)
            for point in points:
                if np.linalg.norm(point - centre) > 1e-6 * self.size:
                    yield ET.Element("geom", self._rod(centre, point), rgba=colour)
        for row, point, direction in zip(rows, points, directions, strict=True):
            primitive = row.platform if platform else row.base
            if isinstance(primitive, Line):
                half = direction * self.size / 2
                shape = self._rod(point - half, point + half)
            elif isinstance(primitive, Plane):
                shape = {
                    "type": "box",
                    "size": _numbers([0.3 * self.size, 0.3 * self.size, 0.003 * self.size]),
                    "pos": _numbers(point),
                    "zaxis": _numbers(direction),
                }
            else:
                shape = {"type": "sphere", "size": _numbers([0.025 * self.size])}
                shape["pos"] = _numbers(point)
            clear = isinstance(primitive, Plane)
            shape["rgba"] = colour[:-1] + "0.4" if clear else colour
            yield ET.Element("geom", shape)


def _inertia(body: ET.Element, inertial: Inertial) -> None:
    matrix = inertial.matrix
    found = {"pos": _numbers(inertial.centre), "mass": _numbers([inertial.mass])}
    if np.array_equal(matrix, np.diag(np.diag(matrix))):
        found["diaginertia"] = _numbers(np.diag(matrix))
    else:
        found["fullinertia"] = _numbers(
            [*np.diag(matrix), matrix[0, 1], matrix[0, 2], matrix[1, 2]]
        )
    ET.SubElement(body, "inertial", found)


def _name(instance: Instance) -> str:
    return instance.name or instance.type.id


def _quaternion(R: Array) -> Array:
    from gspcli.geometry.quaternions import quaternion_from_rotation

    return np.asarray(quaternion_from_rotation(R))


def _numbers(values: object) -> str:
    """Return numbers that read back as the same doubles."""
    return " ".join(map(repr, (np.ravel(np.asarray(values, dtype=float)) + 0.0).tolist()))
