"""`gsp scan`: how many assembly modes there are where values or drives vary."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gspcli import __version__
from gspcli.cli import options
from gspcli.cli.pose_options import PARAMETERS, frame_note, pose_options, pose_value_option, span_of
from gspcli.cli.render import emit, write
from gspcli.cli.result import Fields, Result
from gspcli.cli.streams import progress, say
from gspcli.defaults import SEED
from gspcli.errors import INTERRUPTED, ArgumentError, GspError, IncompleteError
from gspcli.wording import counted, shown

if TYPE_CHECKING:
    from gspcli.geometry.frames import PoseFrame
    from gspcli.motion.singularities.scans import Boundary, Meeting, Scan, ScanResult, Varied
    from gspcli.workers import Workers

FIELDS = Fields("scan")

QUANTITIES = ("modes", "condition", "clearance")
_NUMBERS = tuple("123456")
_MOST_NODES = 1_000_000


@click.command(cls=options.Command)
@click.argument("spec", metavar="SPEC")
@options.option(
    "--vary NAME=LOW:HIGH:COUNT",
    "Let NAME take COUNT values from LOW to HIGH: a constraint from 1 to 6, a crank or slide such "
    "as crank.B1, or, with --pose, x, y, z (rx, ry, rz with --euler); once or twice.",
    name="texts",
    multiple=True,
    required=True,
)
@pose_value_option("the pose whose coordinates vary; the other coordinates stay")
@options.value_options
@pose_options
@options.option(
    "--folds",
    "Find, with proof, where the number changes between neighbouring nodes. Tables show these "
    "folds instead of the nodes, pictures both.",
)
@options.option(
    "--quantity",
    "The quantity of pictures (over poses the determinant instead of modes). With clearance it is "
    "a column, too (some milliseconds a mode or pose).",
    type=click.Choice(QUANTITIES),
    default=QUANTITIES[0],
)
@options.resume_option
@options.worker_options
@options.output_options(formats=(*options.FORMATS, *options.DRAWINGS))
def command(o: options.Options) -> int:
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
    if o.pose is None and any(text.strip()[:1] in "xyzr" for text in o.texts):
        raise click.UsageError(
            "--vary: found coordinates of a pose: give --pose, too, for the coordinates that stay"
        )
    if o.pose is None and (o.euler or o.pivot):
        raise click.UsageError("--euler and --pivot say how --pose is read: give --pose, too")
    from gspcli.motion.singularities.scans import Boundary, Scan, ScanResult

    clearance = o.quantity == "clearance" and not (o.pose and o.folds)
    found = Scan.of(_varied(o), clearance=clearance)
    limits = Boundary()
    interrupted = False
    try:
        _fill(found, o.workers, o.resume)
        if o.folds or o.pose:
            limits = _boundary(found)
    except KeyboardInterrupt:
        interrupted = True
        say(f"interrupted after {found.done.sum()} of {found.done.size} nodes")
    if interrupted and o.output.path is not None:
        say(f"{o.output.path}: not written; --resume keeps what is done for the next run")
        return INTERRUPTED
    if o.output.format in options.DRAWINGS:
        from gspcli.pictures.charts import scan_chart

        write(o.output, scan_chart(found, limits, o.quantity, o.output.format))
    else:
        emit(o.output, scan_table(ScanResult(found, limits, o.folds), o.output.format, frame))
    if interrupted:
        return INTERRUPTED
    _refuse_gaps(found, limits)
    return 0


def _varied(o: options.Options) -> Varied:
    """Return what varies: values and drives, or coordinates of the pose."""
    from gspcli.motion.singularities.scans import (
        Axis,
        VariedNumbers,
        VariedPoses,
        axis_of,
        drive_names,
    )

    if o.pose is not None:
        axes = [Axis(*axis) for axis in _axes(o.texts, PARAMETERS)]
        o.pose.read(o.form)
        return VariedPoses(o.instance, axes, o.pose.numbers(o.form), o.form)
    axes = [
        axis_of(o.instance, int(name) if name in _NUMBERS else name, nodes)
        for name, nodes in _axes(o.texts, (*_NUMBERS, *drive_names(o.instance)))
    ]
    try:
        return VariedNumbers(o.instance, axes)
    except ArgumentError as error:
        raise GspError(f"--vary: {error.message}") from None


def _axes(texts: Sequence[str], names: Sequence[str]) -> list[tuple[str, tuple[float, ...]]]:
    """Return the name and the nodes of each axis of `--vary`."""
    import numpy as np

    spans = [span_of("vary", text, names, "5:7:200") for text in texts]
    for text, (_, low, high, count) in zip(texts, spans, strict=True):
        if not low < high or count < 2:
            expected = "expected LOW below HIGH and at least two values"
            raise GspError(f"--vary: found {shown(text)}, {expected}")
    total = math.prod(count for *_, count in spans)
    if total > _MOST_NODES:
        raise GspError(f"found {total} nodes, expected at most {_MOST_NODES}")
    return [(name, tuple(np.linspace(low, high, n).tolist())) for name, low, high, n in spans]


def _refuse_gaps(found: Scan, limits: Boundary) -> None:
    """Raise if poses of a node are missing, or folds do not explain a change of the number."""
    from gspcli.motion.singularities.scans import UNKNOWN

    modes = found.numbers.get("modes")
    if modes is not None and (unknown := int((modes == UNKNOWN).sum())):
        raise IncompleteError(f"at {unknown} of {modes.size} nodes not all poses could be found")
    if limits.unexplained:
        raise IncompleteError(
            f"on {len(limits.unexplained)} edges of the grid the folds found do not explain how "
            "the number of modes changes"
        )


def _fill(found: Scan, workers: Workers, journal: Path | None) -> None:
    """Fill in all nodes, but for those in the work file."""
    from gspcli.journal import Journal
    from gspcli.motion.singularities.scans import Piece, scanned
    from gspcli.spec import dumps

    done: set[int] = set()
    # The data that identify the scan in the work file.
    parts = (dumps(found.instance), *found.varied.key, *found.numbers, __version__)
    title = hashlib.sha256(repr(parts).encode()).hexdigest()[:16]
    with nullcontext() if journal is None else Journal.opened(journal) as work:
        if work is not None:
            for scan, piece in work.read(lambda line: (line.pop("scan"), Piece(**line))):
                if scan == title:
                    found.enter(piece)
                    done.add(piece.number)
        missing = [number for number in range(found.pieces) if number not in done]
        results = workers.as_completed(partial(scanned, found, SEED), missing)
        label = "nodes in thousands" if found.varied.piece == 1000 else "parts of the nodes"
        for piece in progress(results, total=len(missing), label=label, lines=True):
            found.enter(piece)
            if work is not None:
                work.append({"scan": title, **asdict(piece)})


def _boundary(found: Scan) -> Boundary:
    from gspcli.motion.singularities.scans import boundaries

    edges = len(found.edges)
    *_, last = progress(boundaries(found), total=edges, label="edges with folds", lines=True)
    return last


_OWN, _EXPRESSED = ("Tx", "Ty", "Tz"), ("x", "y", "z")
_TURN = ("qw", "qx", "qy", "qz")


def scan_table(result: ScanResult, form: str, frame: PoseFrame) -> Result:
    """Return the table of the nodes, or that of the folds with poses as expressed in a frame."""
    import numpy as np

    from gspcli.geometry.arrangement import Arrangement

    found, limits, instance = result.found, result.limits, result.found.instance
    document, numbers = result.to_json(), found.numbers
    columns = [FIELDS[name].but(essential=True) for name in result.names]
    if result.of_poses:
        positive, negative = (int((sign * numbers["determinant"] > 0).sum()) for sign in (1, -1))
        notes = [
            f"{found.done.size} poses; determinant positive at {positive}, negative at {negative}; "
            f"{len(limits.crossings)} singular poses on edges of the grid"
        ]
    else:
        kinds = {str(k): f"{k} {row.kind.name}" for k, row in enumerate(instance.constraints, 1)}
        columns = [column.but(title=kinds.get(column.key, column.key)) for column in columns]
        modes = numbers["modes"]
        tally = zip(*np.unique(modes[modes >= 0], return_counts=True), strict=True)
        shown = ", ".join(f"{number} at {count}" for number, count in tally)
        notes = [f"{modes.size} nodes; modes: {shown}"]
    if limits.curves and not result.of_poses:
        cusps = sum(len(curve.cusps) for curve in limits.curves)
        curves = counted(len(limits.curves), "curve")
        notes.append(f"discriminant: {curves}, {counted(cusps, 'cusp')}")
    notes += [_meeting(result.names, one, frame) for one in limits.meetings]
    if not result.folds:
        columns += FIELDS.of("modes? determinant? condition clearance?", document["nodes"])
    elif not result.of_poses:
        position = _OWN if frame.is_identity else _EXPRESSED
        # Tables for people show positions, which distinguish mirror images.
        shown_keys = (*position, *_TURN) if form == "csv" else position
        size = Arrangement.of(instance).length
        columns += FIELDS.of("change")
        columns += [
            FIELDS[key].but(minor=1, aligned=True, size=size, essential=False) for key in shown_keys
        ]
        notes += frame_note(frame)
    name = result.kind
    table = Result(
        columns, document[name], instance.title, notes, schema="scan", name=name, head=document
    )
    if not result.folds or result.of_poses or frame.is_identity:
        return table
    return replace(table, parts=[replace(table, rows=_expressed(document[name], result, frame))])


def _expressed(
    rows: list[dict[str, Any]], result: ScanResult, frame: PoseFrame
) -> list[dict[str, Any]]:
    """Return the rows of folds with their poses as they are expressed."""
    from gspcli.geometry.quaternions import quaternion_from_rotation

    found = []
    for row, one in zip(rows, result.crossings, strict=True):
        R, T = frame.from_platform(one.R, one.T)
        pose = [*T.tolist(), *quaternion_from_rotation(R).tolist()]
        left = {key: value for key, value in row.items() if key not in _OWN}
        found.append(left | dict(zip((*_EXPRESSED, *_TURN), pose, strict=True)))
    return found


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
