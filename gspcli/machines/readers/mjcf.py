"""MJCF: the model as MuJoCo compiles it, without parts that are only drawn or simulated."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from gspcli.errors import GspError
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.machines.graph import (
    Body,
    Graph,
    Joint,
    NoPlatform,
    Part,
    ball,
    frame,
    inverse,
    place,
    turn,
)
from gspcli.machines.source import MarkupElement, written
from gspcli.wording import shown

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


def read(root: MarkupElement, name: str) -> Graph:
    """Return the graph of a model.

    Parameters
    ----------
    root
        The element ``mujoco``.
    name
        What the machine is called if the model does not say.

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
    return _Model(mujoco, model, data, weightless, root.get("model") or name).graph()


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


class _Model:
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
                joints.append(Joint(name, *_rest(loop)))
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
                message = f"found the actuator {name} on a tendon, expected it on a joint"
                raise NoPlatform(message)
        equality = self.mujoco.mjtEq
        for i in range(model.neq):
            first, second = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
            if int(model.eq_type[i]) == equality.mjEQ_TENDON:
                message = "found an equality of tendons, expected only joints, welds and connects"
                raise NoPlatform(message)
            if int(model.eq_type[i]) == equality.mjEQ_JOINT:
                if second >= 0:
                    pair = " and ".join(shown(model.jnt(k).name) for k in (first, second))
                    message = f"found the joints {pair} geared, expected independent joints"
                    raise NoPlatform(message)
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
        gap = float(np.linalg.norm(ends[0] - place(there, ends[1])))
        bodies = self.names[first], self.names[second]
        if weld:
            return Joint(name, *bodies, relative, (), True, gap)
        R = there[:3, :3]
        parts = (ball(ends[0], name),)
        return Joint(name, *bodies, frame(R, ends[0] - R @ ends[1]), parts, True, gap)


def _rest(joint: Joint) -> tuple[Any, ...]:
    fields = ("first", "second", "relative", "parts", "closure", "gap")
    return tuple(getattr(joint, field) for field in fields)
