"""Generalized Stewart platforms: classify all 3850 types, bound and find their assembly modes.

Examples
--------
>>> import gspcli
>>> gspcli.parse_type("PL PL LP ALL ALH AHH").number
447
>>> gspcli.type_bounds(gspcli.parse_type("6PP")).theorem_5_3.value
40
>>> len(gspcli.TypeList().where(at_most={"refined_two_sided": 16}))
20
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gspcli.atlas.count_summary import atlas_summary
    from gspcli.atlas.platform_counts import count
    from gspcli.calibration import calibrate
    from gspcli.calibration.identifying import identify
    from gspcli.catalogue.bounds import family_bounds, type_bounds
    from gspcli.catalogue.coincidence import coincident_types
    from gspcli.catalogue.constraints import constraint_facts
    from gspcli.catalogue.known_facts import bound, show
    from gspcli.catalogue.listing import TypeList
    from gspcli.catalogue.mechanism import mechanism
    from gspcli.catalogue.names import parse_class, parse_kind, parse_kind_set, parse_type
    from gspcli.catalogue.types import Family, GspType, all_types
    from gspcli.dynamics import forward_dynamics, inverse_dynamics, natural_modes, simulate
    from gspcli.dynamics.analyses import analyze
    from gspcli.errors import ArgumentError, GspError, SpecError
    from gspcli.export.exported import exported
    from gspcli.geometry.building import angle, distance, hexapod, instance
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.home_pose import Frame, Frames, HomePose
    from gspcli.geometry.instance import Constraint, Instance, Units
    from gspcli.geometry.masses import Arm, Carriage, Drives, Dynamics, Leg, LegBody, RigidBody
    from gspcli.geometry.numbers import Number
    from gspcli.geometry.primitives import Cone, Crank, Line, Plane, Point, Slide
    from gspcli.geometry.random_instances import new
    from gspcli.geometry.shapes import Shapes
    from gspcli.machines.api import import_machine
    from gspcli.motion import Follower, track
    from gspcli.motion.paths.api import path
    from gspcli.motion.paths.nearest_poses import NearestPoses
    from gspcli.motion.poses.measured_values import measure
    from gspcli.motion.singularities.clearance_results import clearance
    from gspcli.motion.singularities.scan_results import scan
    from gspcli.motion.statics.freedoms import freedoms
    from gspcli.motion.workspace.box_division import workspace
    from gspcli.paper.comparison import table
    from gspcli.pictures.notebook import notebook_view
    from gspcli.pictures.whole_views import view
    from gspcli.reality.real_search import maximize_real
    from gspcli.reality.sample_results import sample
    from gspcli.sensing import fit_poses, fit_readings, sensors
    from gspcli.solver import certify, solve, solve_batch, solve_values
    from gspcli.spec import dump, dumps, load, loads, read, set_values
    from gspcli.spec.checks import check
    from gspcli.spec.shipped import example
    from gspcli.symbolic.derivation import derive

__version__ = "1.0.0"

#: Where each public name lives; nothing is imported before it is used.
_HOMES = {
    "Arm": "gspcli.geometry.masses",
    "ArgumentError": "gspcli.errors",
    "Carriage": "gspcli.geometry.masses",
    "Cone": "gspcli.geometry.primitives",
    "Constraint": "gspcli.geometry.instance",
    "Crank": "gspcli.geometry.primitives",
    "Drives": "gspcli.geometry.masses",
    "Dynamics": "gspcli.geometry.masses",
    "Family": "gspcli.catalogue.types",
    "Follower": "gspcli.motion",
    "Frame": "gspcli.geometry.home_pose",
    "Frames": "gspcli.geometry.home_pose",
    "GspError": "gspcli.errors",
    "GspType": "gspcli.catalogue.types",
    "HomePose": "gspcli.geometry.home_pose",
    "Instance": "gspcli.geometry.instance",
    "Leg": "gspcli.geometry.masses",
    "LegBody": "gspcli.geometry.masses",
    "Line": "gspcli.geometry.primitives",
    "NearestPoses": "gspcli.motion.paths.nearest_poses",
    "Number": "gspcli.geometry.numbers",
    "Plane": "gspcli.geometry.primitives",
    "Point": "gspcli.geometry.primitives",
    "PoseFrame": "gspcli.geometry.frames",
    "RigidBody": "gspcli.geometry.masses",
    "Shapes": "gspcli.geometry.shapes",
    "Slide": "gspcli.geometry.primitives",
    "SpecError": "gspcli.errors",
    "TypeList": "gspcli.catalogue.listing",
    "Units": "gspcli.geometry.instance",
    "all_types": "gspcli.catalogue.types",
    "analyze": "gspcli.dynamics.analyses",
    "angle": "gspcli.geometry.building",
    "atlas_summary": "gspcli.atlas.count_summary",
    "bound": "gspcli.catalogue.known_facts",
    "calibrate": "gspcli.calibration",
    "certify": "gspcli.solver",
    "check": "gspcli.spec.checks",
    "clearance": "gspcli.motion.singularities.clearance_results",
    "coincident_types": "gspcli.catalogue.coincidence",
    "constraint_facts": "gspcli.catalogue.constraints",
    "count": "gspcli.atlas.platform_counts",
    "derive": "gspcli.symbolic.derivation",
    "distance": "gspcli.geometry.building",
    "dump": "gspcli.spec",
    "dumps": "gspcli.spec",
    "example": "gspcli.spec.shipped",
    "exported": "gspcli.export.exported",
    "family_bounds": "gspcli.catalogue.bounds",
    "fit_poses": "gspcli.sensing",
    "fit_readings": "gspcli.sensing",
    "forward_dynamics": "gspcli.dynamics",
    "freedoms": "gspcli.motion.statics.freedoms",
    "hexapod": "gspcli.geometry.building",
    "identify": "gspcli.calibration.identifying",
    "import_machine": "gspcli.machines.api",
    "instance": "gspcli.geometry.building",
    "inverse_dynamics": "gspcli.dynamics",
    "load": "gspcli.spec",
    "loads": "gspcli.spec",
    "maximize_real": "gspcli.reality.real_search",
    "measure": "gspcli.motion.poses.measured_values",
    "mechanism": "gspcli.catalogue.mechanism",
    "natural_modes": "gspcli.dynamics",
    "new": "gspcli.geometry.random_instances",
    "notebook_view": "gspcli.pictures.notebook",
    "parse_class": "gspcli.catalogue.names",
    "parse_kind": "gspcli.catalogue.names",
    "parse_kind_set": "gspcli.catalogue.names",
    "parse_type": "gspcli.catalogue.names",
    "path": "gspcli.motion.paths.api",
    "read": "gspcli.spec",
    "sample": "gspcli.reality.sample_results",
    "scan": "gspcli.motion.singularities.scan_results",
    "sensors": "gspcli.sensing",
    "set_values": "gspcli.spec",
    "show": "gspcli.catalogue.known_facts",
    "simulate": "gspcli.dynamics",
    "solve": "gspcli.solver",
    "solve_batch": "gspcli.solver",
    "solve_values": "gspcli.solver",
    "table": "gspcli.paper.comparison",
    "track": "gspcli.motion",
    "type_bounds": "gspcli.catalogue.bounds",
    "view": "gspcli.pictures.whole_views",
    "workspace": "gspcli.motion.workspace.box_division",
}

__all__ = [
    "ArgumentError",
    "Arm",
    "Carriage",
    "Cone",
    "Constraint",
    "Crank",
    "Drives",
    "Dynamics",
    "Family",
    "Follower",
    "Frame",
    "Frames",
    "GspError",
    "GspType",
    "HomePose",
    "Instance",
    "Leg",
    "LegBody",
    "Line",
    "NearestPoses",
    "Number",
    "Plane",
    "Point",
    "PoseFrame",
    "RigidBody",
    "Shapes",
    "Slide",
    "SpecError",
    "TypeList",
    "Units",
    "__version__",
    "all_types",
    "analyze",
    "angle",
    "atlas_summary",
    "bound",
    "calibrate",
    "certify",
    "check",
    "clearance",
    "coincident_types",
    "constraint_facts",
    "count",
    "derive",
    "distance",
    "dump",
    "dumps",
    "example",
    "exported",
    "family_bounds",
    "fit_poses",
    "fit_readings",
    "forward_dynamics",
    "freedoms",
    "hexapod",
    "identify",
    "import_machine",
    "instance",
    "inverse_dynamics",
    "load",
    "loads",
    "maximize_real",
    "measure",
    "mechanism",
    "natural_modes",
    "new",
    "notebook_view",
    "parse_class",
    "parse_kind",
    "parse_kind_set",
    "parse_type",
    "path",
    "read",
    "sample",
    "scan",
    "sensors",
    "set_values",
    "show",
    "simulate",
    "solve",
    "solve_batch",
    "solve_values",
    "table",
    "track",
    "type_bounds",
    "view",
    "workspace",
]


#: Rooms that pages name after `import gspcli`.
_ROOMS = ("calibration", "dynamics", "geometry", "motion", "sensing", "spec")


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"gspcli.{name}")
    if name not in _HOMES:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
