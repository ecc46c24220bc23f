"""`gsp track`: where the assembly modes go while the values change."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.limit_sentences import cones_notes, limit_sentences, plain_limit
from gspcli.cli.names import load_instance
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.cli.pose_options import pose_format, pose_options, text_of
from gspcli.cli.progress_bars import working
from gspcli.cli.requirements import refuse, require_option, required
from gspcli.cli.track_requirements import judged_track, track_entries, track_lines
from gspcli.errors import GspError, IncompleteError
from gspcli.wording import counted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion import Event, Track
    from gspcli.motion.following.limit_events import LimitEvent

    Array = NDArray[np.float64]

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


@click.command()
@click.argument("spec", metavar="SPEC")
@click.argument("values", metavar="VALUES")
@click.option("--mode", type=click.IntRange(min=1), metavar="K", help="Follow only mode K.")
@click.option(
    "--near", metavar="NUMBERS", help="Follow only the mode nearest to x,y,z,qw,qx,qy,qz."
)
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Write N rows for each row of VALUES, evenly between it and the next one.",
)
@click.option("--delta", is_flag=True, help="VALUES are added to those of SPEC.")
@click.option(
    "--all",
    "everything",
    is_flag=True,
    help="Compare with all poses at the last row; follow those born on the way, too.",
)
@click.option("--allow-loss", is_flag=True, help="Exit with 0 though a mode ends on the way.")
@click.option(
    "--clearance",
    "clear",
    is_flag=True,
    help="Add how far all values may change with proof that nothing is singular (gsp clearance).",
)
@click.option(
    "--pose-clearance",
    "pose_clear",
    is_flag=True,
    help="Add how far the pose may move, whatever the values, with proof that its screws stay "
    "independent (gsp clearance --of pose).",
)
@click.option("--no-certify", is_flag=True, help="Do not prove that no branch is changed.")
@require_option("range, cone, clearance>=0.5, condition<=50")
@pose_options
@click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True, metavar="N", help="Threads."
)
@output_options()
def command(
    spec: str,
    values: str,
    mode: int | None,
    near: str | None,
    steps: int,
    delta: bool,
    everything: bool,
    allow_loss: bool,
    clear: bool,
    pose_clear: bool,
    no_certify: bool,
    require: str | None,
    euler: str | None,
    pivot: str | None,
    jobs: int,
    output: Output,
) -> None:
    """Follow assembly modes while the values change, and prove that none jumps.

    SPEC is an instance file, VALUES a CSV file with a heading: columns 1 to 6 (those left out keep
    the value of SPEC), and perhaps t; or a file of poses as `gsp measure` takes it, which is
    measured. One of them may be - for standard input. The values change linearly between rows;
    distances to planes (DPH, DHP) are signed.

    Not only values move: columns base.NAME.x, platform.NAME.y, base.NAME.direction.z and
    base.NAME.normal.x are coordinates of a point, line or plane, and crank.NAME is the angle of
    the crank that turns a point, if SPEC states one. They are linear between rows, too: the point
    of a crank moves on its circle.

    All real poses at the first row are followed, numbered as `gsp solve` orders them. Each row of
    the output is one mode at one row of VALUES: position and unit quaternion of the platform
    (x_base = R x_platform + T) and the condition number. It is proved for every part between the
    rows that the mode is the only one near, so that it cannot be mistaken for another. Where
    a mode meets another and both vanish (a fold), t is proved to ten digits or more. What happens
    between rows is told on standard error, or under events in JSON.

    Where values leave their ranges and legs the cones of their joints (`range`, `cone` in SPEC) is
    told, too. It is proved for all that is between rows; without proof (--no-certify) cones are
    only looked at where the rows are.

    With --require the worst row of each is named, and the exit code is 1 unless all rows keep it;
    range and cone must be kept between the rows, too.

    The exit code is 4 if a mode ends before the last row, unless with --allow-loss.

    \b
    Examples:
      gsp track platform.yaml values.csv -o poses.csv
      gsp track platform.yaml path.csv --euler ZYX --mode 1 --format json
      gsp track rotary.yaml angles.csv --steps 10
      gsp track platform.yaml path.csv --mode 1 --require "cone, clearance>=0.5"
      gsp track platform.yaml values.csv --all --allow-loss
      gsp track platform.yaml values.csv --steps 20 --format csv |
        gsp view platform.yaml --track -
    """
    if mode is not None and near is not None:
        message = "give either --mode or --near"
        raise click.UsageError(message)
    if spec == values == "-":
        message = "SPEC and VALUES cannot both be standard input"
        raise click.UsageError(message)
    from gspcli.motion import read_pose, read_values, track
    from gspcli.motion.following.limit_events import limit_events
    from gspcli.motion.singularities.clearances import clearances, range_weights
    from gspcli.motion.singularities.pose_clearances import pose_clearances

    instance = load_instance(spec)
    requirements = required(require)
    form = pose_format(instance, euler, pivot)
    table = read_values(*text_of(values), instance, form, delta=delta).subdivided(steps)
    pose = None
    if near is not None:
        given = read_pose(near, form, "--near")
        pose = given.R[0], given.T[0]
    with working("following"):
        result = track(
            instance,
            table.values,
            coordinates=table.coordinates,
            t=table.t,
            modes=None if mode is None else [mode],
            near=pose,
            everything=everything,
            certify=not no_certify,
            jobs=jobs,
        )
    if not len(result.modes) and not everything:
        message = (
            "there is no real pose at the first row\n"
            "begin with other values, or use --all for modes that are born on the way"
        )
        raise GspError(message)
    with working("looking at limits"):
        limits = limit_events(result)
    more = {}
    with working("looking for singularities"):
        asked = {one.quantity for one in requirements}
        if clear or "clearance" in asked:
            weighted = partial(clearances, weights=range_weights(instance))
            more["clearance"] = _of_poses(result, weighted)
        if pose_clear or "pose-clearance" in asked:
            more["pose_clearance"] = _of_poses(result, pose_clearances)
    rows = _rows(result, more)
    verdicts, columns = judged_track(result, limits, requirements, rows)
    emit(
        output,
        _table(result, rows, limits, columns, track_lines(verdicts, rows, steps)),
        document=_document(result, rows, limits) | track_entries(verdicts, rows, steps),
    )
    if output.format != "json":
        for event in result.events:
            click.echo(_sentence(event), err=True)
        for line in limit_sentences(result, limits):
            click.echo(line, err=True)
    if result.complete is False:
        message = (
            "the modes followed and the poses at the last row do not account for each other\n"
            "give more rows, or try --jobs 1 with a smaller step"
        )
        raise IncompleteError(message)
    if result.ends and not allow_loss:
        names = ", ".join(str(event.mode) for event in result.ends)
        many = len(result.ends) > 1
        message = (
            f"mode{'s' if many else ''} {names} end{'' if many else 's'} before the last row\n"
            "use --allow-loss if that is expected"
        )
        raise IncompleteError(message)
    refuse(verdicts)


def _of_poses(result: Track, bound: Callable[[Instance, Array, Array], Array]) -> Array:
    """Return what is bounded at each pose, shape (m, r); NaN where a mode is not."""
    import numpy as np

    found = np.full(result.T.shape[:2], np.nan)
    for rows, instance in result.instances():
        there = np.zeros(found.shape, bool)
        there[:, rows] = ~np.isnan(result.T[:, rows, 0])
        found[there] = bound(instance, result.R[there], result.T[there])
    return found


def _rows(result: Track, more: Mapping[str, Array]) -> list[dict[str, Any]]:
    """Return a row for each pose, with more numbers, each of shape (m, r)."""
    rows = []
    for k, t in enumerate(result.t.tolist()):
        for m, mode in enumerate(result.modes.tolist()):
            T = result.T[m, k]
            if T[0] != T[0]:
                continue
            pose = [*T.tolist(), *result.quaternions[m, k].tolist()]
            condition = float(result.conditions[m, k])
            rows.append(
                {
                    "t": t,
                    "mode": mode,
                    **dict(zip(_POSE, pose, strict=True)),
                    "condition": condition,
                    **{key: float(numbers[m, k]) for key, numbers in more.items()},
                }
            )
    return rows


def _table(
    result: Track,
    rows: list[dict[str, Any]],
    limits: list[LimitEvent],
    more: list[Column],
    summary: list[str],
) -> Table:
    columns = [
        Column(key, align="right", essential=True, aligned=key in _POSE)
        for key in ("t", "mode", *_POSE)
    ]
    columns.append(Column("condition", align="right"))
    columns += [
        Column(key, key.replace("_", " "), align="right", essential=True)
        for key in ("clearance", "pose_clearance")
        if rows and key in rows[0]
    ]
    columns += more
    names = [one.name for one in result.coordinates]
    columns += [Column(name, align="right", minor=1) for name in names]
    at = {t: dict(zip(names, place, strict=True)) for t, place in _places(result)}
    rows = [{**row, **at[row["t"]]} for row in rows]
    instance = result.instance
    title = instance.title
    kept = len(result.modes) - len(result.events)
    how = "proved" if result.certified else "not proved"
    note = (
        f"{counted(len(result.modes), 'mode')}, {kept} of them from the first row to the last; "
        f"{counted(result.segments, 'part')}, {how}"
    )
    if result.complete:
        note += "; every real pose at the last row is accounted for"
    notes = [note, *cones_notes(result, limits)]
    return Table(columns, rows, title=title, notes=notes, summary=summary)


def _places(result: Track) -> Iterator[tuple[float, list[float]]]:
    """Yield t and the coordinates that move at each row."""
    return zip(result.t.tolist(), result.places.tolist(), strict=True)


def _document(
    result: Track, rows: list[dict[str, Any]], limits: list[LimitEvent]
) -> dict[str, Any]:
    instance = result.instance
    return {
        "schema": "gsp.track/1",
        **instance.to_json(),
        "certified": result.certified,
        "complete": result.complete,
        "modes": result.modes.tolist(),
        "coordinates": {
            one.name: result.places[:, k].tolist() for k, one in enumerate(result.coordinates)
        },
        "parts": result.segments,
        "poses": rows,
        "events": [_plain(event) for event in result.events],
        "limits": [plain_limit(event) for event in limits],
    }


def _plain(event: Event) -> dict[str, Any]:
    return {
        "kind": event.kind,
        "reason": event.reason,
        "begins": event.begins,
        "mode": event.mode,
        "partner": event.partner,
        "row": event.row + 1,
        "t": [event.low, event.high],
        "R": _finite(event.R),
        "T": _finite(event.T),
        "partner_R": None if event.partner_R is None else event.partner_R.tolist(),
        "partner_T": None if event.partner_T is None else event.partner_T.tolist(),
    }


def _finite(part: Array) -> Any:
    """Return a part of a pose; None at infinity, where there is none."""
    import numpy as np

    return part.tolist() if np.isfinite(part).all() else None


def _sentence(event: Event) -> str:
    if event.kind == "undecided":
        what = "cannot be followed back before" if event.begins else "cannot be followed beyond"
        t = event.high if event.begins else event.low
        return f"mode {event.mode} {what} t = {t:.10g}: {event.reason} (undecided)"
    partner = "another" if event.partner is None else f"mode {event.partner}"
    if event.begins:
        return f"mode {event.mode} begins with {partner} in a fold at t = {event.low:.12g}, proved"
    return f"mode {event.mode} meets {partner} in a fold at t = {event.low:.12g} and ends, proved"
