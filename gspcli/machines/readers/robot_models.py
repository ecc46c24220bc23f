"""SDF, URDF and MJCF: links and joints of one model.

MJCF is the model as MuJoCo compiles it, without parts that are only drawn or simulated. SDF may
have loops. URDF is a tree, with loops in a YAML file beside it, or as ``loop_joint``.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError, Mistake, SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.machines.graph import (
    Body,
    Graph,
    Joint,
    NoPlatform,
    Part,
    ball,
    closure,
    frame,
    inverse,
    matrix,
    place,
    turn,
    unit,
)
from gspcli.machines.source import MarkupElement, text_of, written
from gspcli.spec.document import Mapping, Sequence, Value
from gspcli.spec.yaml_reader import parse
from gspcli.wording import listed, shown

Array = NDArray[np.float64]

#: Letters of the axes of a joint; a ball has none.
_SDF_TYPES = {
    "revolute": "R",
    "continuous": "R",
    "prismatic": "P",
    "universal": "RR",
    "revolute2": "RR",
    "fixed": "",
}
#: What the name or the file of a plugin that moves joints contains.
_MOVES = re.compile("controller|apply_?joint_?force|applyjoint|apply-joint", re.IGNORECASE)


def read_sdf(root: MarkupElement, name: str) -> Graph:
    """Return the graph of the element ``sdf``; the name is for a model without one.

    Raises
    ------
    SpecError, NoPlatform
        With the line of what is wrong; if there is not one model, or joints that are not read.
    """
    models = list(root.everywhere("model"))
    for wrong in root.everywhere("include", "model"):
        if wrong.tag == "include" or wrong is not models[0]:
            raise wrong.error(f"found <{wrong.tag}> too, expected one model without others in it")
    if not models:
        raise root.error("found no <model>, expected one")
    return _SdfModel(models[0], root.get("version") or "1.5", name).graph()


class _SdfModel:
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
        if kind not in _SDF_TYPES:
            raise NoPlatform(f"found the joint {shown(name)} of the type {shown(kind)}, expected "
                             f"{listed([*_SDF_TYPES, 'ball'])}")  # fmt: skip
        parts = []
        for tag, letter in zip(("axis", "axis2"), _SDF_TYPES[kind], strict=False):
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


_URDF_TYPES = {"revolute": "R", "continuous": "R", "prismatic": "P", "fixed": "", "spherical": "S"}
_UNIVERSAL = re.compile(r"UJOINT_?([XYZ])([XYZ])", re.IGNORECASE)


def read_urdf(root: MarkupElement, path: Path) -> Graph:
    """Return the graph of the element ``robot`` of a file; ``NAME.yaml`` beside it has the loops.

    Raises
    ------
    SpecError, NoPlatform
        With the line of what is wrong; if there are joints that are not read.
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

    def _end(self, joint: MarkupElement, end: str) -> str:
        element = joint.child(end)
        link = element.needed("link")
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
            raise NoPlatform(
                f"found the joint {shown(name)} geared to another, expected independent joints"
            )
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
        elif kind in _URDF_TYPES:
            parts = [part(letter, axis) for letter in _URDF_TYPES[kind]]
        else:
            known = listed([*_URDF_TYPES, "planar", "floating"])
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
        if kind.lower() not in ("6d", "fixed", "3d", "spherical"):
            raise NoPlatform(f"found a loop of the type {shown(kind)}, expected 3d or 6d")
        weld = frames[0] @ inverse(frames[1]) if kind.lower() in ("6d", "fixed") else None
        return closure(name, links, there, (frames[0][:3, 3], frames[1][:3, 3]), weld)

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


#: Sections of a model that say nothing of its joints.
_LEFT_OUT = {
    "asset", "contact", "custom", "deformable", "extension", "keyframe", "sensor", "size",
    "skin", "statistic", "visual",
}  # fmt: skip
#: Elements that make many others, or other files, or that act on several joints.
_REFUSED = {
    "include": "expected one file: give the one with the bodies, or put them together",
    "model": "expected no other models in it",
    "attach": "expected no other models in it",
    "plugin": "expected no plugins",
    "replicate": "expected each body apart: save the model from MuJoCo's simulate",
    "composite": "expected each body apart: save the model from MuJoCo's simulate",
    "flexcomp": "expected rigid bodies",
    "flex": "expected rigid bodies",
}
#: What MuJoCo takes for no number, but in names.
_NOT_A_NUMBER = re.compile(r"(?<![\w.])[-+]?nan(?![\w.])", re.IGNORECASE)
_NAMES = {"name", "class", "childclass", "model", "body1", "body2", "site1", "site2", "joint"}
_SHAPES = {"plane", "sphere", "capsule", "ellipsoid", "cylinder", "box"}
#: What MuJoCo keeps of an option and of a compiler here.
_OPTIONS = {"gravity"}
_COMPILER = {
    "angle", "autolimits", "balanceinertia", "coordinate", "eulerseq", "inertiafromgeom",
    "inertiagrouprange",
}  # fmt: skip
#: Bodies get at least this mass and inertia: what is seen only as a mesh has none here.
_LEAST = "1e-12"


