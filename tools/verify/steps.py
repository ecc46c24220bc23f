"""The steps of verification: what is derived again, and by which command."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Step:
    """Something that is derived again.

    Attributes
    ----------
    name
        Its name on the command line.
    subject
        The records that it derives: patterns of files in the project.
    command
        A program of tools, or `gsp`, with its arguments.
    whole, sample
        What to add for all of it, and for a sample; None leaves it out of the fast run. In the
        command ``{jobs}`` and ``{work}`` are the number of processes and the folder of work files.
    """

    name: str
    subject: tuple[str, ...]
    command: str
    whole: str = ""
    sample: str | None = ""

    def words(self, *, fast: bool, jobs: int, work: Path) -> list[str]:
        """Return the command."""
        more = self.whole if self.sample is None or not fast else self.sample
        words = shlex.split(f"{self.command} {more}")
        module = "gspcli" if words[0] == "gsp" else words[0]
        rest = (word.format(jobs=jobs, work=work) for word in words[1:])
        return [sys.executable, "-m", module, *rest]


STEPS = (
    Step("paper", ("data/paper/*",), "gsp table all --check"),
    Step("constraints", ("data/constraints.json",), "tools.build.constraints --check"),
    Step("varieties", ("data/varieties.json",), "tools.build.varieties --check"),
    Step(
        "start-systems",
        ("data/start-systems/*",),
        "tools.build.start_systems --check",
        sample="--sample 20",
    ),
    Step(
        "examples",
        ("data/examples/*", "data/platforms/*"),
        "tools.build.example_counts --check",
        sample="--sample 12",
    ),
    Step(
        "examples-groebner",
        ("data/examples/*", "data/platforms/*"),
        "tools.build.example_counts --check --groebner",
        sample="--sample 6",
    ),
    Step(
        "shared-joints",
        ("data/verification/coincident-platforms*",),
        "tools.build.coincident_counts --check",
    ),
    Step(
        "shared-joints-groebner",
        ("data/verification/coincident-platforms*",),
        "tools.build.coincident_counts --check --groebner",
        sample="--sample 6",
    ),
    Step(
        "special-platforms",
        ("data/verification/special-platforms.csv", "data/verification/published-hexapods.json"),
        "tools.verify.special count --check --jobs {jobs}",
        sample="--sample 12 --without-real",
    ),
    Step(
        "special-answers",
        ("data/verification/special-platforms.csv",),
        "tools.verify.special solve --check --jobs {jobs}",
        sample="--sample 12 --seeds 1",
    ),
    Step(
        "special-batches",
        ("data/verification/special-platforms.csv",),
        "tools.verify.special batches --check --jobs {jobs}",
        sample="--sample 8",
    ),
    Step(
        "special-certificates",
        ("data/verification/special-platforms.csv",),
        "tools.verify.special certify --check --jobs {jobs}",
        whole="--sample 200",
        sample="--sample 4",
    ),
    Step(
        "realistic-machines",
        ("data/verification/realistic-machines*",),
        "tools.verify.realistic --check --jobs {jobs}",
        sample="--sample 6",
    ),
    Step(
        "tracking",
        ("data/counts/*",),
        "gsp atlas verify --method tracking --jobs {jobs}",
        whole="--work {work}/tracking.jsonl",
        sample="--fast",
    ),
    Step(
        "groebner",
        ("data/counts/*",),
        "gsp atlas verify --method groebner --jobs {jobs}",
        whole="--work {work}/groebner.jsonl",
        sample="--fast",
    ),
    Step(
        "exact-counts",
        ("data/counts/families.csv",),
        "tools.verify.counts families --check",
        sample="--sample 25",
    ),
    Step(
        "witnesses",
        ("data/witnesses/real.csv", "data/witnesses/manifest.json"),
        "tools.witnesses check --jobs {jobs}",
        sample="--sample 12",
    ),
    Step(
        "real-page",
        ("docs/real-counts.md", "docs/images/real-families.svg"),
        "tools.build.real_page --check",
    ),
    Step(
        "real-counts",
        ("data/witnesses/counts.csv", "data/witnesses/counts.manifest.json"),
        "tools.witnesses.counts check --jobs {jobs}",
        sample="--sample 40",
    ),
    Step(
        "solve",
        (
            "data/verification/platforms-6-6.csv",
            "data/verification/families.csv",
            "data/verification/batches.csv",
            "data/verification/manifest.json",
            "docs/random-platforms.md",
        ),
        "tools.verify.solve all --check --jobs {jobs} --work {work}",
        sample="--sample 3",
    ),
    Step(
        "tracks",
        ("data/verification/tracks.csv", "data/trajectories/*"),
        "tools.verify.tracks --check --jobs {jobs} --work {work}",
        sample="--sample 2",
    ),
    Step(
        "round-trips",
        ("data/verification/round-trips.csv",),
        "tools.verify.round_trips --check --jobs {jobs} --work {work}",
        sample="--sample 20",
    ),
    Step(
        "hostile-runs",
        ("data/verification/hostile-runs*",),
        "tools.fuzz.commands --check",
        sample="--sample 20",
    ),
    Step(
        "clearances",
        ("data/verification/clearances.csv",),
        "tools.verify.clearances --check --jobs {jobs}",
        sample="--sample 2",
    ),
    Step(
        "driven-workspaces",
        ("data/verification/driven-workspaces.csv",),
        "tools.verify.driven_workspaces --check --jobs {jobs}",
        sample="--sample 4",
    ),
    Step(
        "driven-clearances",
        ("data/verification/driven-clearances.csv",),
        "tools.verify.driven_clearances --check --jobs {jobs}",
        sample="--sample 2",
    ),
    Step(
        "paths",
        ("data/verification/paths.csv",),
        "tools.verify.paths --check --jobs {jobs} --work {work}",
        sample="--only groups --only 'groups with ranges' --only lengths",
    ),
    Step(
        "driven-paths",
        ("data/verification/driven-paths.csv",),
        "tools.verify.driven_paths --check --jobs {jobs}",
        sample=None,
    ),
    Step(
        "gaps",
        ("data/verification/gaps.csv", "data/verification/driven-gaps.csv"),
        "tools.verify.gaps --check",
    ),
    Step(
        "nearest",
        ("data/verification/nearest.csv",),
        "tools.verify.nearest --check --jobs {jobs}",
        sample="--sample 1",
    ),
    Step(
        "nearest-requests",
        ("data/verification/nearest-requests.csv",),
        "tools.verify.controllers.nearest --check --jobs {jobs}",
        sample="--sample 1",
    ),
    Step(
        "sensors",
        ("data/verification/sensors*", "docs/sensors.md"),
        "tools.verify.sensors --check --jobs {jobs}",
        sample="--sample 3",
    ),
    Step(
        "controllers",
        ("data/verification/controllers.csv",),
        "tools.verify.controllers.walks --check --jobs {jobs} --work {work}",
        sample="--sample 3",
    ),
    Step(
        "controller-rounding",
        ("data/verification/controller-rounding.csv",),
        "tools.verify.controllers.rounding --check --jobs {jobs} --work {work}",
        sample="--sample 6",
    ),
    Step(
        "linuxcnc",
        ("data/verification/linuxcnc.csv",),
        "tools.verify.controllers.linuxcnc --check --jobs {jobs} --work {work}",
        sample="--sample 1",
    ),
    Step(
        "machine-exports",
        (),
        "tools.verify.machine_files exports --check",
        sample="--sample 3",
    ),
    Step("machine-fuzz", (), "tools.verify.machine_fuzz --check", sample="--sample 35"),
    Step(
        "mutants",
        ("data/verification/mutants*",),
        "tools.verify.mutants --check --jobs {jobs}",
        sample="--sample 3",
    ),
    Step("view", ("data/view/*",), "tools.build.view --check"),
    Step(
        "live",
        ("data/verification/live.csv",),
        "tools.verify.live --check --jobs {jobs} --work {work}",
        sample="--sample 3",
    ),
    Step("live-module", ("data/live/*",), "tools.build.live_module --check --jobs {jobs}"),
    Step(
        "distribution",
        ("docs/real-samples.md", "docs/images/real-6-6.svg"),
        "tools.build.distribution --check --jobs {jobs}",
        sample=None,
    ),
    Step("latex", (), "tools.verify.latex --check", sample=None),
    Step("schema", ("data/instance.schema.json",), "tools.build.schema --check"),
    Step(
        "counts-page",
        ("docs/counts.md", "docs/images/counts.svg"),
        "tools.build.counts --docs --check",
    ),
    Step(
        "pictures",
        ("docs/images/bound.svg", "docs/images/enumerate.svg", "docs/images/solve.svg"),
        "tools.build.pictures --check",
    ),
    Step(
        "drawings",
        (
            "docs/images/example-6.8.svg",
            "docs/images/figure-1*.svg",
            "docs/images/[AD]??*.svg",
            "docs/images/platforms/*.svg",
        ),
        "tools.build.drawings --check",
    ),
    Step("how-it-works", ("docs/images/paths.svg",), "tools.build.how_it_works --check"),
    Step("live-picture", ("docs/images/live.webp",), "tools.build.live_picture --check"),
    Step("peer-table", ("README.md",), "tools.build.peer_table --check"),
    Step("shown-output", ("README.md", "docs/*.md"), "tools.build.shown_output --check"),
    Step(
        "calibration-page",
        ("docs/calibration/*.csv", "docs/images/calibration-*.svg"),
        "tools.build.calibration_page --check",
    ),
)
