"""`gsp certify`: prove poses of any source, or prove them wrong."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.commands.solve import DECIMALS, digit_cells, digit_table, digits_option, refined
from gspcli.cli.options import Command, Options, Positive, option, output_options, value_options
from gspcli.cli.pose_options import text_of
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import working
from gspcli.defaults import MAX_PRECISION, TOLERANCE
from gspcli.errors import CheckFailed, IncompleteError

if TYPE_CHECKING:
    from gspcli.certification import Certificates

FIELDS = Fields("certify")

_SIDES = {1: "positive", -1: "negative"}
_COLUMNS = FIELDS.of(
    "number outcome real same_as residual_bound deviation sides precision error uniqueness"
)


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC")
@click.argument("result", metavar="RESULT")
@value_options
@option(
    "--max-deviation D",
    "Largest difference of a pose from its solution, lengths by the smaller body; relative for "
    "numbers above one.",
    default=TOLERANCE,
    type=Positive(),
)
@option(
    "--max-precision BITS",
    "Where to stop raising the precision.",
    default=MAX_PRECISION,
    type=click.IntRange(64, 1_000_000),
)
@digits_option
@output_options(formats=("table", "csv", "json", "markdown"))
def command(o: Options) -> None:
    """Prove that the poses in RESULT solve the platform in SPEC, without trusting them.

    For each pose it is proved that a solution is within --max-deviation, and that it is the only
    one in a ball. It is also proved whether the solution is real, which other poses stand for the
    same solution, and how well the pose as given meets the constraints. The proofs are in ball
    arithmetic, for the numbers of SPEC exactly as written. Whether the list is complete is not
    examined: compare the number of different solutions with the one that `gsp solve` expects.

    RESULT is what `gsp solve --format json --all` prints, or any list of poses as JSON or CSV: R
    (by rows) or a quaternion (scalar first), and T; or what msolve, PHCpack or one of the other
    programs of `gsp export` wrote. SPEC or RESULT may be - for standard input.

    The exit code is 0 if every pose is certified and no two are the same; 1 if one is proved wrong,
    a duplicate, or not what the list says about it; 4 if something could not be decided, as at
    double solutions, or where two are nearer to each other than the digits of the list distinguish.

    \b
    Examples:
      gsp solve platform.yaml --all --format json | gsp certify platform.yaml -
      gsp certify platform.yaml poses.csv --max-deviation 1e-3
      gsp certify platform.yaml poses.json --digits 50 --format json
    """
    from gspcli.export.answers import read_answer, read_candidates
    from gspcli.geometry.frames import PoseFrame
    from gspcli.solver import certify

    instance = o.instance
    text, name = text_of(o.result)
    given = read_answer(text, name) or read_candidates(text, name, PoseFrame.of(instance))
    with working("certifying"):
        proved = certify(
            instance,
            given.R,
            given.T,
            sides=given.claimed_sides,
            tolerance=o.max_deviation,
            max_precision=o.max_precision,
        )
        document = {"schema": "gsp.certify/1", **instance.to_json(), "tolerance": o.max_deviation}
        document |= proved.to_json()
        solutions = document["solutions"]
        claims = zip(given.claimed_real, given.claimed_sides.tolist(), strict=True)
        for entry, item, (real, signs) in zip(solutions, proved, claims, strict=True):
            sides = {str(k): _SIDES[sign] for k, sign in enumerate(signs, 1) if sign in _SIDES}
            entry |= {"claimed_real": real, "claimed_sides": sides}
            if o.digits is not None and item.certified:
                entry["refined"] = refined(instance, item, o.digits)
    emit(o.output, _tables(document, proved, o.output.format), document=document)
    _conclude(solutions, proved)


def _tables(document: dict[str, Any], proved: Certificates, form: str) -> list[Result]:
    rows: list[dict[str, Any]] = []
    for entry in document["solutions"]:
        sides = " ".join(f"{k}:{side}" for k, side in entry["sides"].items())
        rows.append({**entry, "sides": sides, **digit_cells(entry.get("refined", {}))})
    said = (
        "{poses} poses: {certified} certified, {distinct} of them proved pairwise different, "
        "{real} of these real"
    )
    summary = [said.format(**document["counts"])]
    if proved.certified:
        turned, moved = proved.deviations
        summary.append(
            f"certified poses are within {turned:.1e} of their solutions in R, "
            f"within {moved:.1e} {document['units']['length']} in T"
        )
    digits = [Field(key) for key in DECIMALS if any(key in row for row in rows)]
    if form == "csv":
        return [Result([*_COLUMNS, *digits], rows, summary=summary, part="poses")]
    tables = [Result(_COLUMNS, rows, summary=summary, part="poses")]
    return [*tables, digit_table(rows)] if digits else tables


def _conclude(solutions: list[dict[str, Any]], proved: Certificates) -> None:
    """Raise if a pose is wrong, or else if one is not decided."""
    from gspcli.certification import Outcome

    undecided_outcomes = (Outcome.NOT_ISOLATED, Outcome.TOO_FAR, Outcome.NOT_A_NUMBER)
    wrong: Counter[str] = Counter()
    open_: Counter[str] = Counter()
    for entry, item in zip(solutions, proved, strict=True):
        claim = entry["claimed_real"]
        if not item.certified:
            (open_ if item.outcome in undecided_outcomes else wrong)[item.outcome.meaning] += 1
        elif item.real is None:
            open_["not decided whether it is real"] += 1
        elif claim is not None and claim is not item.real:
            wrong["said to be real and is not" if claim else "said not to be real and is"] += 1
        if any(entry["sides"].get(k, side) != side for k, side in entry["claimed_sides"].items()):
            wrong["said to be on the other side of a plane"] += 1
        if item.same_as is not None:
            wrong["the same solution as an earlier one"] += 1
        if item.unresolved:
            open_["not proved different from another one"] += 1
    if wrong:
        raise CheckFailed(_sentence(wrong, len(proved), "wrong"))
    if open_:
        raise IncompleteError(_sentence(open_, len(proved), "not certified"))


def _sentence(reasons: Counter[str], total: int, verdict: str) -> str:
    lines = [f"{count} of {total}: {reason}" for reason, count in reasons.items()]
    return f"some poses are {verdict}\n" + "\n".join(lines)
