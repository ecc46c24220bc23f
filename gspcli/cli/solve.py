"""`gsp solve`: every pose of a platform given in a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.digits import DECIMALS, decimals, digit_table, digits_option, refined
from gspcli.cli.names import load_instance
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.defaults import SEED
from gspcli.errors import IncompleteError, NotFiniteError

if TYPE_CHECKING:
    from gspcli.solver import Solution, SolveResult

#: Formats for people, in which rounding errors about zero are shown as zero.
_READABLE = ("table", "markdown", "latex")
_ZERO = 1e-12
_AXES = ("Tx", "Ty", "Tz")
_QUATERNION = ("qw", "qx", "qy", "qz")


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option(
    "--set",
    "settings",
    metavar="N=VALUE",
    multiple=True,
    help="Give constraint N (from 1) another value; may be repeated.",
)
@click.option("--all", "everything", is_flag=True, help="Also show poses that are not real.")
@click.option("--no-certify", is_flag=True, help="Do not prove the poses.")
@click.option(
    "--seed",
    type=int,
    default=SEED,
    show_default=True,
    help="Seed of random choices; the answer does not depend on it.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Threads; the answer does not depend on them.",
)
@digits_option
@output_options()
def command(
    spec: str,
    settings: tuple[str, ...],
    everything: bool,
    no_certify: bool,
    seed: int,
    jobs: int,
    digits: int | None,
    output: Output,
) -> None:
    """Find every pose of a platform and account for every path.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`). Each
    real pose is one line: its translation T and the unit quaternion of its rotation
    (x_base = R x_platform + T), the largest residual in the units of the file, and the condition
    number. The last line compares what was found with the generic count of the type.

    Exit codes: 0 done (no real pose is an answer, too); 2 bad input; 3 the poses are infinitely
    many; 4 something could not be found or certified.

    \b
    Examples:
      gsp solve @example-6.8
      gsp solve platform.yaml --set 1=5.2 --set 4=60 --format csv
      gsp solve @dietmaier --digits 50 -o poses.json
      gsp new "DPL DPL DLP ALL ALL ALH" | gsp solve - --all -o poses.json
    """
    from gspcli.solver import solve
    from gspcli.spec import set_values

    instance = set_values(load_instance(spec), settings)
    result = solve(
        instance,
        seed=seed,
        jobs=jobs,
        certify=not no_certify,
    )
    shown = result.solutions if everything else result.real_solutions
    proved = _refined(result, shown, digits) if digits is not None else []
    document = None
    if output.format == "json":
        document = result.to_json(everything=everything)
        for entry, pose in zip(document["solutions"], proved, strict=False):
            entry["refined"] = pose
    emit(output, _tables(result, everything, proved, output.format), document=document)
    _complain(result, certified=not no_certify)


def _refined(
    result: SolveResult, shown: Sequence[Solution], digits: int
) -> list[dict[str, Any] | None]:
    """Return each pose with proved digits; None for those that cannot be certified."""
    import numpy as np

    from gspcli.certification import certify

    if not shown:
        return []
    poses = (np.stack([solution.R for solution in shown]), np.stack([s.T for s in shown]))
    return [
        refined(result.instance, certificate, digits) if certificate.certified else None
        for certificate in certify(result.instance, *poses)
    ]


def _tables(
    result: SolveResult, everything: bool, proved: list[dict[str, Any] | None], fmt: str
) -> list[Table]:
    readable = fmt in _READABLE
    shown = result.solutions if everything else result.real_solutions
    rows = [_row(number, solution, readable) for number, solution in enumerate(shown, start=1)]
    for row, pose in zip(rows, proved, strict=False):
        row |= decimals(pose or {})
    imaginary = [f"{key}_imag" for key in (*_AXES, *_QUATERNION)] if everything else []
    optional = {
        "real": everything,
        "sides": any(solution.sides for solution in shown),
        "multiplicity": any(solution.multiplicity > 1 for solution in shown),
    }
    digits = [Column(key) for key in DECIMALS if any(key in row for row in rows)]
    columns = [
        Column("number", "no.", align="right", essential=True),
        *(Column(key, align="right", essential=True) for key in (*_AXES, *_QUATERNION)),
        *(Column(key) for key, present in optional.items() if present or not readable),
        Column("residual", align="right"),
        Column("condition", align="right"),
        Column("certified"),
        *(Column(key, align="right") for key in imaginary),
        *([] if readable else digits),
    ]
    title = ": ".join(part for part in (result.instance.name, result.instance.type.id) if part)
    table = Table(columns, rows, title=title, notes=[account(result)])
    return [table, digit_table(rows)] if readable and digits else [table]


def _row(number: int, solution: Solution, readable: bool) -> dict[str, Any]:
    values = dict(zip(_AXES, solution.T.tolist(), strict=True))
    values |= zip(_QUATERNION, solution.quaternion.tolist(), strict=True)
    residual = solution.residual
    row = {key: value.real for key, value in values.items()}
    if not solution.real:
        row |= {f"{key}_imag": value.imag for key, value in values.items()}
    if readable:
        row = {key: value if abs(value) > _ZERO else 0.0 for key, value in row.items()}
        residual = float(f"{residual:.1e}")
    sides = [f"{constraint}:{side}" for constraint, side in solution.sides.items()]
    return {
        "number": number,
        **row,
        "residual": residual,
        "condition": solution.condition,
        "sides": sides,
        "real": solution.real,
        "multiplicity": solution.multiplicity,
        "certified": solution.certified,
    }


def account(result: SolveResult) -> str:
    """Return the line that says what became of every path."""
    counts, ends = result.counts, result.account
    found = counts.found
    parts = [f"{found} of {result.expected} expected found", f"{counts.real} real"]
    if counts.certified:
        parts.append(f"{counts.certified} certified")
    if counts.singular:
        parts.append(f"{counts.singular} multiple ({ends.found} paths end at found ones)")
    parts.append(f"{ends.at_infinity} at infinity")
    if ends.on_curves:
        parts.append(f"{ends.on_curves} on curves")
    if ends.spurious:
        parts.append(f"{ends.spurious} where parallel lines have another distance")
    parts.append(f"{ends.lost} lost")
    return f"{', '.join(parts)}; {result.verdict}"


def _complain(result: SolveResult, *, certified: bool) -> None:
    """Raise what the exit code is to say."""
    counts = result.counts
    if result.motions:
        motion = result.motions[0]
        how = "the platform can move" if motion.real else "over the complex numbers"
        message = (
            f"the poses are infinitely many: {how}, with local dimension {motion.dimension}\n"
            "(numerical evidence; --format json has sample motions)"
        )
        raise NotFiniteError(message)
    if result.account.lost:
        message = (
            f"{result.account.lost} of {result.expected} expected solutions could not be made "
            "out: the platform is in or near a special position\n"
            "try another --seed, or change a value a little with --set and compare"
        )
        raise IncompleteError(message)
    if certified and counts.certified < counts.found:
        message = (
            f"{counts.found - counts.certified} of {counts.found} poses could not be certified"
            + (
                f" ({counts.singular} are multiple, which no proof covers)"
                if counts.singular
                else ""
            )
            + "\nuse --no-certify to do without"
        )
        raise IncompleteError(message)
