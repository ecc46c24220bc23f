"""`gsp atlas`: summarizes the generic counts of all types."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gspcli.cli.options import (
<<<<<<< HEAD
=======
    Command,
    Positive,
>>>>>>> 1e065d72 (Show in helps the examples first, then options in groups, then the text)
    output_options,
)
from gspcli.cli.render import Output, emit
from gspcli.cli.result import Field, Fields, Result

if TYPE_CHECKING:
    pass

FIELDS = Fields("atlas summary")


@click.group
def command() -> None:
    """Show the generic counts of all types, and what confirms them.

    A generic count is what almost every platform of a type has over the complex numbers. All
    are proved (docs/counts.md). Each was confirmed in two ways: by Gröbner bases of random
    platforms modulo two primes (msolve), and by tracking paths to a random real platform. There
    the poses are proved to be different, and traces test that none is missing.
    """


@command.command(cls=Command)
@output_options(parts=("counts", "bounds"))
def summary(output: Output) -> None:
    """Summarize the generic counts by class, and how sharp the bounds are.

    \b
    Examples:
      gsp atlas summary
      gsp atlas summary --format markdown
    """
    from gspcli.atlas.count_summary import atlas_summary, trace_extremes
    from gspcli.catalogue.counts import Method, all_families, family_counts

    found = atlas_summary().to_json()
    confirmed = [family_counts(family).confirmed for family in all_families()]
    notes = [
        f"{sum(method in found for found in confirmed)} of {len(confirmed)} families were "
        f"confirmed by {method.meaning}"
        for method in Method
    ]
    defect, without_one = trace_extremes()
    emit(
        output,
        [
            Result(
                columns=[
                    *FIELDS.of("name sides"),
                    *_numbers("types", "smallest", "median", "largest"),
                    FIELDS["of_largest"],
                    *_numbers("different"),
                ],
                rows=found["counts"],
                title="Generic counts",
                part="counts",
                notes=[
                    "All counts are proved, see docs/counts.md.",
                    *notes,
                    f"trace tests: defect at most {defect:.0e}, without one pose at least "
                    f"{without_one:.0e}",
                ],
            ),
            Result(
                columns=[
                    *FIELDS.of("bound name"),
                    *_numbers("types", "sharp"),
                    *FIELDS.of("median largest of_largest"),
                ],
                rows=found["bounds"],
                title="Bounds against generic counts",
                part="bounds",
                notes=[
                    "sharp: the bound is the count; factor: the bound over the count. Table 3 "
                    "counts",
                    "one of the two planes of a DLL and is compared with that count.",
                ],
            ),
        ],
        document=found,
    )


def _numbers(*keys: str) -> list[Field]:
    return [Field(key, align="right", essential=True) for key in keys]
<<<<<<< HEAD
=======


@command.command(cls=Command)
@click.option("--fast", is_flag=True, help="A random sample of small ones: a few seconds.")
@click.option(
    "--method",
    type=click.Choice(["groebner", "tracking", "both"]),
    help="How to count.  [default: both, or tracking alone without msolve]",
)
@seed_option(": other platforms, and another sample")
@worker_options
@_timeout
@resume_option
@output_options(parts=("methods", "different"))
def verify(
    fast: bool,
    method: str | None,
    seed: int,
    workers: Workers,
    timeout: float | None,
    resume: Path | None,
    output: Output,
) -> None:
    """Count again and compare with the record; exit with 1 if anything differs.

    Without --fast everything is counted: platforms of all types, and general quadrics for
    the 119 intersection numbers. That takes hours; --resume FILE lets it be interrupted and
    continued.

    \b
    Examples:
      gsp atlas verify --fast
      gsp atlas verify --fast --seed 7 --method tracking
      gsp atlas verify --resume verify.jsonl
    """
    from gspcli.atlas.groebner import msolve_path
    from gspcli.atlas.records import RecordVerdict, recorded, verdict
    from gspcli.atlas.task_counts import count_all
    from gspcli.atlas.tasks import PRIMES, all_tasks

    chosen = method or ("both" if msolve_path() else "tracking")
    characteristics = (0,) * (chosen != "groebner") + PRIMES * (chosen != "tracking")
    tasks = all_tasks(seed=seed, characteristics=characteristics)
    if fast:
        size, largest = _FAST
        tasks = random.Random(seed).sample([t for t in tasks if recorded(t) <= largest], size)
    results = count_all(
        tasks,
        journal=resume,
        workers=workers,
        timeout_s=timeout,
        progress=progress,
    )
    verdicts = {result: verdict(result) for result in map(results.__getitem__, tasks)}
    wrong = [result for result, v in verdicts.items() if v is RecordVerdict.DIFFERENT]
    unfinished = [result for result, v in verdicts.items() if v is RecordVerdict.UNFINISHED]
    emit(
        output,
        [_verified(verdicts), *([_differing(wrong)] if wrong else [])],
        schema="atlas-verify",
    )
    if wrong:
        raise CheckFailed(f"{len(wrong)} of {len(results)} counts differ from the record")
    if unfinished:
        raise IncompleteError(
            f"{len(unfinished)} of {len(results)} counts were not finished\n"
            "or too few poses were certified: raise --timeout, or use another --seed"
        )


def _verified(verdicts: Mapping[TaskResult, RecordVerdict]) -> Result:
    """Say for each method how many counts were as recorded."""
    rows: list[dict[str, Any]] = []
    for characteristic in dict.fromkeys(result.task.characteristic for result in verdicts):
        found = [
            v.value
            for result, v in verdicts.items()
            if result.task.characteristic == characteristic
        ]
        method = f"Gröbner bases modulo {characteristic}" if characteristic else "tracking"
        rows.append({"method": method, "counts": len(found), **Counter(found)})
    numbers = _numbers("counts", "equal", "different", "unfinished")
    rows = [{**dict.fromkeys((c.key for c in numbers), 0), **row} for row in rows]
    equal = sum(row["equal"] for row in rows)
    note = f"confirmed: {equal} of {len(verdicts)} counts"
    columns = [_VERIFIED["method"], *numbers]
    return Result(columns, rows, notes=[note], part="methods")


def _differing(wrong: Sequence[TaskResult]) -> Result:
    from gspcli.atlas.records import recorded

    return Result(
        columns=[_VERIFIED["subject"], *_numbers("sides", "characteristic", "recorded", "counted")],
        rows=[{**vars(r.task), "recorded": recorded(r.task), "counted": r.count} for r in wrong],
        title="Different from the record",
        part="different",
    )


@command.command(cls=Command)
@click.option(
    "--folder",
    type=click.Path(file_okay=False, path_type=Path),
    required=True,
    metavar="FOLDER",
    help="Where to write, such as data/counts.",
)
@click.option(
    "--check", is_flag=True, help="Exit with 1 if anything differs: compare instead of writing."
)
@worker_options
@_timeout
@resume_option
def build(
    folder: Path,
    check: bool,
    workers: Workers,
    timeout: float | None,
    resume: Path | None,
) -> None:
    """Count everything and write the record, to the same bytes each time.

    This takes hours and needs msolve. Use --resume FILE, so that it can be interrupted and
    continued. What is not finished within --timeout is recorded as not confirmed.

    \b
    Examples:
      gsp atlas build --resume counts.jsonl --folder data/counts
      gsp atlas build --resume counts.jsonl --folder data/counts --check
    """
    from gspcli.atlas.records import contents, differences
    from gspcli.atlas.task_counts import count_all
    from gspcli.atlas.tasks import all_tasks

    results = count_all(
        all_tasks(),
        journal=resume,
        workers=workers,
        timeout_s=timeout,
        progress=progress,
    )
    files = contents(results)
    if check:
        if different := differences(folder, files):
            raise CheckFailed(f"{folder}: what was built differs: {', '.join(different)}")
        say(f"{folder}: {len(files)} files confirmed")
        return
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        write_whole(folder / name, text)
    say(f"{folder}: {len(results)} counts recorded")
>>>>>>> 1e065d72 (Show in helps the examples first, then options in groups, then the text)
