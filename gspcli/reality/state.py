"""The state of a search in a file, so that the search can be resumed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.errors import GspError
from gspcli.reality.platforms import Platforms
from gspcli.reality.solved_platforms import Solved
from gspcli.records import dataclass
from gspcli.spec.document import LARGEST_SPEC, content_of
from gspcli.wording import named

SCHEMA = "gsp.maximize-real/1"
_PARTS = ("y", "x", "u", "v", "values")
_SHAPES = [*[(CONSTRAINTS, 3)] * 4, (CONSTRAINTS,)]


@dataclass(frozen=True, eq=False)
class State:
    """The outcome of the first attempts of a search.

    Attributes
    ----------
    subject
        The type, or the content of the instance file.
    seed
        The seed of the search.
    attempts
        The number of attempts that are done.
    real
        The number of real solutions of the best reduced platform; 0 if there is none yet.
    platform
        That platform.
    """

    subject: str
    seed: int
    attempts: int = 0
    real: int = 0
    platform: Platforms | None = None

    def after(self, number: int, found: Solved | None) -> State:
        """Return the state after one more attempt."""
        state = replace(self, attempts=number + 1)
        if found is None or found.count <= self.real:
            return state
        return replace(state, real=found.count, platform=found.platform)

    def text(self) -> str:
        """Return the content of the file."""
        document: dict[str, Any] = {
            "schema": SCHEMA,
            "subject": self.subject,
            "seed": self.seed,
            "attempts": self.attempts,
            "real": self.real,
        }
        if self.platform is not None:
            document["kinds"] = [kind.name for kind in self.platform.kinds]
            document |= {part: getattr(self.platform, part).tolist() for part in _PARTS}
        return json.dumps(document) + "\n"


def _finite(numbers: NDArray[np.float64]) -> bool:
    return bool(np.isfinite(numbers).all())


def read_state(path: Path, subject: str, seed: int) -> State:
    """Return the state in a file; that of a new search if there is no file.

    Raises
    ------
    GspError
        If the file is no state, or that of another search.
    """
    try:
        content = content_of(path, LARGEST_SPEC)
    except FileNotFoundError:
        return State(subject, seed)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"{named(path)}: cannot be read: {reason}"
        raise GspError(message) from error
    try:
        document = json.loads(content)
        if document["schema"] != SCHEMA:
            raise ValueError
        platform = None
        if "kinds" in document:
            kinds = tuple(KINDS_BY_NAME[name] for name in document["kinds"])
            parts = [np.array(document[part], float) for part in _PARTS]
            if [part.shape for part in parts] != _SHAPES or not all(map(_finite, parts)):
                raise ValueError
            platform = Platforms(kinds, *parts)
        counts = map(document.get, ("attempts", "real"))
        if any(type(n) is not int or not 0 <= n < 2**63 for n in counts):
            raise ValueError
        state = State(
            document["subject"], document["seed"], document["attempts"], document["real"], platform
        )
    except (ArithmeticError, ValueError, KeyError, TypeError, RecursionError) as error:
        message = f"{path}: this is not a state of gsp maximize-real: choose another file"
        raise GspError(message) from error
    if (state.subject, state.seed) != (subject, seed):
        message = f"{path}: this is the state of a search for other numbers or with another seed"
        raise GspError(message)
    return state
