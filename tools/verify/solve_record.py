"""The record of random platforms solved: rows, manifest, and docs/random-platforms.md."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from platform import machine
from typing import Any

from gspcli import __version__
from gspcli.defaults import SEED
from tools.recording import ROOT, csv_text, save, sha256, versions, with_section
from tools.verify.examination import Finding
from tools.verify.random_platforms import Task

RECORDS = ROOT / "data" / "verification"
PAGE = ROOT / "docs" / "random-platforms.md"
#: Columns of the record that rounding errors change.
ROUNDING = {"largest_residual", "smallest_separation", "largest_asymmetry"}


@dataclass(frozen=True)
class Examined:
    """What was found of the platforms of a task, in their order."""

    task: Task
    findings: tuple[Finding, ...]

    @classmethod
    def of_entry(cls, entry: Mapping[str, Any]) -> Examined:
        """Return what a line of the journal stands for."""
        return cls(Task(**entry["task"]), tuple(map(Finding.of_entry, entry["findings"])))

    @property
    def problems(self) -> list[tuple[int, Finding]]:
        """Numbers of the instances of which something does not hold, with what was found."""
        return [(i, finding) for i, finding in enumerate(self.findings) if finding.problems]

    @property
    def row(self) -> dict[str, object]:
        """Its row of the record."""
        real = Counter(finding.real for finding in self.findings)
        return {
            "task": self.task.name,
            "instances": len(self.findings),
            "expected": " ".join(str(n) for n in sorted({f.expected for f in self.findings})),
            "complete": sum(not finding.problems for finding in self.findings),
            "found": sum(finding.found for finding in self.findings),
            "largest_residual": f"{max(finding.residual for finding in self.findings):.1e}",
            "smallest_separation": f"{min(finding.separation for finding in self.findings):.1e}",
            "largest_asymmetry": f"{max(finding.asymmetry for finding in self.findings):.1e}",
            "real": " ".join(f"{poses}:{times}" for poses, times in sorted(real.items())),
        }


def write(name: str, command: str, origin: str, done: Sequence[Examined]) -> None:
    """Write the record of a finished run, its entry in the manifest, and the page."""
    table = csv_text([examined.row for examined in done])
    path = RECORDS / "manifest.json"
    manifest = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    findings = [finding for examined in done for finding in examined.findings]
    manifest[name] = {
        "command": command,
        "seed": SEED,
        "versions": {"gsp": __version__, **versions("numpy")},
        "machine": machine(),
        "sources_sha256": origin,
        "sha256": sha256(table),
        "instances": len(findings),
        "poses": sum(finding.found for finding in findings),
        "expected": sum(finding.expected for finding in findings),
        "largest_residual": float(f"{max(finding.residual for finding in findings):.1e}"),
        "smallest_separation": float(f"{min(finding.separation for finding in findings):.1e}"),
        "problems": [
            {"task": examined.task.name, "instance": number, "problems": list(finding.problems)}
            for examined in done
            for number, finding in examined.problems
        ],
    }
    files = {
        RECORDS / f"{name}.csv": table,
        path: json.dumps(dict(sorted(manifest.items())), indent=1) + "\n",
        PAGE: with_section(PAGE, "record", summary(manifest)),
    }
    save(files, check=False, confirmed="")


def differences(name: str, done: Sequence[Examined], *, whole: bool) -> Iterator[str]:
    """Yield in which rows a run differs from the record, apart from rounding errors.

    Parameters
    ----------
    name
        The run.
    done
        What was found.
    whole
        Whether that is all of the run.
    """
    content = (RECORDS / f"{name}.csv").read_bytes()
    manifest = json.loads((RECORDS / "manifest.json").read_text(encoding="utf-8"))
    if sha256(content) != manifest[name]["sha256"]:
        yield f"{name}.csv: this is not the file of the manifest"
    if summary(manifest) not in PAGE.read_text(encoding="utf-8"):
        yield f"docs/{PAGE.name}: the record shown is another one"
    recorded = {row["task"]: row for row in csv.DictReader(content.decode().splitlines())}
    found = {examined.task.name: examined.row for examined in done}
    for task in found if not whole else {**found, **recorded}:
        ours, theirs = found.get(task, {}), recorded.get(task, {})
        for column in sorted({**ours, **theirs}.keys() - ROUNDING):
            if str(ours.get(column)) != theirs.get(column):
                yield f"{name}, {task}: {column} {theirs.get(column)}, now {ours.get(column)}"


def summary(manifest: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the record as a table and a list of problems, in Markdown."""
    lines = [
        "| run | platforms | poses expected | found | with problems | largest residual "
        "| nearest two poses |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| `{run['command']}` | {run['instances']} | {run['expected']} | {run['poses']} "
            f"| {len(run['problems'])} | {run['largest_residual']} "
            f"| {run['smallest_separation']} |"
            for run in manifest.values()
        ),
        "",
    ]
    for problem in (problem for run in manifest.values() for problem in run["problems"]):
        words = ", ".join(problem["problems"])
        lines.append(f'- `show "{problem["task"]}" {problem["instance"]}`: {words}')
    return "\n".join(lines).rstrip()