def read_mjcf(root: MarkupElement, name: str) -> Graph:
    """Return the graph of the element ``mujoco``; the name is for a model without one.

    Raises
    ------
    SpecError
        If the model cannot be compiled, or is made of other files.
    GspError
        If MuJoCo is not installed.
    """
    try:
        import mujoco
    except ImportError:
        message = "MJCF is read by MuJoCo, which is not installed: pip install 'gspcli[simulation]'"
        raise GspError(message) from None
    weightless = _cleaned(root)
    # MuJoCo would write its warnings to a file of the current folder.
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        model = mujoco.MjModel.from_xml_string(written(root))
        data = mujoco.MjData(model)
    except (ValueError, mujoco.FatalError) as error:
        said = " ".join(str(error).split())[:200]
        raise root.error(f"MuJoCo cannot compile the model: {said}") from None
    else:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
    finally:
        mujoco.set_mju_user_warning(None)
    return _CompiledModel(mujoco, model, data, weightless, root.get("model") or name).graph()


def _cleaned(root: MarkupElement) -> bool:
    """Remove parts that are only drawn; return whether masses came from removed shapes."""
    root.children = [child for child in root.children if child.tag not in _LEFT_OUT]
    weightless = False
    for element in root.everywhere():
        if element.tag in _REFUSED:
            raise element.error(f"found <{element.tag}>, {_REFUSED[element.tag]}")
        for key, text in element.attributes.items():
            if key not in _NAMES and _NOT_A_NUMBER.search(text):
                raise element.error(f"found {key} = {shown(text)}, expected numbers")
        if element.tag in ("option", "compiler"):
            keep = _OPTIONS if element.tag == "option" else _COMPILER
            element.attributes = {k: v for k, v in element.attributes.items() if k in keep}
            element.children = []
        kept = []
        for child in element.children:
            seen = child.tag in ("camera", "light")
            shaped = child.tag == "geom" and (
                "mesh" in child.attributes
                or "hfield" in child.attributes
                or child.get("type", "sphere") not in _SHAPES
            )
            # A default of geoms may be a mesh; the bodies keep their own inertia.
            if shaped and element.tag in ("body", "worldbody"):
                weightless = weightless or not element.first("inertial")
            if not seen and not shaped:
                kept.append(child)
        element.children = kept
        for key in ("material", "mesh", "hfield"):
            element.attributes.pop(key, None)
    compiler = MarkupElement("compiler", {"boundmass": _LEAST, "boundinertia": _LEAST})
    root.children.append(compiler)
    return weightless


