"""URDF: a tree of links, with loops in a YAML file beside it, or as ``loop_joint``."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Mistake, SpecError
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
from gspcli.machines.source import MarkupElement, text_of
from gspcli.spec.document import Mapping, Sequence, Value
from gspcli.spec.yaml_reader import parse
from gspcli.wording import listed, shown

Array = NDArray[np.float64]

_TYPES = {"revolute": "R", "continuous": "R", "prismatic": "P", "fixed": "", "spherical": "S"}
_UNIVERSAL = re.compile(r"UJOINT_?([XYZ])([XYZ])", re.IGNORECASE)


def read(root: MarkupElement, path: Path) -> Graph:
    """Return the graph of a robot.

    Parameters
    ----------
    root
        The element ``robot``.
    path
        Where the file is: ``NAME.yaml`` beside it has the loops.

    Raises
    ------
    SpecError
        With the line of what is wrong.
    NoPlatform
        If there are joints that are not read.
    """
    return _Robot(root, _Loops(beside(path)), path.stem).graph()


def beside(path: Path) -> Path:
    """Return where the loops of a robot are."""
    return path.with_suffix(".yaml")


class _Loops:
    """The loops, the drives and the joints of a robot in a YAML file."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.document: Mapping = Mapping()
        self.found = file.exists()
        if self.found:
            mistakes: list[Mistake] = []
            document = parse(text_of(file), str(file), mistakes)
            if mistakes:
                raise SpecError(mistakes)
            # The instance file of the machine may have the same name.
            if isinstance(document, Mapping) and "gsp" not in document:
                self.document = document
            else:
                self.found = False

    def _of(self, key: str) -> Value:
        return next((value for name, value in self.document.items() if name == key), Sequence())

    def words(self, key: str) -> list[str]:
        """Return a list of words; empty if the file has no such key."""
        value = self._of(key)
        if not isinstance(value, Sequence) or not all(isinstance(word, str) for word in value):
            raise self._error(value, "expected a list of names")
        return [str(word) for word in value]

    def pairs(self) -> list[tuple[str, str]]:
        """Return the frames that the loops join."""
        value = self._of("closed_loop")
        if not isinstance(value, Sequence):
            raise self._error(value, "expected a list of pairs of links or joints")
        pairs = []
        for pair in value:
            if not isinstance(pair, Sequence) or len(pair) != 2:
                raise self._error(pair, "expected two links or joints")
            pairs.append((str(pair[0]), str(pair[1])))
        return pairs

    def _error(self, value: object, expected: str) -> SpecError:
        where = getattr(value, "location", None)
        return SpecError([Mistake(where, getattr(value, "path", ""), expected)])


