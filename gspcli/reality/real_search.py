"""Searches for platforms with many real poses: from a type or a platform to an instance."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.catalogue.names import any_type
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.continuation.start import path_count
from gspcli.defaults import SEARCH_SECONDS, SEED
from gspcli.errors import ArgumentError, GspError, IncompleteError
from gspcli.geometry.instance import Instance, Units
from gspcli.reality.maximize import Search, Solved, attempts
from gspcli.reality.platforms import Platforms, multiplier, reduced
from gspcli.reality.witness_proofs import (
    DEFAULT_UNITS,
    certified_real,
    platform_of,
    real_instance,
)
from gspcli.records import EqualByContent, dataclass
from gspcli.spec import dumps
from gspcli.spec.document import LARGEST_SPEC, content_of
from gspcli.wording import named
from gspcli.workers import HERE, Workers

if TYPE_CHECKING:
    import pandas as pd


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


@dataclass(frozen=True, eq=False)
class RealSearch:
    """A search for a type, or from a first platform.

    Attributes
    ----------
    search
        The search among reduced platforms.
    subject
        The type or platform, by its name in a file of the state.
    units, length
        Units and typical length of the instance that is found.
    """

    search: Search
    subject: str
    units: Units = DEFAULT_UNITS
    length: float = 1.0

    @classmethod
    def of(
        cls, given: GspType | Instance, real: int | None, seconds: float, seed: int = SEED
    ) -> RealSearch:
        """Return a search for a number of real poses, or as many as possible, that begins now."""
        if real is not None and real < 1:
            message = f"found {real}, expected at least one real pose"
            raise ArgumentError(message, "real")
        kinds, start = (given if isinstance(given, GspType) else given.type).kinds, None
        platform, length = (None, 1.0) if isinstance(given, GspType) else platform_of(given)
        if platform is not None:
            kinds, start = platform.kinds, reduced(platform)
        wanted = None if real is None else -(-real // multiplier(kinds))
        search = Search(kinds, seed, wanted, start, time.time() + seconds)
        if isinstance(given, GspType):
            return cls(search, given.id)
        return cls(search, dumps(given), given.units, length)

    @property
    def each(self) -> int:
        """The number of real poses for each real pose of a reduced platform."""
        return multiplier(self.search.kinds)

    def steps(
        self, state: State, most: int | None = None, workers: Workers = HERE
    ) -> Iterator[tuple[int, Solved | None, State]]:
        """Yield number and outcome of each attempt, and the state after it.

        An attempt that the deadline ends does not count, but may have found a better platform.

        Parameters
        ----------
        state
            The first state.
        most
            The most attempts, if there is a limit.
        workers
            The processes that make them.
        """
        everything = path_count(self.search.structure)
        goal = everything if self.search.target is None else min(self.search.target, everything)

        def done(state: State) -> bool:
            return state.real >= goal or (most is not None and state.attempts >= most)

        if done(state):
            return
        for number, found in attempts(self.search, state.attempts, most, workers):
            after = state.after(number, found)
            cut = self.search.is_late
            state = replace(after, attempts=state.attempts) if cut else after
            yield number, found, state
            if done(state) or cut:
                return

    def result(self, state: State) -> RealSearchResult:
        """Return the best platform of a state as an instance, its real poses certified.

        Raises
        ------
        IncompleteError
            If no platform was solved.
        GspError
            If not all of its real poses can be certified.
        """
        if state.platform is None:
            message = "no platform was solved in the time given: give more"
            raise IncompleteError(message)
        wanted = self.each * state.real
        found = real_instance(state.platform, wanted, units=self.units, length=self.length)
        real = certified_real(found)
        if real < wanted:
            message = f"only {real} of {wanted} real poses could be certified"
            raise GspError(message)
        name = f"{found.type.family.id} with {real} real poses"
        return RealSearchResult(replace(found, name=name), real, state.attempts)


@dataclass(frozen=True, eq=False)
class RealSearchResult(EqualByContent):
    """A platform with many real poses.

    Attributes
    ----------
    instance
        The platform.
    real
        The number of certified real poses: a lower bound of the largest number for the type.
    attempts
        The number of attempts.
    """

    instance: Instance
    real: int
    attempts: int

    def __repr__(self) -> str:
        return f"<RealSearchResult of {self.instance.type.id}: {self.real} real poses, certified>"

    def to_frame(self) -> pd.DataFrame:
        """Return one row (pandas is imported now)."""
        import pandas as pd

        row = {"type": self.instance.type.id, "real": self.real, "attempts": self.attempts}
        return pd.DataFrame([row])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data; ``spec`` is the text of the instance file."""
        return {
            **self.instance.to_json(),
            "real": self.real,
            "attempts": self.attempts,
            "spec": dumps(self.instance),
        }


def maximize_real(
    given: GspType | Instance | str,
    *,
    real: int | None = None,
    seconds: float = SEARCH_SECONDS,
    attempts: int | None = None,
    seed: int = SEED,
    workers: Workers = HERE,
) -> RealSearchResult:
    """Search for a platform with as many real poses as possible.

    Parameters
    ----------
    given
        A type or its name, the kinds of whose angles make no difference, or a platform to begin
        with.
    real
        The number of real poses that suffices; as many as possible if None.
    seconds, attempts
        The limits of the search.
    seed
        The seed: an attempt depends on it and on the number of the attempt only.
    workers
        The processes that make the attempts.

    Raises
    ------
    IncompleteError
        If no platform was solved in the time given.
    """
    if not seconds > 0:
        raise ArgumentError(f"found {seconds}, expected more than 0", "seconds")
    named = any_type(given) if isinstance(given, str) else given
    search = RealSearch.of(named, real, seconds, seed)
    state = State(search.subject, seed)
    for _, _, after in search.steps(state, attempts, workers):
        state = after
    return search.result(state)
