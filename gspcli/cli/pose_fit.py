"""The option `--fit` of `gsp solve`: poses that fit more than six measurements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.output import Column, Output, Table, emit
from gspcli.cli.progress_bars import working
from gspcli.cli.sigma_options import standard_deviations
from gspcli.errors import CheckFailed, GspError
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.sensing import PoseFit
    from gspcli.sensing.notation import SensorReading
    from gspcli.solver.results.columns import PoseColumn

#: Decimals of residuals and of chi-squared: further decimals are rounding errors.
_DECIMALS = 3
#: Residuals larger than this many deviations are marked.
_LARGE = 3.0


def show_fit(
    instance: Instance,
    readings: Sequence[SensorReading],
    sigmas: Sequence[str],
    rotation: Sequence[PoseColumn],
    decimals: int | None,
    frame: PoseFrame,
    output: Output,
) -> int:
    """Fit poses to all measurements, and write them with residuals.

    Parameters
    ----------
    instance, readings
        The platform, and the readings of further sensors; if there are none, those of its file.
    sigmas
        Standard deviations of the values, as texts of the option.
    rotation, decimals, frame
        How poses are written, and in which frame; JSON has those of the platform in the base.
    output
        Where to.

    Raises
    ------
    CheckFailed
        Unless exactly one pose fits.
    """
    from gspcli.sensing import fit_poses

    if not readings and not instance.readings:
        message = (
            "--fit needs readings besides the six values: --reading 'leg P1 B3 = 212.4 ± 0.1', or "
            "`readings` in SPEC"
        )
        raise GspError(message)
    with working("fitting"):
        fit = fit_poses(instance, readings or None, sigma=standard_deviations(sigmas))
    document = {"schema": "gsp.solve/1", **instance.to_json(), "fit": fit.to_json()}
    tables = [_poses(fit, rotation, decimals, frame), *_residuals(fit)]
    if output.format == "csv":
        tables = tables[:1]
    emit(output, tables, document=document if output.format == "json" else None)
    if len(fit.fitting) == 1:
        return 0
    if fit.fitting:
        message = f"{len(fit.fitting)} poses fit: gsp sensors says which further sensor tells modes"
        raise CheckFailed(f"{message} apart")
    message = fit.sentences[2] if len(fit.sentences) > 2 else fit.sentences[0]
    raise CheckFailed(f"no pose fits what was measured: {message}")


def _poses(
    fit: PoseFit, rotation: Sequence[PoseColumn], decimals: int | None, frame: PoseFrame
) -> Table:
    """Return a row for each pose."""
    import numpy as np

    from gspcli.geometry.arrangement import Arrangement
    from gspcli.solver.results.columns import expressed

    instance = fit.numbers.instance
    R = np.array([pose.R for pose in fit.poses]).reshape(-1, 3, 3)
    T = np.array([pose.T for pose in fit.poses]).reshape(-1, 3)
    poses = expressed(frame, Arrangement.of(instance), R, T, np.ones(len(R), bool))
    rows = fit.rows()
    for row, place in zip(rows, poses.T.tolist(), strict=True):
        row |= dict(zip(("Tx", "Ty", "Tz"), place, strict=True))
    units = {"": "", "length": instance.units.length, "angle": instance.units.angle.value}
    columns = [Column("number", "no.", "right", essential=True)]
    columns += [
        Column(key, f"{key} [{units['length']}]", "right", True, aligned=True, decimals=decimals)
        for key in ("Tx", "Ty", "Tz")
    ]
    for one in rotation:
        title = f"{one.key} [{units[one.unit]}]" if one.unit else ""
        columns.append(Column(one.key, title, "right", True, aligned=True, decimals=decimals))
        for row, cell in zip(rows, one.read(poses), strict=True):
            row[one.key] = float(cell)
    columns += [
        Column("chi_squared", "chi²", "right", essential=True),
        Column("probability", "p", "right", minor=1),
        Column("sigma_T", f"± T [{units['length']}]", "right", minor=1),
        Column("sigma_turn", f"± turn [{units['angle']}]", "right", minor=2),
        Column("fits", "fits"),
    ]
    for row in rows:
        row["chi_squared"] = round(float(f"{row['chi_squared']:.4g}"), _DECIMALS)
        for key in ("probability", "sigma_T"):
            row[key] = float(f"{row[key]:.2g}")
        row["sigma_turn"] = float(f"{row['sigma_turn']:.2g}")
    keys = [column.key for column in columns]
    rows = [{key: row[key] for key in keys} for row in rows]
    notes = ["± of one axis, the largest of three; of the platform's origin"]
    if not frame.is_identity:
        notes.append(f"poses are {frame.words}")
    return Table(columns, rows, instance.title, notes=notes, summary=fit.sentences, part="poses")


def _residuals(fit: PoseFit) -> list[Table]:
    """Return the residuals of the best pose."""
    if not fit.poses:
        return []
    best = fit.poses[0]
    names = [fit.numbers.names[k] for k in best.owners.tolist()]
    rows: list[dict[str, Any]] = [
        {
            "measured": name,
            "off": round(left, _DECIMALS),
            "studentised": None if size != size else round(size, _DECIMALS),
            "remarks": "large" if abs(size) > _LARGE else "",
        }
        for name, left, size in zip(
            names, best.residuals.tolist(), best.studentised.tolist(), strict=True
        )
    ]
    columns = [
        Column("measured", essential=True),
        Column("off", "off [σ]", "right", essential=True, decimals=_DECIMALS),
        Column("studentised", align="right", essential=True, decimals=_DECIMALS),
        Column("remarks"),
    ]
    notes = [
        "off: measured less fitted, at pose 1; studentised: over the deviation of that difference, "
        "empty where no other measurement checks it"
    ]
    return [Table(columns, rows, notes=notes, part="residuals")]


def check_options(*, fitting: bool, **given: object) -> None:
    """Raise for --sigma without --fit, and for options of the table of modes with it."""
    if not fitting:
        message = "--sigma says how exact the values are: give it with --fit"
        raise click.UsageError(message)
    wrong = [f"--{name.replace('_', '-')}" for name, value in given.items() if value]
    if wrong:
        message = f"{listed(wrong, 'and')}: not with --fit"
        raise click.UsageError(message)
