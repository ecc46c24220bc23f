"""`gsp realize`: a platform as a mechanism of links and joints."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.catalogue.coincidence import coincident_types, over_constraint, parse_sharing
from gspcli.catalogue.names import find_alias, parse_kinds, parse_type
from gspcli.catalogue.realization import REALIZATIONS, alternative, mechanism, outside
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.cli.options import DRAWINGS, FORMATS, Command, Options, option, output_options
from gspcli.cli.render import emit, write
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import is_file, load_instance
from gspcli.cli.streams import working
from gspcli.errors import GspError, TypeNameError

if TYPE_CHECKING:
    from gspcli.catalogue.coincidence import Connection
    from gspcli.catalogue.kinds import Kind
    from gspcli.catalogue.realization import Mechanism, MountedChain, Realization
    from gspcli.catalogue.types import GspType

FIELDS = Fields("realize")

_BOND = re.compile(r"[PLH]\d+[-^]")

_COLUMNS = FIELDS.of(
    "number kinds platform base chain constraints joint_freedoms idle_freedoms idle_motion "
    "alternative outside held_freedoms figure"
)


@click.command(cls=Command)
@click.argument("names", nargs=-1, required=True, metavar="TYPE|PATTERN|SPEC")
@option(
    "--realization",
    "Chains of the paper's figures; chains without idle freedoms; or chains with all driven joints "
    "at the base (Figure 8).",
    name="chosen",
    type=click.Choice(list(REALIZATIONS)),
    default=next(iter(REALIZATIONS)),
)
@output_options(formats=(*FORMATS, *DRAWINGS))
def command(o: Options) -> None:
    """Show a mechanism that realizes a platform: a chain of joints for each constraint.

    A TYPE has distinct primitives; a PATTERN names those that constraints share
    (P1-p2 is a distance, L1^l2 an angle); a SPEC is an instance file, or - for standard
    input. DLL and ALL between the same two lines make one chain with two driven joints.

    Joints: R revolute, P prismatic, C cylindrical, S spherical, E planar; * is driven. Σf is the
    sum of their freedoms. Idle freedoms do not move the platform. The column held has the freedoms
    of the platform that a chain permits while its driven joints do not move.

    The suffix svg, png or pdf gives a drawing (needs matplotlib): of a SPEC the whole mechanism in
    its home mode, of a TYPE, a PATTERN or single kinds such as PL the chains.

    \b
    Examples:
      gsp realize DPL DPL DPL ALL ALL ALL
      gsp realize 6PP --format markdown
      gsp realize "L1-l3 L1^l3 L2-l4 L2^l4 L1^l4 L2-l3"
      gsp realize platform.yaml --realization outside -o mechanism.svg
    """
    if o.output.format in DRAWINGS and (kinds := _kinds(o.names)):
        from gspcli.pictures.mechanisms import chain_drawing

        headed = [(kind.name, REALIZATIONS[o.chosen](kind)) for kind in kinds]
        write(o.output, chain_drawing(headed, o.output.format))
        return
    title, gsp_type, connections = _platform(o.names)
    built = mechanism(connections, REALIZATIONS[o.chosen])
    if o.output.format in DRAWINGS:
        whole = len(o.names) == 1 and is_file(o.names[0])
        drawn = _platform_drawn(o.names[0], built, o.output.format) if whole else None
        write(o.output, drawn or _chains_drawn(built, o.output.format))
        return
    dependent = over_constraint(connections)
    reason = dependent.reason if dependent else None
    notes = [built.sum_shown]
    notes += [f"{s.name}: {s.joints} (chains {_numbers(s.chains)})" for s in built.shared]
    notes += [f"the platform is never fixed: {reason}"] if reason else []
    notes += _driven_joints(o.names)
    chains = [_entry(mounted) for mounted in built.chains]
    rows = list(map(_row, itertools.count(1), chains, built.chains))
    document: dict[str, Any] = {"schema": "gsp.realize/1", "type": gsp_type.to_json()}
    document["chains"] = chains
    document["shared"] = [
        {"body": one.body, "name": one.name, "joints": one.joints, "chains": _from_one(one.chains)}
        for one in built.shared
    ]
    document["mobility"] = {
        "links": built.links,
        "joints": built.joints,
        "joint_freedoms": built.joint_freedoms,
        "kutzbach_gruebler": built.mobility,
        "idle_freedoms": built.idle_freedoms,
        "moving_freedoms": built.moving_freedoms,
        "driven": built.driven,
        "sum": built.sum_shown,
    }
    document["over_constraint"] = reason
    emit(o.output, Result(_COLUMNS, rows, title=title, notes=notes), document=document)


def _driven_joints(names: Sequence[str]) -> list[str]:
    """Return the note that the cranks and slides of a file are in no chain, if there are some."""
    if len(names) != 1 or not is_file(names[0]):
        return []
    from gspcli.geometry.machine import driven_points

    rows = load_instance(names[0]).constraints
    driven = [k for k, row in enumerate(rows) if driven_points(row)]
    if not driven:
        return []
    chains = f"chain{'s' if len(driven) > 1 else ''} {_numbers(driven)}"
    return [f"{chains}: SPEC drives a joint by a crank or slide; here the constraint is driven"]


def _kinds(names: Sequence[str]) -> list[Kind]:
    """Return the kinds of constraint that are named, if they are fewer than a platform has."""
    words = " ".join(names).split()
    if len(words) >= CONSTRAINTS:
        return []
    try:
        return [kind for word in words for kind in parse_kinds(word)]
    except TypeNameError:
        return []


def _platform(names: Sequence[str]) -> tuple[str, GspType, Sequence[Connection]]:
    """Return the title, the type and the constraints that the words name."""
    if len(names) == 1 and is_file(names[0]):
        instance = load_instance(names[0])
        title = f"{instance.name}: {instance.type}" if instance.name else str(instance.type)
        return title, instance.type, instance.constraints
    text = " ".join(names)
    alias = find_alias(text)
    if _BOND.match(text) or (alias and alias.pattern):
        pattern = parse_sharing(text)
        return f"{pattern.type} ({pattern.id})", pattern.type, pattern.bonds
    gsp_type = parse_type(names)
    return f"{gsp_type.id} ({gsp_type.number})", gsp_type, next(coincident_types(gsp_type)).bonds


def _platform_drawn(spec: str, built: Mechanism, fmt: str) -> bytes:
    """Return the drawing of an instance on its chains."""
    from gspcli.pictures.mechanisms import mechanism_drawing
    from gspcli.pictures.stage import first_mode, scene_of
    from gspcli.solver import solve

    instance = load_instance(spec)
    with working("solving"):
        result = solve(instance)
    if not result.drawn.counts.real:
        raise GspError(
            f"{spec}: no real pose to draw the mechanism at; name its type for the chains"
        )
    scene = scene_of(result, only=first_mode(result.drawn))
    return mechanism_drawing(scene, built, fmt, 0)


def _chains_drawn(built: Mechanism, fmt: str) -> bytes:
    """Return the drawing of the different chains of a mechanism."""
    from gspcli.pictures.mechanisms import chain_drawing

    used: dict[Realization, list[int]] = {}
    for index, mounted in enumerate(built.chains):
        used.setdefault(mounted.realization, []).append(index)
    headings = {
        each: f"{' '.join(kind.name for kind in each.kinds)}: "
        f"chain{'s' if len(indices) > 1 else ''} {_numbers(indices)}"
        for each, indices in used.items()
    }
    return chain_drawing([(heading, each) for each, heading in headings.items()], fmt)


def _numbers(indices: Sequence[int]) -> str:
    return " ".join(map(str, _from_one(indices)))


def _from_one(indices: Sequence[int]) -> list[int]:
    return [index + 1 for index in indices]


def _entry(mounted: MountedChain) -> dict[str, Any]:
    """Return a chain and the other chains for the same constraints, for JSON."""
    kinds = mounted.realization.kinds
    return {
        "constraints": _from_one(mounted.constraints),
        "kinds": [kind.name for kind in kinds],
        "platform": mounted.platform_name,
        "base": mounted.base_name,
        **_chain(mounted.realization),
        "alternative": _chain(alternative(*kinds)),
        "outside": _chain(outside(*kinds)),
    }


def _chain(realization: Realization) -> dict[str, Any]:
    return {
        "chain": realization.chain.name,
        "description": realization.description,
        "figure": realization.figure or None,
        "joint_freedoms": realization.chain.freedoms,
        "idle_freedoms": realization.idle_freedoms,
        "idle_motion": realization.idle_motion or None,
        "freedoms": realization.freedoms,
        "held_freedoms": realization.held_freedoms,
    }


def _row(number: int, entry: dict[str, Any], mounted: MountedChain) -> dict[str, Any]:
    """Return a chain for a table: lists in one cell, driven joints starred."""
    row = entry | {"number": number, "chain": mounted.realization.chain.drawing}
    row |= {key: " ".join(map(str, entry[key])) for key in ("constraints", "kinds")}
    return row | {key: entry[key]["chain"] for key in ("alternative", "outside")}
