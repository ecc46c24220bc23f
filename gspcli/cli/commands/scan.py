"""`gsp scan`: how many assembly modes there are where values or drives vary."""

from __future__ import annotations

import hashlib
from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gspcli import __version__
from gspcli.cli.options import (
    DRAWINGS,
    FORMATS,
    Command,
    Options,
    output_options,
    resume_option,
    value_options,
    worker_options,
)
from gspcli.cli.pose_options import PARAMETERS, axes_of, frame_note, pose_options, pose_value_option
from gspcli.cli.render import emit, write
from gspcli.cli.result import Fields, Result
from gspcli.cli.streams import progress, say, working
from gspcli.defaults import SEED
from gspcli.errors import INTERRUPTED, ArgumentError, GspError, IncompleteError
from gspcli.wording import counted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion.singularities.scans import Axis, Boundary, Scan
    from gspcli.workers import Workers

    Array = NDArray[np.float64]
    from gspcli.geometry.frames import PoseFrame
    from gspcli.motion.singularities.scans import Meeting, PoseScan, ScanResult

FIELDS = Fields("scan")

QUANTITIES = ("modes", "condition", "clearance")
_NUMBERS = tuple("123456")


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC")
@click.option(
    "--vary",
    "texts",
    metavar="NAME=LOW:HIGH:COUNT",
    multiple=True,
    required=True,
    help="Let NAME take COUNT values from LOW to HIGH: a constraint from 1 to 6, a crank or slide "
    "such as crank.B1, or, with --pose, x, y, z (rx, ry, rz with --euler); once or twice.",
)
@pose_value_option("the pose whose coordinates vary; the other coordinates stay")
@value_options
@pose_options
@click.option(
    "--folds",
    is_flag=True,
    help="Find, with proof, where the number changes between neighbouring nodes. Tables show "
    "these folds instead of the nodes, pictures both.",
)
@click.option(
    "--quantity",
    type=click.Choice(QUANTITIES),
    default=QUANTITIES[0],
    help="The quantity of pictures (over poses the determinant instead of modes). With clearance "
    "it is a column, too (some milliseconds a mode or pose).",
)
@resume_option
@worker_options
@output_options(formats=(*FORMATS, *DRAWINGS))
def command(o: Options) -> int:
    """Count the real assembly modes where one or two values or drives vary.

    All poses are found at every node of the grid. The column modes has the number of real ones,
    condition the smallest condition number of one.

    --folds gives the values or readings at which a pair of modes meets and vanishes (a fold),
    between neighbouring nodes with different numbers. Each fold is proved, and shown with its
    pose. Mirror images have one fold each, at the same values. Two folds between the same nodes
    that leave the number unchanged are found from complex solutions, without proof that none is
    missed.
    Where symmetries let several modes meet at once, there is no simple fold: it is said how many
    meet, and between which values; the numbers on both sides are proved. Over two values or drives
    the folds are points of a curve (the discriminant), which pictures show with its cusps. Between
    the proved points the curve is followed numerically, without proof.

    For a machine with arms or rails the readings of its drives vary (crank.B1, slide.B1). At each
    node the joints are moved there, and the other drives stay where they are stated. The
    clearance is that of the drives, as in `gsp clearance`.

    Over poses (--pose) nothing is solved. Each node has the determinant of the Jacobian matrix
    (free of units, as in `gsp analyze`), its sign and the condition number. --folds gives the poses
    on edges of the grid at which the determinant changes its sign, to the last digit; pictures show
    the singular curve through them.

    Ctrl-C shows the result so far; a file of -o is not written then. If not all poses were found at
    a node, it has no number of modes, and the exit code is 4.

    \b
    Examples:
      gsp scan platform.yaml --vary 1=5:7:200 -o modes.csv
      gsp scan platform.yaml --vary 1=5:7:60 --vary 2=4:6:60 --folds -o folds.csv
      gsp scan @t-top-head --vary crank.B1=-60:60:13 --folds
      gsp scan platform.yaml --vary 1=5:7:60 --vary 2=4:6:60 --folds -o map.svg
      gsp scan platform.yaml --vary 1=5:7:500 --resume work.jsonl -o map.csv
      gsp scan platform.yaml --vary x=-9:9:60 --vary y=-9:9:60 \\
        --pose 0,0,7,1,0,0,0 -o singular.svg
    """
    instance = o.instance
    frame = o.frame_of(instance)
    if o.pose is not None:
        shown = "determinant" if o.quantity == QUANTITIES[0] else o.quantity
        _scan_poses(o, shown)
        return 0
    _refuse_coordinates(o)
    from gspcli.motion.singularities.scans import MISSING, Boundary, Scan, ScanResult

    axes = _axes(instance, o.texts)
    try:
        found = Scan.empty(instance, axes, clearance=o.quantity == "clearance")
    except ArgumentError as error:
        raise GspError(f"--vary: {error.message}") from None
    limits = Boundary()
    interrupted = False
    try:
        _fill(found, o.workers, o.resume)
        if o.folds:
            limits = _boundary(found)
    except KeyboardInterrupt:
        interrupted = True
        say(f"interrupted after {(found.modes != MISSING).sum()} of {found.modes.size} nodes")
    if interrupted and o.output.path is not None:
        say(f"{o.output.path}: not written; --resume keeps what is done for the next run")
        return INTERRUPTED
    if o.output.format in DRAWINGS:
        from gspcli.pictures.charts import mode_map

        write(o.output, mode_map(found, limits, o.quantity, o.output.format))
    else:
        emit(o.output, scan_table(ScanResult(found, limits, o.folds), o.output.format, frame))
    if interrupted:
        return INTERRUPTED
    _refuse_gaps(found, limits)
    return 0