class _Robot:
    """A robot."""

    def __init__(self, root: MarkupElement, loops: _Loops, name: str) -> None:
        self.root, self.loops, self.name = root, loops, root.get("name") or name
        self.types = dict(zip(loops.words("joint_name"), loops.words("joint_type"), strict=False))
        self.links: dict[str, MarkupElement] = {}
        for link in root.all("link"):
            if link.needed("name") in self.links:
                raise link.error("found the name twice")
            self.links[link.get("name")] = link
        names = [joint.needed("name") for joint in root.all("joint")]
        self.driven = self._driven(names)
        self.poses = self._placed()

    def graph(self) -> Graph:
        bodies = {name: self._body(name) for name in self.links}
        joints = [joint for e in self.root.all("joint") if (joint := self._joint(e)) is not None]
        joints += self._closures()
        joints += [self._loop_joint(e) for e in self.root.all("loop_joint")]
        notes = [f"loops are those of {self.loops.file.name}"] if self.loops.pairs() else []
        return Graph(
            "URDF",
            self.name,
            bodies,
            tuple(joints),
            world="world" if "world" in self.links else None,
            drives_known=bool(self.driven),
            notes=tuple(notes),
        )

    def _driven(self, names: list[str]) -> set[str]:
        """Return the joints that the file beside it, a transmission or ros2_control moves."""
        driven = set(self.loops.words("name_mot"))
        for transmission in self.root.all("transmission"):
            driven |= {joint.get("name") for joint in transmission.all("joint")}
        for control in self.root.all("ros2_control"):
            driven |= {j.get("name") for j in control.all("joint") if j.first("command_interface")}
        return driven & set(names)

    def _end(self, joint: MarkupElement, end: str, attribute: str = "link") -> str:
        element = joint.child(end)
        link = element.needed(attribute)
        if link not in self.links:
            known = listed([shown(name) for name in list(self.links)[:8]] or ["a link"])
            raise element.error(f"found the link {shown(link)}, expected {known}")
        return link

    def _placed(self) -> dict[str, Array]:
        """Return the poses of all links, with all coordinates zero."""
        above: dict[str, tuple[str, Array]] = {}
        for joint in self.root.all("joint"):
            child = self._end(joint, "child")
            if child in above:
                raise joint.error(f"found {shown(child)} below two joints, expected a tree")
            above[child] = self._end(joint, "parent"), _origin(joint)
        poses: dict[str, Array] = {}
        for link in self.links:
            way = [link]
            while way[-1] not in poses and way[-1] in above:
                way.append(above[way[-1]][0])
                if len(way) > len(self.links) + 1:
                    raise self.links[link].error("found it above itself, expected a tree")
            poses.setdefault(way[-1], np.eye(4))
            for child in reversed(way[:-1]):
                parent, X = above[child]
                poses[child] = poses[parent] @ X
        return poses

    def _body(self, name: str) -> Body:
        inertial = self.links[name].first("inertial")
        if inertial is None:
            # A link without inertia is a frame.
            return Body(name, self.poses[name], 0.0)
        own = _origin(inertial)
        mass, inertia = inertial.child("mass"), inertial.child("inertia")
        tensor = matrix(lambda key: inertia.number(inertia.get(key, "0")), own)
        value = mass.number(mass.needed("value"))
        return Body(name, self.poses[name], value, own[:3, 3], tensor)

    def _joint(self, joint: MarkupElement) -> Joint | None:
        name, kind = joint.get("name"), joint.get("type")
        if joint.first("mimic") is not None:
            message = (
                f"found the joint {shown(name)} geared to another, expected independent joints"
            )
            raise NoPlatform(message)
        X = _origin(joint)
        parent, child = self._end(joint, "parent"), self._end(joint, "child")
        if kind == "floating":
            return None
        limit = joint.first("limit")
        low, high = -math.inf, math.inf
        if limit is not None and kind != "continuous":
            low = limit.limit(limit.attributes.get("lower"), -math.inf)
            high = limit.limit(limit.attributes.get("upper"), math.inf)
            if low == high == 0:
                # What is not stated is zero in URDF: a joint that cannot move was not meant.
                low, high = -math.inf, math.inf
        axis = self._axis(joint, X)

        def part(letter: str, direction: Array) -> Part:
            return Part(letter, direction, X[:3, 3], 0.0, low, high, name in self.driven, name)

        special = self.types.get(name, "")
        if (match := _UNIVERSAL.fullmatch(special)) is not None:
            parts = [
                part("R", X[:3, "XYZ".index(letter)]) for letter in (match[1] + match[2]).upper()
            ]
        elif special.upper() == "SPHERICAL" or kind == "spherical":
            parts = [ball(X[:3, 3], name)]
        elif kind == "planar":
            first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
            first /= np.linalg.norm(first)
            parts = [part("P", first), part("P", np.cross(axis, first)), part("R", axis)]
        elif kind in _TYPES:
            parts = [part(letter, axis) for letter in _TYPES[kind]]
        else:
            known = listed([*_TYPES, "planar", "floating"])
            message = f"found the joint {shown(name)} of the type {shown(kind)}, expected {known}"
            raise NoPlatform(message)
        return Joint(name, parent, child, X, tuple(parts))

    def _axis(self, joint: MarkupElement, X: Array) -> Array:
        element = joint.first("axis")
        if element is None or joint.get("type") in ("fixed", "spherical"):
            return turn(X, np.eye(3)[0])
        axis = unit(element.attribute_numbers("xyz", (1.0, 0.0, 0.0)))
        if axis is None:
            raise element.error("found an axis of length 0")
        return turn(X, axis)

    def _closures(self) -> list[Joint]:
        """Return the loops of the file beside it: frames that coincide, or their origins do."""
        pairs, kinds = self.loops.pairs(), self.loops.words("type")
        if len(pairs) != len(kinds):
            message = f"found {len(pairs)} loops and {len(kinds)} types in {self.loops.file.name}"
            raise NoPlatform(message + ", expected as many")
        # The frame of a joint is that of the link below it.
        links = {joint.get("name"): self._end(joint, "child") for joint in self.root.all("joint")}
        links |= {name: name for name in self.links}
        joints = []
        for number, ((first, second), kind) in enumerate(zip(pairs, kinds, strict=True), 1):
            for end in (first, second):
                if end not in links:
                    message = f"found the loop of {shown(first)} and {shown(second)} in "
                    message += f"{self.loops.file.name}, but no link or joint {shown(end)} in the "
                    raise NoPlatform(message + "robot")
            ends = links[first], links[second]
            joints.append(self._closed(f"loop {number}", ends, (np.eye(4), np.eye(4)), kind))
        return joints

    def _closed(
        self, name: str, links: tuple[str, str], frames: tuple[Array, Array], kind: str
    ) -> Joint:
        """Return a loop that a kind closes: 6d, or 3d for the origins only."""
        first, second = links
        there = inverse(self.poses[first]) @ self.poses[second]
        ends = frames[0][:3, 3], frames[1][:3, 3]
        gap = float(np.linalg.norm(ends[0] - place(there, ends[1])))
        if kind.lower() in ("6d", "fixed"):
            return Joint(name, first, second, frames[0] @ inverse(frames[1]), (), True, gap)
        if kind.lower() not in ("3d", "spherical"):
            raise NoPlatform(f"found a loop of the type {shown(kind)}, expected 3d or 6d")
        R = there[:3, :3]
        closed = frame(R, ends[0] - R @ ends[1])
        return Joint(name, first, second, closed, (ball(ends[0], name),), True, gap)

    def _loop_joint(self, joint: MarkupElement) -> Joint:
        """Return a ``loop_joint``: the frames of two links that a joint closes."""
        links = self._end(joint, "link1"), self._end(joint, "link2")
        frames = _placed_at(joint.child("link1")), _placed_at(joint.child("link2"))
        return self._closed(joint.needed("name"), links, frames, joint.get("type"))


def _origin(element: MarkupElement) -> Array:
    """Return the pose of the element ``origin``, shape (4, 4)."""
    origin = element.first("origin")
    return np.eye(4) if origin is None else _placed_at(origin)


def _placed_at(element: MarkupElement) -> Array:
    """Return the pose that an element has in attributes, shape (4, 4)."""
    zero = (0.0, 0.0, 0.0)
    angles = element.attribute_numbers("rpy", zero)
    return frame(rotation_from_euler("ZYX", angles), element.attribute_numbers("xyz", zero))
