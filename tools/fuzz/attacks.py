"""What the attacks on `gsp track` share: commands within the process, and attacks by seeds."""

from __future__ import annotations

import contextlib
import io
from collections import Counter
from collections.abc import Callable

import numpy as np

from gspcli.cli.main import run
from gspcli.defaults import SEED
from gspcli.errors import INTERRUPTED
from tools.recording import CONFIRMED, DIFFERENT, parser

#: Of a seed, a generator for it and the most poses of types: the platform, and what does not hold.
#: The first word `refused` means that nothing can be said.
Attacking = Callable[[int, np.random.Generator, int], tuple[str, list[str]]]


def call(*words: str) -> tuple[int, str, str]:
    """Run a command; return the exit code, what is written and what is said."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run(list(words))
    return code, out.getvalue(), err.getvalue()


def attack_by_seeds(description: str | None, attacking: Attacking) -> int:
    """Read the command line and attack, until Ctrl-C at most; return the exit code."""
    options = parser(description)
    options.add_argument("--count", type=int, default=50, help="how many attacks")
    options.add_argument("--seed", type=int, default=SEED, help="of the first one")
    options.add_argument("--most", type=int, default=32, help="poses of the types")
    arguments = options.parse_args()
    counts: Counter[str] = Counter()
    interrupted = False
    try:
        for seed in range(arguments.seed, arguments.seed + arguments.count):
            name, found = attacking(seed, np.random.default_rng(seed), arguments.most)
            refused = any(problem.startswith("refused") for problem in found)
            counts["refused" if refused else "wrong" if found else "right"] += 1
            for problem in found:
                print(f"seed {seed}, {name}: {problem}", flush=True)
    except KeyboardInterrupt:
        interrupted = True
    print(", ".join(f"{count} {what}" for what, count in sorted(counts.items())))
    return INTERRUPTED if interrupted else DIFFERENT if counts["wrong"] else CONFIRMED
