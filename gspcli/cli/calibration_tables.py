"""Tables and documents of `gsp calibrate`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.cli.output import Column, Table
from gspcli.cli.output.tables import pose_columns
from gspcli.cli.pose_options import frame_note
from gspcli.wording import counted, listed

if TYPE_CHECKING:
    from gspcli.calibration import Calibration
    from gspcli.calibration.planning import Plan
    from gspcli.geometry.frames import PoseFrame

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def calibration_table(result: Calibration, remarks: Sequence[str] | None = None) -> Table:
    """Return the numbers found beside those stated; of a log, with `remarks`, none are stated."""
    rows = [
        {
            "number": name,
            "stated": before,
            "found": after,
            "sigma": float(f"{sigma:.3g}"),
            "change/sigma": float(f"{(after - before) / sigma:.4g}") if sigma > 0 else None,
        }
        for name, before, after, sigma in zip(
            result.names,
            result.before.tolist(),
            result.after.tolist(),
            result.sigma.tolist(),
            strict=True,
        )
    ]
    columns = [
        Column("number", essential=True),
        *(Column(key, align="right", essential=True, aligned=True) for key in ("stated", "found")),
        Column("sigma", align="right", essential=True),
        Column("change/sigma", align="right"),
    ]
    if remarks is not None:
        columns = [one for one in columns if one.key not in ("stated", "change/sigma")]
        rows = [{one.key: row[one.key] for one in columns} for row in rows]
    units = result.stated.units
    return Table(
        columns,
        rows,
        title=result.stated.title,
        summary=[*(remarks or ()), *_summary(result)],
        notes=[
            f"lengths in {units.length}, angles in {units.angle.value}; scales and directions plain"
        ],
    )


def _summary(result: Calibration) -> list[str]:
    """Return the result in sentences."""
    from gspcli.calibration.doubts import quantile

    chi, freedom = result.chi_squared, result.freedom
    lines = [f"the data do not fit: {doubt}" for doubt in result.doubts]
    if result.cause:
        lines.append(result.cause)
    lines.append(
        f"{counted(len(result.seen), 'row')}, {counted(len(result.names), 'number')} found"
    )
    if freedom <= 0:
        lines.append("as many numbers are found as were measured: their errors are not known")
    elif result.scatter == 1.0:
        lines.append(
            f"chi-squared {chi:.4g} of {freedom} degrees of freedom, "
            f"between {quantile(freedom, -1.96):.4g} and {quantile(freedom, 1.96):.4g} in 95 %"
        )
    else:
        units, noise = result.stated.units, f"{result.noise.value * result.scatter:.2g}"
        noise += f" {units.length}"
        if result.seen.rods.all():
            # Nothing is read but drives.
            noise = _noise_of_drives(result)
        lines.append(
            f"the noise is not stated: {noise} by the scatter ({freedom} degrees of freedom)"
        )
    if result.unknowns.missing:
        what = counted(result.unknowns.missing, "direction")
        lines.append(
            f"{what} not determined by the data, kept as stated: "
            f"{'; '.join(result.unknowns.sentences)}"
        )
    if result.repeated:
        lines.append(
            f"{counted(result.repeated, 'row')} with the same numbers as another: each counts as "
            "measured again, so that deviations are too small if they are copies"
        )
    if result.home:
        lines.append(result.home)
    if result.unknowns.frames:
        lines.append("the frames of base and platform are fitted to those stated")
    worst = result.worst
    if worst is not None:
        row, left, moved = worst
        rest = result.without_worst[1].freedom if result.without_worst else 0
        line = f"worst row: {result.seen.lines[row]}"
        if result.scatter == 1.0:
            line += f", {result.rows[row]:.4g} of chi-squared ({left:.4g} of {rest} without it)"
        lines.append(f"{line}; left out, no number moves by more than {moved:.2g} sigma")
    return lines


def _noise_of_drives(result: Calibration) -> str:
    """Return the deviations of the readings of cranks and slides by the scatter."""
    units, sorts = result.stated.units, {drive.sort for drive in result.fit.model.drives}
    crank = result.noise.crank / units.angle.in_radians * result.scatter
    parts = []
    if "crank" in sorts:
        parts.append(f"{crank:.2g} {units.angle.value} of cranks")
    if "slide" in sorts:
        parts.append(f"{result.noise.slide * result.scatter:.2g} {units.length} of slides")
    return listed(parts, "and")


def calibration_document(result: Calibration) -> dict[str, Any]:
    """Return the JSON document of a calibration."""
    return {"schema": "gsp.calibrate/1", **result.to_json()}


def plan_table(plan: Plan, frame: PoseFrame) -> Table:
    """Return poses to measure, as expressed in a frame, with what the machine reads there."""
    from gspcli.geometry.arrangement import Arrangement

    columns = [Column("t", align="right", essential=True)]
    columns += pose_columns(_POSE, Arrangement.of(plan.instance).length)
    columns += [
        Column(str(k), f"{k} {row.kind.name}", align="right", aligned=True, minor=1)
        for k, row in enumerate(plan.instance.constraints, 1)
        if k - 1 not in plan.driven
    ]
    columns += [Column(name, align="right", aligned=True, minor=1) for name in plan.drive_names]
    read = [column.key for column in columns[1 + len(_POSE) :]]
    return Table(
        columns,
        [
            {
                "t": k,
                **dict(zip(_POSE, pose, strict=True)),
                **{str(j): value for j, value in enumerate(readings, 1)},
                **dict(zip(plan.drive_names, angles, strict=True)),
            }
            for k, (pose, readings, angles) in enumerate(
                zip(
                    plan.expressed(frame).tolist(),
                    plan.readings.tolist(),
                    plan.drives.tolist(),
                    strict=True,
                ),
                1,
            )
        ],
        title=plan.instance.title,
        summary=plan.sentences,
        notes=[
            f"{listed(read, 'and')} are readings with the geometry as stated: replace them by what "
            "is read",
            *frame_note(frame),
        ],
    )


def plan_document(plan: Plan) -> dict[str, Any]:
    """Return the JSON document of a plan."""
    return {"schema": "gsp.calibrate/1", **plan.to_json()}
