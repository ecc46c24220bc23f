"""SDF: links and joints of one model, which may have loops."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.euler import rotation_from_euler
from gspcli.machines.graph import (
    Body,
    Graph,
    Joint,
    NoPlatform,
    Part,
    ball,
    frame,
    inverse,
    matrix,
    place,
    turn,
    unit,
)
from gspcli.machines.source import MarkupElement
from gspcli.wording import listed, shown

Array = NDArray[np.float64]

#: Letters of the axes of a joint; a ball has none.
_TYPES = {
    "revolute": "R",
    "continuous": "R",
    "prismatic": "P",
    "universal": "RR",
    "revolute2": "RR",
    "fixed": "",
}
#: What the name or the file of a plugin that moves joints contains.
_MOVES = re.compile("controller|apply_?joint_?force|applyjoint|apply-joint", re.IGNORECASE)


def read(root: MarkupElement, name: str) -> Graph:
    """Return the graph of a file.

    Parameters
    ----------
    root
        The element ``sdf``.
    name
        What the machine is called if the model does not say.

    Raises
    ------
    SpecError
        With the line of what is wrong.
    NoPlatform
        If there is not one model, or joints that are not read.
    """
    models = list(root.everywhere("model"))
    for wrong in root.everywhere("include", "model"):
        if wrong.tag == "include" or wrong is not models[0]:
            message = f"found <{wrong.tag}> too, expected one model without others in it"
            raise wrong.error(message)
    if not models:
        raise root.error("found no <model>, expected one")
    return _Model(models[0], root.get("version") or "1.5", name).graph()


class _Model:
    """A model."""

    def __init__(self, model: MarkupElement, version: str, name: str) -> None:
        self.model, self.name, self.version = model, model.get("name") or name, version
        numbers = re.findall(r"\d+", version)[:2]
        self.old = [int(n[:6]) for n in numbers] < [1, 5]
        self.frames: dict[str, MarkupElement] = {}
        for element in (*model.all("link"), *model.all("joint"), *model.all("frame")):
            own = element.needed("name")
            if own in self.frames:
                raise element.error(f"found the name {shown(own)} twice")
            self.frames[own] = element
        self.links = [link.get("name") for link in model.all("link")]
        self.poses: dict[str, Array] = {}

    def graph(self) -> Graph:
        bodies = {link.get("name"): self._body(link) for link in self.model.all("link")}
        joints = self.model.all("joint")
        world = any(joint.said(end) == "world" for joint in joints for end in ("parent", "child"))
        if world and "world" not in bodies:
            bodies["world"] = Body("world", np.eye(4))
        driven = self._driven({joint.get("name") for joint in joints})
        made = tuple(self._joint(joint, bodies, driven) for joint in joints)
        return Graph(
            f"SDF {self.version}",
            self.name,
            bodies,
            made,
            world="world" if world else None,
            drives_known=bool(driven),
        )

    def _driven(self, joints: set[str]) -> set[str]:
        """Return the joints that a plugin for joints names."""
        driven = set()
        for plugin in self.model.everywhere("plugin"):
            if _MOVES.search(plugin.get("name") + plugin.get("filename")):
                texts = {e.text.strip() for e in plugin.everywhere() if "joint" in e.tag.lower()}
                driven |= texts & joints
        return driven

    def pose(self, name: str, seen: tuple[str, ...] = ()) -> Array:
        """Return the pose of a link, a joint or a frame in the model, shape (4, 4)."""
        if name in ("__model__", ""):
            return np.eye(4)
        if name == "world" and name not in self.frames:
            return inverse(self._own(self.model, self.model))
        if name not in self.poses:
            if name not in self.frames or name in seen or len(seen) > 50:
                place_ = self.frames[seen[-1]] if seen else self.model
                raise place_.error(f"found the frame {shown(name)}, expected one that is defined")
            element = self.frames[name]
            relative = element.first("pose")
            to = relative.get("relative_to") if relative is not None else ""
            if not to and element.tag == "joint":
                to = element.said("child") or ""
            elif not to and element.tag == "frame":
                to = element.get("attached_to")
            self.poses[name] = self.pose(to, (*seen, name)) @ self._own(element, element)
        return self.poses[name]

    def _own(self, element: MarkupElement, place_: MarkupElement) -> Array:
        """Return what the element ``pose`` of an element says, shape (4, 4)."""
        found = element.first("pose")
        if found is None or not found.text.strip():
            return np.eye(4)
        if found.get("rotation_format") == "quat_xyzw":
            raise place_.error("found a pose with a quaternion, expected roll, pitch and yaw")
        numbers = found.numbers(found.text, 6)
        angles = numbers[3:]
        if found.get("degrees") in ("true", "1"):
            angles = np.radians(angles)
        return frame(rotation_from_euler("ZYX", angles), numbers[:3])

    def _body(self, link: MarkupElement) -> Body:
        X = self.pose(link.get("name"))
        inertial = link.first("inertial")
        if inertial is None:
            return Body(link.get("name"), X)
        own = self._own(inertial, inertial)
        tensor = matrix(lambda key: inertial.decimal(f"inertia/{key}"), own)
        return Body(link.get("name"), X, inertial.decimal("mass", 1.0), own[:3, 3], tensor)

    def _joint(self, joint: MarkupElement, bodies: dict[str, Body], driven: set[str]) -> Joint:
        name, kind = joint.get("name"), joint.get("type")
        ends = []
        for end in ("parent", "child"):
            body = joint.child(end).text.strip() or joint.said(f"{end}/link") or ""
            if body not in bodies:
                raise joint.error(f"found the {end} {shown(body)}, expected {self._known()}")
            ends.append(body)
        X, back = self.pose(name), inverse(bodies[ends[0]].pose)
        if ends[1] == "world" and joint.first("pose") is None:
            X = np.eye(4)
        point = place(back, X[:3, 3])
        relative = back @ bodies[ends[1]].pose
        if kind == "ball":
            return Joint(name, ends[0], ends[1], relative, (ball(point, name),))
        if kind not in _TYPES:
            raise NoPlatform(f"found the joint {shown(name)} of the type {shown(kind)}, expected "
                             f"{listed([*_TYPES, 'ball'])}")  # fmt: skip
        parts = []
        for tag, letter in zip(("axis", "axis2"), _TYPES[kind], strict=False):
            axis, low, high = self._axis(joint, tag, X)
            parts.append(
                Part(letter, turn(back, axis), point, 0.0, low, high, name in driven, name)
            )
        return Joint(name, ends[0], ends[1], relative, tuple(parts))

    def _known(self) -> str:
        return listed([shown(link) for link in self.links[:8]] or ["a link"])

    def _axis(self, joint: MarkupElement, tag: str, X: Array) -> tuple[Array, float, float]:
        """Return a unit axis in the model, and the ends of the range."""
        element = joint.first(tag)
        if element is None:
            return X[:3, 2], -math.inf, math.inf
        low = element.limit(element.said("limit/lower"), -math.inf)
        high = element.limit(element.said("limit/upper"), math.inf)
        xyz = element.first("xyz")
        text = "0 0 1" if xyz is None else xyz.text
        axis = unit((xyz or element).numbers(text, 3))
        if axis is None:
            raise element.error("found an axis of length 0")
        within = xyz.get("expressed_in") if xyz is not None else ""
        in_model = (element.said("use_parent_model_frame") or "") in ("1", "true")
        if within:
            return turn(self.pose(within), axis), low, high
        return (axis if self.old or in_model else turn(X, axis)), low, high