def _axes(instance: Instance, texts: tuple[str, ...]) -> list[Axis]:
    """Return the values and drives that vary."""
    from gspcli.motion.singularities.scans import axis_of, drive_names

    known = (*_NUMBERS, *drive_names(instance))
    return [
        axis_of(instance, int(name) if name in _NUMBERS else name, nodes)
        for name, nodes in axes_of(texts, known)
    ]


def _refuse_coordinates(o: Options) -> None:
    """Raise for options about poses where values vary."""
    if any(text.strip()[:1] in "xyzr" for text in o.texts):
        raise click.UsageError(
            "--vary: found coordinates of a pose: give --pose, too, for the coordinates that stay"
        )
    if o.euler or o.pivot:
        raise click.UsageError("--euler and --pivot say how --pose is read: give --pose, too")


def _refuse_gaps(found: Scan, limits: Boundary) -> None:
    """Raise if poses of a node are missing, or folds do not explain a change of the number."""
    from gspcli.motion.singularities.scans import UNKNOWN

    if unknown := int((found.modes == UNKNOWN).sum()):
        raise IncompleteError(
            f"at {unknown} of {found.modes.size} nodes not all poses could be found"
        )
    if limits.unexplained:
        raise IncompleteError(
            f"on {len(limits.unexplained)} edges of the grid the folds found do not explain how "
            "the number of modes changes"
        )


def _fill(found: Scan, workers: Workers, journal: Path | None) -> None:
    """Find the poses at all nodes, but for those in the work file."""
    from gspcli.journal import Journal
    from gspcli.motion.singularities.scans import Piece, scanned

    done: set[int] = set()
    title = _identity(found)
    with nullcontext() if journal is None else Journal.opened(journal) as work:
        if work is not None:
            for scan, piece in work.read(lambda line: (line.pop("scan"), Piece(**line))):
                if scan == title:
                    found.enter(piece)
                    done.add(piece.number)
        missing = [number for number in range(found.pieces) if number not in done]
        results = workers.as_completed(partial(scanned, found, SEED), missing)
        for piece in progress(
            results,
            total=len(missing),
            label="nodes in thousands" if found.piece == 1000 else "parts of the nodes",
            lines=True,
        ):
            found.enter(piece)
            if work is not None:
                work.append({"scan": title, **asdict(piece)})


def _identity(found: Scan) -> str:
    """Return the data that identify a scan in a work file."""
    from gspcli.spec import dumps

    parts = (dumps(found.instance), found.axes, found.clearances is not None, __version__)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def _boundary(found: Scan) -> Boundary:
    from gspcli.motion.singularities.scans import boundaries

    edges = sum(1 for _ in found.edges)
    *_, last = progress(boundaries(found), total=edges, label="edges with folds", lines=True)
    return last


_OWN, _EXPRESSED = ("Tx", "Ty", "Tz"), ("x", "y", "z")
_TURN = ("qw", "qx", "qy", "qz")


def scan_table(result: ScanResult, form: str, frame: PoseFrame) -> Result:
    """Return the table of the nodes, or that of the folds with poses as expressed in a frame."""
    from gspcli.geometry.arrangement import Arrangement

    found, limits, instance = result.found, result.limits, result.found.instance
    document = result.to_json()
    columns = [
        FIELDS[name].but(title=_heading(instance, name), essential=True) for name in result.names
    ]
    if result.folds:
        position = _OWN if frame.is_identity else _EXPRESSED
        columns += FIELDS.of("change")
        # Tables for people show positions, which distinguish mirror images.
        shown = (*position, *_TURN) if form == "csv" else position
        size = Arrangement.of(instance).length
        columns += [
            FIELDS[key].but(minor=1, aligned=True, size=size, essential=False) for key in shown
        ]
    else:
        columns += FIELDS.of("modes condition clearance?", document["nodes"])
    notes = [_note(found)]
    if limits.curves:
        cusps = sum(len(curve.cusps) for curve in limits.curves)
        curves = counted(len(limits.curves), "curve")
        notes.append(f"discriminant: {curves}, {counted(cusps, 'cusp')}")
    notes += [_meeting(result.names, one, frame) for one in limits.meetings]
    if result.folds:
        notes += frame_note(frame)
    rows = document["folds" if result.folds else "nodes"]
    table = Result(
        columns,
        rows,
        instance.title,
        notes,
        schema="scan",
        name="folds" if result.folds else "nodes",
        head=document,
    )
    if not result.folds or frame.is_identity:
        return table
    return replace(table, parts=[replace(table, rows=_expressed(rows, result, frame))])


