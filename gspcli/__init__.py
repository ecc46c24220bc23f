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
    from gspcli.atlas.count_summary import atlas_summary as atlas_summary
    from gspcli.atlas.platform_counts import count as count
    from gspcli.calibration import calibrate as calibrate
    from gspcli.calibration.identifying import identify as identify
    from gspcli.catalogue.bounds import family_bounds as family_bounds
    from gspcli.catalogue.bounds import type_bounds as type_bounds
    from gspcli.catalogue.coincidence import coincident_types as coincident_types
    from gspcli.catalogue.constraints import constraint_facts as constraint_facts
    from gspcli.catalogue.known_facts import bound as bound
    from gspcli.catalogue.known_facts import show as show
    from gspcli.catalogue.listing import TypeList as TypeList
    from gspcli.catalogue.names import parse_class as parse_class
    from gspcli.catalogue.names import parse_kind as parse_kind
    from gspcli.catalogue.names import parse_kind_set as parse_kind_set
    from gspcli.catalogue.names import parse_type as parse_type
    from gspcli.catalogue.realization import mechanism as mechanism
    from gspcli.catalogue.types import Family as Family
    from gspcli.catalogue.types import GspType as GspType
    from gspcli.catalogue.types import all_types as all_types
    from gspcli.dynamics import inverse_dynamics as inverse_dynamics
    from gspcli.dynamics import natural_modes as natural_modes
    from gspcli.dynamics.analyses import analyze as analyze
    from gspcli.errors import ArgumentError as ArgumentError
    from gspcli.errors import GspError as GspError
    from gspcli.errors import SpecError as SpecError
    from gspcli.export.formats import exported as exported
    from gspcli.geometry.building import angle as angle
    from gspcli.geometry.building import distance as distance
    from gspcli.geometry.building import hexapod as hexapod
    from gspcli.geometry.building import instance as instance
    from gspcli.geometry.frames import PoseFrame as PoseFrame
    from gspcli.geometry.instance import Constraint as Constraint
    from gspcli.geometry.instance import Frame as Frame
    from gspcli.geometry.instance import Frames as Frames
    from gspcli.geometry.instance import HomePose as HomePose
    from gspcli.geometry.instance import Instance as Instance
    from gspcli.geometry.instance import Shapes as Shapes
    from gspcli.geometry.instance import Units as Units
    from gspcli.geometry.masses import Arm as Arm
    from gspcli.geometry.masses import Carriage as Carriage
    from gspcli.geometry.masses import Drives as Drives
    from gspcli.geometry.masses import Dynamics as Dynamics
    from gspcli.geometry.masses import Leg as Leg
    from gspcli.geometry.masses import LegBody as LegBody
    from gspcli.geometry.masses import RigidBody as RigidBody
    from gspcli.geometry.numbers import Number as Number
    from gspcli.geometry.primitives import Cone as Cone
    from gspcli.geometry.primitives import Crank as Crank
    from gspcli.geometry.primitives import Line as Line
    from gspcli.geometry.primitives import Plane as Plane
    from gspcli.geometry.primitives import Point as Point
    from gspcli.geometry.primitives import Slide as Slide
    from gspcli.geometry.random_instances import new as new
    from gspcli.machines.api import import_machine as import_machine
    from gspcli.motion import Follower as Follower
    from gspcli.motion import track as track
    from gspcli.motion.paths.nearest_poses import NearestPoses as NearestPoses
    from gspcli.motion.paths.planner import path as path
    from gspcli.motion.poses.measured_values import measure as measure
    from gspcli.motion.singularities.clearances import clearance as clearance
    from gspcli.motion.singularities.scans import scan as scan
    from gspcli.motion.statics.freedoms import freedoms as freedoms
    from gspcli.motion.workspace.workspaces import workspace as workspace
    from gspcli.paper.tables import table as table
    from gspcli.pictures.page import notebook_view as notebook_view
    from gspcli.pictures.whole_views import view as view
    from gspcli.reality.real_distribution import sample as sample
    from gspcli.reality.real_search import maximize_real as maximize_real
    from gspcli.sensing import fit_poses as fit_poses
    from gspcli.sensing import fit_readings as fit_readings
    from gspcli.sensing import sensors as sensors
    from gspcli.solver import certify as certify
    from gspcli.solver import solve as solve
    from gspcli.solver import solve_batch as solve_batch
    from gspcli.solver import solve_values as solve_values
    from gspcli.spec import dump as dump
    from gspcli.spec import dumps as dumps
    from gspcli.spec import load as load
    from gspcli.spec import loads as loads
    from gspcli.spec import read as read
    from gspcli.spec import set_values as set_values
    from gspcli.spec.checks import check as check
    from gspcli.spec.reading import example as example
    from gspcli.symbolic.derivation import derive as derive