class _CompiledModel:
    """A compiled model as a graph."""

    def __init__(self, mujoco: Any, model: Any, data: Any, weightless: bool, name: str) -> None:
        self.mujoco, self.model, self.data = mujoco, model, data
        self.weightless, self.name = weightless, name
        self.notes: list[str] = []
        self.names = ["world"]
        for i in range(1, model.nbody):
            given = model.body(i).name or f"body {i}"
            self.names.append(given if given not in self.names else f"{given} ({i})")
        self.poses = [frame(data.xmat[i].reshape(3, 3), data.xpos[i]) for i in range(model.nbody)]
        self.driven = self._driven()

    def graph(self) -> Graph:
        if self.model.ntendon:
            self.notes.append(f"{self.model.ntendon} tendons are not read")
        joints = [joint for i in range(1, self.model.nbody) if (joint := self._branch(i))]
        taken = {joint.name for joint in joints}
        for i in range(self.model.neq):
            loop = self._loop(i)
            if loop is not None:
                name = loop.name if loop.name not in taken else f"{loop.name} ({i + 1})"
                taken.add(name)
                joints.append(replace(loop, name=name))
        return Graph(
            "MJCF",
            self.name,
            {self.names[i]: self._body(i) for i in range(self.model.nbody)},
            tuple(joints),
            world="world",
            drives_known=bool(self.driven),
            gravity=np.array(self.model.opt.gravity),
            notes=tuple(self.notes),
        )

    def _driven(self) -> set[int]:
        """Return the joints that an actuator or an equality with one joint moves."""
        model, kinds = self.model, self.mujoco.mjtTrn
        driven: set[int] = set()
        for i in range(model.nu):
            kind = int(model.actuator_trntype[i])
            if kind in (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT):
                driven.add(int(model.actuator_trnid[i, 0]))
            elif kind == kinds.mjTRN_TENDON:
                name = shown(model.actuator(i).name)
                raise NoPlatform(f"found the actuator {name} on a tendon, expected it on a joint")
        equality = self.mujoco.mjtEq
        for i in range(model.neq):
            first, second = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
            if int(model.eq_type[i]) == equality.mjEQ_TENDON:
                message = "found an equality of tendons, expected only joints, welds and connects"
                raise NoPlatform(message)
            if int(model.eq_type[i]) == equality.mjEQ_JOINT:
                if second >= 0:
                    pair = " and ".join(shown(model.jnt(k).name) for k in (first, second))
                    raise NoPlatform(f"found the joints {pair} geared, expected independent joints")
                driven.add(first)
        return driven

    def _body(self, i: int) -> Body:
        model = self.model
        turned = rotation_from_quaternion(model.body_iquat[i])
        inertia = turned @ np.diag(model.body_inertia[i]) @ turned.T
        mass = None if self.weightless else float(model.body_mass[i])
        return Body(self.names[i], self.poses[i], mass, np.array(model.body_ipos[i]), inertia)

    def _branch(self, i: int) -> Joint | None:
        """Return what joins a body to its parent; None if it is free."""
        model, data = self.model, self.data
        parent = int(model.body_parentid[i])
        back = inverse(self.poses[parent])
        if model.body_mocapid[i] >= 0:
            self.notes.append(f"the body {shown(self.names[i])} is moved by hand: it is left out")
            return None
        parts = []
        first = int(model.body_jntadr[i])
        for j in range(first, first + int(model.body_jntnum[i])):
            kind = int(model.jnt_type[j])
            if kind == self.mujoco.mjtJoint.mjJNT_FREE:
                return None
            letter = {1: "S", 2: "P", 3: "R"}[kind]
            limited = bool(model.jnt_limited[j]) and letter != "S"
            low, high = model.jnt_range[j] if limited else (-math.inf, math.inf)
            at = 0.0 if letter == "S" else float(data.qpos[model.jnt_qposadr[j]])
            axis = np.zeros(3) if letter == "S" else turn(back, np.array(data.xaxis[j]))
            point = place(back, np.array(data.xanchor[j]))
            name = model.jnt(j).name or self.names[i]
            parts.append(
                Part(letter, axis, point, at, float(low), float(high), j in self.driven, name)
            )
        return Joint(
            self.names[i], self.names[parent], self.names[i], back @ self.poses[i], tuple(parts)
        )

    def _loop(self, i: int) -> Joint | None:
        """Return the loop closure of an equality connect or weld; None for others."""
        model = self.model
        kinds = self.mujoco.mjtEq
        kind = int(model.eq_type[i])
        if kind not in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            return None
        name = model.eq(i).name or f"loop {i + 1}"
        if not model.eq_active0[i]:
            self.notes.append(f"the equality {shown(name)} is not active: it is left out")
            return None
        first, second, numbers = int(model.eq_obj1id[i]), int(model.eq_obj2id[i]), model.eq_data[i]
        weld = kind == kinds.mjEQ_WELD
        if int(model.eq_objtype[i]) == self.mujoco.mjtObj.mjOBJ_SITE:
            sites = [
                frame(rotation_from_quaternion(model.site_quat[o]), model.site_pos[o])
                for o in (first, second)
            ]
            first, second = (int(model.site_bodyid[o]) for o in (first, second))
            relative = sites[0] @ inverse(sites[1])
            ends = sites[0][:3, 3], sites[1][:3, 3]
        elif weld:
            # The anchor in the second body, then the pose of the second in the first.
            relative = frame(rotation_from_quaternion(numbers[6:10]), numbers[3:6])
            ends = place(relative, np.array(numbers[:3])), np.array(numbers[:3])
        else:
            relative = np.eye(4)
            ends = np.array(numbers[:3]), np.array(numbers[3:6])
        if any(model.body_mocapid[b] >= 0 for b in (first, second)):
            return None
        there = inverse(self.poses[first]) @ self.poses[second]
        bodies = self.names[first], self.names[second]
        return closure(name, bodies, there, ends, relative if weld else None)
