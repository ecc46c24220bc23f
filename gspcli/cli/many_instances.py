"""`gsp solve` of many instances: several files, or one instance a line, with an answer for each."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain, islice
from typing import TYPE_CHECKING, Any, NamedTuple

from gspcli.cli.names import spec_source
from gspcli.cli.output import Column, Output, Table, emit, write
from gspcli.cli.progress_bars import progress
from gspcli.cli.streams import say
from gspcli.errors import GspError, SpecError
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.cli.value_options import Changes
    from gspcli.geometry.instance import Instance
    from gspcli.solver import SolveResult

#: The ends of the names of files with an instance in each line, and the format of such answers.
LINE_SUFFIXES = (".jsonl", ".ndjson")
LINES = "jsonl"
#: This process solves this many instances before it starts others: a start takes as long as solving
#: them.
_HERE_FIRST = 16
_COLUMNS = (
    Column("instance", essential=True),
    Column("name", minor=2, fold=" "),
    Column("type", minor=3, fold=" "),
    Column("real", align="right", essential=True),
    Column("found", align="right", essential=True),
    Column("certified", align="right", minor=1),
    Column("verdict", essential=True),
    Column("exit_code", "exit code", align="right", minor=1),
    Column("message", fold=" "),
)


class Source(NamedTuple):
    """Where an instance is."""

    name: str
    """What messages and answers call it."""
    text: str | None
    """Its text; None if the name is that of a file."""


@dataclass(frozen=True)
class Answer:
    """The answer to one instance.

    Attributes
    ----------
    row
        The row of the table.
    document
        What JSON has of it.
    """

    row: dict[str, Any]
    document: dict[str, Any]


#: Solves an instance: returns the result, its document and the error that sets the exit code.
Solving = Callable[["Instance"], tuple["SolveResult", dict[str, Any], GspError | None]]


def are_many(specs: Sequence[str], *, lines: bool) -> bool:
    """Return whether arguments name more than one instance, or may do so."""
    return lines or len(specs) > 1 or specs[0].lower().endswith(LINE_SUFFIXES)


def solve_many(
    specs: Sequence[str],
    solving: Solving,
    changes: Changes,
    jobs: int,
    output: Output,
    *,
    lines: bool,
) -> int:
    """Solve instances one after the other; write an answer for each, in their order.

    Answers in JSON, one a line, are written as soon as they are known. An error of one instance is
    part of its answer, and the others are solved.

    Parameters
    ----------
    specs
        The arguments: files, those with an instance in each line, or ``-``.
    solving
        How one is solved; picklable.
    changes
        What is changed in each.
    jobs
        How many processes.
    output
        Where the answers go.
    lines
        Whether all files have an instance in each line.

    Returns
    -------
    int
        The largest exit code of an instance.
    """
    if specs.count("-") > 1:
        message = "standard input can be one SPEC only: - is given more than once"
        raise GspError(message)
    answers = _answers(_sources(specs, lines=lines), partial(_answer, solving, changes), jobs)
    total = None if _any_lines(specs, lines=lines) else len(specs)
    streamed = output.format == LINES and output.path is None
    if not (streamed and sys.stdout.isatty()):
        # A progress bar would be printed between the lines.
        answers = progress(answers, total=total, label="instances")
    rows, texts = [], []
    for answer in answers:
        rows.append(answer.row)
        if output.format != LINES:
            continue
        text = json.dumps(answer.document, ensure_ascii=False) + "\n"
        if streamed:
            sys.stdout.write(text)
            sys.stdout.flush()
        else:
            texts.append(text)
    if not rows:
        message = f"{', '.join(specs)}: found no instance, expected one in each line"
        raise GspError(message)
    if output.format != LINES:
        emit(output, Table(_COLUMNS, rows, notes=[_sum(rows)]))
    elif not streamed:
        write(output, "".join(texts))
    code: int = max(row["exit_code"] for row in rows)
    if code and output.format == LINES:
        say(_sum(rows))
    return code


def _sum(rows: Sequence[dict[str, Any]]) -> str:
    """Return how many answers there are of each kind, in words."""
    counts = {
        "complete": sum(row["exit_code"] == 0 for row in rows),
        "infinitely many poses": sum(row["exit_code"] == 3 for row in rows),
        "not completed": sum(row["exit_code"] == 4 for row in rows),
        "wrong": sum(row["exit_code"] in (1, 2) for row in rows),
    }
    parts = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    return f"{len(rows)} instances: {parts}"


def _answers(
    sources: Iterator[Source], answer: Callable[[Source], Answer], jobs: int
) -> Iterator[Answer]:
    """Yield the answers in the order of the sources."""
    from gspcli.workers import Workers

    yield from map(answer, islice(sources, _HERE_FIRST))
    more = list(islice(sources, 1))
    if more:
        yield from Workers(jobs).in_order(answer, chain(more, sources))


def _any_lines(specs: Sequence[str], *, lines: bool) -> bool:
    return lines or any(one.lower().endswith(LINE_SUFFIXES) for one in specs)


def _sources(specs: Sequence[str], *, lines: bool) -> Iterator[Source]:
    for spec in specs:
        if lines or spec.lower().endswith(LINE_SUFFIXES):
            yield from _lines_of(spec)
        else:
            yield Source(spec, None)


def _lines_of(spec: str) -> Iterator[Source]:
    """Yield the lines of a file that are not empty.

    Raises
    ------
    GspError
        If it cannot be read.
    """
    from gspcli.spec.whole_files import LARGEST_SPEC
    from gspcli.wording import named

    name = "standard input" if spec == "-" else spec
    try:
        # A descriptor, closed at the end unless it is standard input.
        with open(0 if spec == "-" else spec, "rb", closefd=spec != "-") as file:
            number = 0
            while line := file.readline(LARGEST_SPEC + 1):
                number += 1
                if len(line) > LARGEST_SPEC:
                    message = f"{named(name)}: line {number} has more than {LARGEST_SPEC >> 20} MB"
                    raise GspError(message)
                if line.strip():
                    text = line.decode("utf-8-sig", errors="surrogateescape")
                    yield Source(f"{name}, line {number}", text)
    except (OSError, ValueError) as error:
        message = f"{named(name)}: cannot be read: {getattr(error, 'strerror', None) or error}"
        raise GspError(message) from error


def _answer(solving: Solving, changes: Changes, source: Source) -> Answer:
    """Return the answer to one instance; its error, if there is one, is part of the answer."""
    head = {"instance": source.name}
    try:
        instance = changes.of(_instance(source))
        result, document, error = solving(instance)
    except GspError as failure:
        said = {"exit_code": failure.exit_code, "message": str(failure)}
        return Answer(_row({**head, "verdict": "no answer", **said}), {**head, **said})
    said = {
        "exit_code": 0 if error is None else error.exit_code,
        "message": None if error is None else str(error),
    }
    counts = result.counts
    row = {
        **head,
        "name": instance.name or None,
        "type": instance.type.id,
        "real": counts.real,
        "found": counts.found,
        "certified": counts.certified,
        "verdict": result.verdict,
        **said,
    }
    return Answer(_row(row), {**head, **said, **document})


def _row(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table, its message in one line."""
    return {**row, "message": row["message"] and row["message"].replace("\n", "; ")}


def _instance(source: Source) -> Instance:
    from gspcli.spec import read, read_text

    if source.text is None:
        return read(spec_source(source.name)).instance
    try:
        source.text.encode()
    except UnicodeEncodeError as error:
        from gspcli.errors import Mistake

        message = f"{source.name}: expected text in UTF-8"
        raise SpecError([Mistake(None, "", message)]) from error
    return read_text(source.text, name=source.name).instance
