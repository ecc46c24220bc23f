"""What all programs here share: with ``--check`` a record is compared instead of written.

Exit codes are those of `gsp`: 0 done or confirmed, 1 something differs, 2 wrong usage, 4 the
answer could not be completed, such as without a program that is needed.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from random import Random
from typing import Any, TypeVar

from gspcli.defaults import SEED
from gspcli.errors import CheckFailed, IncompleteError
from gspcli.workers import Workers

ROOT = Path(__file__).resolve().parents[1]
CONFIRMED, DIFFERENT, UNABLE = 0, CheckFailed.exit_code, IncompleteError.exit_code
#: Kept beside records, and free to differ from one machine to another.
_OF_THE_MACHINE = "versions"

Item = TypeVar("Item")


def parser(doc: str | None, *, sample: bool = False) -> argparse.ArgumentParser:
    """Return a parser for ``--check`` and, if the work is long, ``--sample N``."""
    result = argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    result.add_argument("--check", action="store_true", help="compare with the record")
    if sample:
        add_sample(result)
    return result


def add_sample(to: argparse.ArgumentParser) -> None:
    """Add the option ``--sample N``."""
    help_text = "with --check: only this many, drawn at random; of the rest nothing is said"
    to.add_argument("--sample", type=int, metavar="N", help=help_text)


def add_workers(to: argparse.ArgumentParser) -> None:
    """Add the options ``--jobs N`` and ``--scheduler ADDRESS``."""
    to.add_argument("--jobs", type=int, default=1, metavar="N", help="processes that work at once")
    help_text = "let the workers of this Dask scheduler do it, which run in this checkout"
    to.add_argument("--scheduler", metavar="ADDRESS", help=help_text)


def workers_of(arguments: argparse.Namespace) -> Workers:
    """Return who does the work, as these options say."""
    return Workers(arguments.jobs, arguments.scheduler)


def sampled(items: Iterable[Item], size: int | None) -> list[Item]:
    """Return this many of the items, always the same and in their order; all if None."""
    every = list(items)
    if size is None:
        return every
    return [every[k] for k in sorted(Random(SEED).sample(range(len(every)), min(size, len(every))))]


def save(files: Mapping[Path, str | bytes], *, check: bool, confirmed: str) -> int:
    """Write files whole, or compare them; return the exit code.

    Parameters
    ----------
    files
        Contents by path. Of JSON the values count and versions do not, of others every byte.
    check
        Whether to compare.
    confirmed
        What a comparison without difference confirms, such as ``10 varieties``.
    """
    if check:
        return report([f"{_name(p)}: differs" for p in files if _differs(p, files[p])], confirmed)
    for path, content in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    return CONFIRMED


def report(differences: Sequence[str], confirmed: str) -> int:
    """Print how a comparison ended, and return the exit code."""
    if differences:
        print("\n".join(differences))
        return DIFFERENT
    print(f"confirmed: {confirmed}")
    return CONFIRMED


def _differs(path: Path, content: str | bytes) -> bool:
    data = content.encode() if isinstance(content, str) else content
    if not path.is_file():
        return True
    recorded = path.read_bytes()
    if path.suffix == ".json":
        return _values(recorded) != _values(data)
    return recorded != data


def _values(document: bytes) -> object:
    def without_versions(entries: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in entries.items() if key != _OF_THE_MACHINE}

    try:
        return json.loads(document, object_hook=without_versions)
    except ValueError:
        return document


def _name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else str(path)


def csv_text(rows: Sequence[Mapping[str, object]]) -> str:
    """Return rows with the same keys as CSV, the keys first."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def with_section(page: Path, name: str, content: str) -> str:
    """Return the text of a page with other content between its marks of a section."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->\n"
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n{content.strip()}\n\n{end}{after}"


def versions(*packages: str) -> dict[str, str]:
    """Return the versions of Python and of some packages, as manifests have them."""
    return {"python": python_version()} | {name: version(name) for name in packages}


def sha256(content: str | bytes) -> str:
    """Return the sha256 of a text in UTF-8, or of bytes."""
    data = content.encode() if isinstance(content, str) else content
    return hashlib.sha256(data).hexdigest()


def canonical_sha256(content: object) -> str:
    """Return the sha256 of a JSON value in its canonical form."""
    return sha256(json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False))