def _expressed(
    rows: list[dict[str, Any]], result: ScanResult, frame: PoseFrame
) -> list[dict[str, Any]]:
    """Return the rows of folds with their poses as they are expressed."""
    from gspcli.geometry.quaternions import quaternion_from_rotation
    from gspcli.motion.singularities.scans import in_order

    found = []
    crossings = in_order(result.limits.crossings)
    for row, one in zip(rows, crossings, strict=True):
        R, T = frame.from_platform(one.R, one.T)
        pose = [*T.tolist(), *quaternion_from_rotation(R).tolist()]
        left = {key: value for key, value in row.items() if key not in _OWN}
        found.append(left | dict(zip((*_EXPRESSED, *_TURN), pose, strict=True)))
    return found


def _heading(instance: Instance, name: str) -> str:
    return f"{name} {instance.constraints[int(name) - 1].kind.name}" if name.isdecimal() else name


def _note(found: Scan) -> str:
    numbers, counts = _tally(found)
    parts = [f"{modes} at {count}" for modes, count in zip(numbers, counts, strict=True)]
    return f"{found.modes.size} nodes; modes: {', '.join(parts)}"


def _meeting(names: list[str], one: Meeting, frame: PoseFrame) -> str:
    """Return what is known about modes that meet in no simple fold."""
    ends = (
        ", ".join(f"{name} = {x:.10g}" for name, x in zip(names, end, strict=True))
        for end in (one.low, one.high)
    )
    places = []
    for before, after, R, T in one.poses:
        there = ", ".join(f"{x:.6g}" for x in frame.from_platform(R, T)[1].round(9) + 0.0)
        places.append(f"{before} become {after} at ({there})")
    return (
        f"between {' and '.join(ends)}: {one.before} modes before and {one.after} after, proved; "
        f"several meet in no simple fold: {', '.join(places)}"
    )


def _tally(found: Scan) -> tuple[list[int], list[int]]:
    import numpy as np

    numbers, counts = np.unique(found.modes[found.modes >= 0], return_counts=True)
    return numbers.tolist(), counts.tolist()


def _scan_poses(o: Options, quantity: str) -> None:
    """Scan poses and show what was found."""
    from gspcli.motion.singularities.scans import Axis, PoseScan

    axes = tuple(Axis(*axis) for axis in axes_of(o.texts, PARAMETERS))
    o.pose.read(o.form)
    found = PoseScan(o.instance, axes, o.pose.numbers(o.form), o.form)
    cleared = quantity == "clearance" and not o.folds
    if cleared:
        with working("clearances"):
            found.clearances  # noqa: B018
    if o.output.format in DRAWINGS:
        from gspcli.pictures.charts import pose_map

        write(o.output, pose_map(found, quantity, o.output.format))
        return
    names = [axis.name for axis in axes]
    rows = _singular_rows(found, names) if o.folds else _node_rows(found, names, cleared=cleared)
    columns = FIELDS.of(" ".join(names))
    if not o.folds:
        columns += FIELDS.of("determinant condition clearance?", rows)
    positive, negative = (int((found.determinants * sign > 0).sum()) for sign in (1, -1))
    note = (
        f"{found.determinants.size} poses; determinant positive at {positive}, negative at "
        f"{negative}; {len(found.singular)} singular poses on edges of the grid"
    )
    name = "singular" if o.folds else "nodes"
    head: dict[str, Any] = {"over": {axis.name: list(axis.values) for axis in axes}, name: rows}
    if o.folds:
        head["curves"] = [{"values": curve.tolist()} for curve in found.curves]
    emit(
        o.output,
        Result(
            columns,
            rows,
            o.instance.title,
            [note],
            instance=o.instance,
            schema="scan",
            name=name,
            head=head,
        ),
    )


def _node_rows(found: PoseScan, names: list[str], *, cleared: bool) -> list[dict[str, Any]]:
    import numpy as np

    from gspcli.geometry.measurement import printed_conditions

    conditions, rows = printed_conditions(found.conditions), []
    for node in np.ndindex(*found.determinants.shape):
        determinant, condition = found.determinants[node], conditions[node]
        rows.append(
            {
                **dict(zip(names, found.places[node].tolist(), strict=True)),
                "determinant": float(determinant) if np.isfinite(determinant) else None,
                "condition": float(condition) if np.isfinite(condition) else None,
                **({"clearance": float(found.clearances[node])} if cleared else {}),
            }
        )
    return rows


def _singular_rows(found: PoseScan, names: list[str]) -> list[dict[str, Any]]:
    points = sorted(point.tolist() for point in found.singular.values())
    return [dict(zip(names, point, strict=True)) for point in points]
