"""SDF models: the platform at one pose, its loops closed by joints as branches are."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.export.jointed import BASE, PLATFORM, JointedModel, LinkJoint, numbers
from gspcli.export.simulated_masses import Inertial
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.frames import Placement, PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.lengths import METRES
from gspcli.machines.stored import signed

Array = NDArray[np.float64]

_TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "ball"}
_CONTROLLER = {
    "filename": "gz-sim-joint-position-controller-system",
    "name": "gz::sim::systems::JointPositionController",
}
_ENTRIES = (("xx", 0, 0), ("xy", 0, 1), ("xz", 0, 2), ("yy", 1, 1), ("yz", 1, 2), ("zz", 2, 2))


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
    for axes, i, j in _ENTRIES:
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
