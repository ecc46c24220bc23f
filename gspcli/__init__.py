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
    from gspcli.catalogue.bounds import family_bounds, type_bounds
    from gspcli.catalogue.coincidence import coincident_types
    from gspcli.catalogue.constraints import constraint_facts
    from gspcli.catalogue.listing import TypeList
    from gspcli.catalogue.mechanism import mechanism
    from gspcli.catalogue.parsing import parse_class, parse_kind, parse_kind_set, parse_type
    from gspcli.catalogue.types import Family, GspType, all_types
    from gspcli.certification import certify
    from gspcli.errors import GspError
    from gspcli.geometry.instance import Instance
    from gspcli.motion import measure
    from gspcli.solver import solve, solve_values
    from gspcli.spec import dumps, load, loads, set_values

__version__ = "0.1.0"

#: Where each public name lives; nothing is imported before it is used.
_HOMES = {
    "Family": "gspcli.catalogue.types",
    "GspError": "gspcli.errors",
    "GspType": "gspcli.catalogue.types",
    "Instance": "gspcli.geometry.instance",
    "TypeList": "gspcli.catalogue.listing",
    "all_types": "gspcli.catalogue.types",
    "certify": "gspcli.certification",
    "coincident_types": "gspcli.catalogue.coincidence",
    "constraint_facts": "gspcli.catalogue.constraints",
    "dumps": "gspcli.spec",
    "family_bounds": "gspcli.catalogue.bounds",
    "load": "gspcli.spec",
    "loads": "gspcli.spec",
    "measure": "gspcli.motion",
    "mechanism": "gspcli.catalogue.mechanism",
    "parse_class": "gspcli.catalogue.parsing",
    "parse_kind": "gspcli.catalogue.parsing",
    "parse_kind_set": "gspcli.catalogue.parsing",
    "parse_type": "gspcli.catalogue.parsing",
    "set_values": "gspcli.spec",
    "solve": "gspcli.solver",
    "solve_values": "gspcli.solver",
    "type_bounds": "gspcli.catalogue.bounds",
}

__all__ = [
    "Family",
    "GspError",
    "GspType",
    "Instance",
    "TypeList",
    "__version__",
    "all_types",
    "certify",
    "coincident_types",
    "constraint_facts",
    "dumps",
    "family_bounds",
    "load",
    "loads",
    "measure",
    "mechanism",
    "parse_class",
    "parse_kind",
    "parse_kind_set",
    "parse_type",
    "set_values",
    "solve",
    "solve_values",
    "type_bounds",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
