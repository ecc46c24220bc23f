"""`gsp freedoms`: which twists constraints leave, and which constraints are redundant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import Command, Options, option, output_options
from gspcli.cli.pose_options import pose_options, pose_value_option
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import refuse_to_replace, spec_source
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion.statics.freedoms import Freedoms

FIELDS = Fields("freedoms")

#: At most this many candidates are shown without --all.
_SHOWN = 12
#: A stated value that differs by more than this part of the largest is reported.
_OFF = 1e-6


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC")
@pose_value_option(".  [default: home]")
@pose_options
@option("--all", "Show every constraint that could be added.", name="everything")
@output_options()
def command(o: Options) -> None:
    """Say which freedoms any number of constraints leave, and which are redundant.

    SPEC is an instance file with any number of constraints, fewer or more than six. Each freedom at
    the pose (home by default) is a screw or a translation. A screw has an axis, and a length by
    which the platform moves along it in one turn. If there are several, a basis is shown.
    Coincident points, points on lines and parallel directions (values of 0 or 180) count with all
    the freedoms that they remove.

    A second table has the constraints that could be added between primitives of the file: how many
    freedoms each would remove, and which of the screws it restrains. The answer holds at this pose
    and to first order; ranks are numerical.

    \b
    Examples:
      gsp freedoms @workspace-study
      gsp freedoms sketch.yaml --pose 0,0,0,1,0,0,0
    """
    from gspcli.motion.statics.freedoms import freedoms
    from gspcli.spec import read

    refuse_to_replace(o.spec)
    instance = read(spec_source(o.spec), name=o.spec, any_number=True).instance
    if o.pose is not None:
        R, T = o.pose.read(o.form_of(instance))
        instance = _moved(instance, R, T)
    elif o.conventions:
        raise click.UsageError(f"{o.conventions[0]} says how --pose is read: give --pose, too")
    else:
        R, T = _home(instance)
    result = freedoms(instance, R, T)
    readable = o.output.format not in ("csv", "json")
    tables = _tables(result, everything=o.everything, readable=readable)
    emit(o.output, tables, document={"schema": "gsp.freedoms/1", **result.to_json()})


def _moved(instance: Instance, R: Any, T: Any) -> Instance:
    """Return the platform with its joints where cranks and slides have them at a pose.

    It is returned unchanged if it has none, or they do not reach the pose.
    """
    if len(instance.constraints) != 6:
        return instance
    import numpy as np

    from gspcli.motion.poses.inverse_kinematics import drive_values

    machine, q = drive_values(instance, R[None], T[None], along=False)
    reached = machine.moves and np.isfinite(q).all()
    return machine.instance_at(q[0]) if reached else instance


def _home(instance: Instance) -> tuple[Any, Any]:
    """Return the home pose: of six constraints the home mode, else as it is stated."""
    if len(instance.constraints) == 6:
        from gspcli.solver import solve

        home = solve(instance).home
        if home is not None:
            return home.R, home.T
    if instance.home is None:
        raise GspError("SPEC states no home: give --pose x,y,z,qw,qx,qy,qz, or `home` in SPEC")
    return None, None


def _tables(found: Freedoms, *, everything: bool, readable: bool) -> list[Result]:
    """Return the free screws, and the constraints that would remove freedoms."""
    unit = found.instance.units.length
    lines = list(found.sentences)
    size = max((abs(row.value.value) for row in found.instance.constraints), default=0.0)
    wrong = [k for k, off in enumerate(found.off.tolist(), 1) if abs(off) > _OFF * (size or 1)]
    if wrong:
        names = ", ".join(map(str, wrong))
        lines.append(f"this pose does not meet the stated value of {names}: it counts as movable")
    rows = [{"number": k, "freedom": screw.words(unit)} for k, screw in enumerate(found.screws, 1)]
    columns = FIELDS.of("number freedom" if rows or not readable else "")
    kinds = " ".join(row.kind.name for row in found.instance.constraints)
    title = f"{found.instance.name}: {kinds}" if found.instance.name else kinds
    tables = [Result(columns, rows, title, summary=lines, part="freedoms")]
    shown = found.candidates if everything else found.candidates[:_SHOWN]
    if not shown or not readable:
        return tables
    others = len(found.candidates) - len(shown)
    notes = [f"{others} more: --all shows them"] if others else []
    more = [
        {
            "constraint": one.name,
            "kind": one.kind.name,
            "removes": one.removes,
            "restrains": " ".join(map(str, one.touches)),
        }
        for one in shown
    ]
    columns = FIELDS.of("constraint kind removes restrains")
    return [*tables, Result(columns, more, notes=notes, part="candidates")]