__version__ = "1.0.0"

#: The public names by their modules; nothing is imported before it is used.
_NAMES = {
    "gspcli.atlas.count_summary": "atlas_summary",
    "gspcli.atlas.platform_counts": "count",
    "gspcli.calibration": "calibrate",
    "gspcli.calibration.identifying": "identify",
    "gspcli.catalogue.bounds": "family_bounds type_bounds",
    "gspcli.catalogue.coincidence": "coincident_types",
    "gspcli.catalogue.constraints": "constraint_facts",
    "gspcli.catalogue.known_facts": "bound show",
    "gspcli.catalogue.listing": "TypeList",
    "gspcli.catalogue.names": "parse_class parse_kind parse_kind_set parse_type",
    "gspcli.catalogue.realization": "mechanism",
    "gspcli.catalogue.types": "Family GspType all_types",
    "gspcli.dynamics": "inverse_dynamics natural_modes",
    "gspcli.dynamics.analyses": "analyze",
    "gspcli.errors": "ArgumentError GspError SpecError",
    "gspcli.export.formats": "exported",
    "gspcli.geometry.building": "angle distance hexapod instance",
    "gspcli.geometry.frames": "PoseFrame",
    "gspcli.geometry.instance": "Constraint Frame Frames HomePose Instance Shapes Units",
    "gspcli.geometry.masses": "Arm Carriage Drives Dynamics Leg LegBody RigidBody",
    "gspcli.geometry.numbers": "Number",
    "gspcli.geometry.primitives": "Cone Crank Line Plane Point Slide",
    "gspcli.geometry.random_instances": "new",
    "gspcli.machines.api": "import_machine",
    "gspcli.motion": "Follower track",
    "gspcli.motion.paths.nearest_poses": "NearestPoses",
    "gspcli.motion.paths.planner": "path",
    "gspcli.motion.poses.measured_values": "measure",
    "gspcli.motion.singularities.clearances": "clearance",
    "gspcli.motion.singularities.scans": "scan",
    "gspcli.motion.statics.freedoms": "freedoms",
    "gspcli.motion.workspace.workspaces": "workspace",
    "gspcli.paper.tables": "table",
    "gspcli.pictures.page": "notebook_view",
    "gspcli.pictures.whole_views": "view",
    "gspcli.reality.real_distribution": "sample",
    "gspcli.reality.real_search": "maximize_real",
    "gspcli.sensing": "fit_poses fit_readings sensors",
    "gspcli.solver": "certify solve solve_batch solve_values",
    "gspcli.spec": "dump dumps load loads read set_values",
    "gspcli.spec.checks": "check",
    "gspcli.spec.reading": "example",
    "gspcli.symbolic.derivation": "derive",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}

__all__ = ["__version__", *sorted(_HOMES)]


#: Packages that pages name after `import gspcli`.
_PACKAGES = ("calibration", "dynamics", "geometry", "motion", "sensing", "spec")


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return import_module(f"gspcli.{name}")
    if name not in _HOMES:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
