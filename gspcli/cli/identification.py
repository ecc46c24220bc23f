"""`gsp calibrate --from`: a machine from its log, without an instance file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gspcli.cli.calibration_tables import calibration_table
from gspcli.cli.output import DRAWINGS, Output, emit, write
from gspcli.cli.pose_options import text_of
from gspcli.cli.progress_bars import working
from gspcli.errors import CheckFailed
from gspcli.wording import named

if TYPE_CHECKING:
    from gspcli.calibration import Options
    from gspcli.motion import PoseFormat


def identified(
    path: str,
    form: PoseFormat,
    noise: dict[str, float],
    options: Options,
    output: Output,
    *,
    accept: bool,
) -> None:
    """Find a hexapod from a log, and write its numbers, its instance file or the residuals.

    Parameters
    ----------
    path
        The log; - for standard input.
    form
        How its poses are expressed, by the options.
    noise, options
        As for `calibrate_rows`.
    output
        Where to and how.
    accept
        Whether a file is written even if the fit is doubted.

    Raises
    ------
    CheckFailed
        If the fit is doubted and that is not accepted.
    """
    import numpy as np

    from gspcli.calibration.identifying import identify_log
    from gspcli.calibration.logs import read_log

    log = read_log(*text_of(path), form.ignore, form.columns)
    with working("finding the machine"):
        found = identify_log(log, form.euler, np.array(form.pivot), noise, options)
    result, said = found.calibration, found.sentences
    refused = bool(found.doubts) and not accept
    if output.format == "yaml":
        from gspcli.calibration.instance_files import calibrated_text

        if not refused:
            write(output, calibrated_text(result, [f"from {named(path)}", *said]))
    elif output.format in DRAWINGS:
        from gspcli.pictures.residual_charts import residual_chart

        write(output, residual_chart(result, output.format))
    else:
        document = {"schema": "gsp.calibrate/1", **found.to_json()}
        emit(
            output,
            calibration_table(result, said),
            document=document if output.format == "json" else None,
        )
    if output.format in ("yaml", *DRAWINGS):
        for sentence in said:
            click.echo(sentence, err=True)
    if refused:
        message = (
            f"the log does not fit a machine with six legs: {found.doubts[0]}\n"
            "look for wrong rows, or try --robust; --accept takes the result unchanged"
        )
        raise CheckFailed(message)
