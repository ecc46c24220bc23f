"""What a solve returns: every pose found and an account of every path."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.catalogue.kinds import DLL
from gspcli.continuation.paths import PathAccount, Verdict
from gspcli.defaults import PATIENCE
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.home_mode import HomeMode, home_among, home_mode
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import LeftLimit, left_limits, restricts
from gspcli.geometry.local_motions import Motion
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import (
    condition_numbers,
    known_sides,
    proved_residuals,
    residuals,
)
from gspcli.records import EqualByContent, dataclass
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.results.proof import CountKind, Proof
from gspcli.solver.results.solution import Counts, Solution

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
SCHEMA = "gsp.solve/1"


@dataclass(frozen=True, eq=False)
class SolveResult(EqualByContent):
    """All poses of an instance.

    The order of the poses does not depend on how they were found (`stable_order`); the first
    component of their quaternions that is not zero is positive.

    Attributes
    ----------
    instance, arrangement
        What was solved, as given and in floating point.
    poses
        Everything found, in this order.
    seed
        The source of random choices.
    left_out
        Indices of real poses of which none can be home.
    """

    instance: Instance
    arrangement: Arrangement
    poses: PoseSet
    seed: int
    left_out: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        for part in vars(self.poses).values():
            if isinstance(part, np.ndarray):
                part.setflags(write=False)

    def __repr__(self) -> str:
        name = self.instance.name or self.instance.type.id
        return f"<SolveResult of {name}: {self.poses.account_text}>"

    def __str__(self) -> str:
        from gspcli.solver.results.columns import plain_table

        return plain_table(self, self.poses.account_text)

    @property
    def R(self) -> Field:
        """Rotations of the poses, shape (n, 3, 3), complex."""
        return self.poses.R

    @property
    def T(self) -> Field:
        """Translations of the poses, shape (n, 3), complex."""
        return self.poses.T

    @property
    def real(self) -> NDArray[np.bool_]:
        """Which poses are real, shape (n,)."""
        return self.poses.real

    @property
    def quaternions(self) -> Field:
        """Unit quaternions of the rotations, shape (n, 4), complex; see `PoseSet`."""
        return self.poses.quaternions

    @property
    def certified(self) -> NDArray[np.bool_]:
        """Which poses are certified, shape (n,)."""
        return self.poses.certified

    @property
    def multiplicity(self) -> NDArray[np.int64]:
        """How many paths end at each pose, shape (n,)."""
        return self.poses.multiplicity

    @property
    def motions(self) -> tuple[Motion, ...]:
        """Sets of poses that are not isolated, as far as they were found."""
        return self.poses.motions

    @property
    def lone(self) -> SolveResult:
        """The same platform with the real poses that are isolated among the real ones only."""
        return replace(self, poses=self.poses.lone.in_order(self.arrangement.length))

    @property
    def drawn(self) -> SolveResult:
        """What there is to look at: itself, or `lone` if no real pose is isolated."""
        return self if self.counts.real else self.lone

    @cached_property
    def home(self) -> HomeMode | None:
        """Which of the real poses of `drawn` is home (`home_mode`); None if there are none."""
        real = self.drawn.real
        R, T = self.drawn.R[real].real, self.drawn.T[real].real
        if not self.left_out or not self.counts.real:
            return home_mode(self.instance, R, T)
        return home_among(self.instance, R, T, [k for k in range(len(R)) if k not in self.left_out])

    @property
    def account(self) -> PathAccount:
        """The account of all paths."""
        return self.poses.account

    @property
    def expected(self) -> int:
        """The generic count for the sides asked for."""
        return self.account.expected

    @property
    def verdict(self) -> Verdict:
        """`infinite`, `incomplete` or `complete`, as the account says."""
        return self.account.verdict

    @property
    def proof(self) -> Proof | None:
        """What proves that there are no other poses, or infinitely many; None if nothing does."""
        return self.poses.proof

    @property
    def exact_count(self) -> int | None:
        """How many poses exactly this platform has, with multiplicity, if that was computed."""
        return self.poses.exact_count

    @cached_property
    def geometry_count(self) -> int | None:
        """How many poses this geometry has for almost all values; None if it was not counted.

        Lines at distance zero have one sign, as in `expected`: for other values they have two. It
        is computed when it is asked for, except where the poses prove it to be the type's.
        """
        if self.proof is not None and self.proof.by is CountKind.TYPE:
            return self.expected
        if self.proof is not None and self.proof.by is CountKind.GEOMETRY:
            return len(self.R)
        if self.exact_count is None and self.verdict != "infinite":
            return None
        from gspcli.certification.counting import geometry_count
        from gspcli.solver.starts.solved_starts import STARTS

        # Distances of zero leave no sides to choose, and are no values in general position.
        known = None
        if self.arrangement.values[self.arrangement.distances].all():
            known = STARTS.count(self.instance, self.arrangement.values, self.seed, PATIENCE)
        count = known or geometry_count(self.instance, seed=self.seed)
        zeros = sum(row.kind is DLL and row.value.value == 0 for row in self.instance.constraints)
        return None if count is None or count.solutions is None else count.solutions >> zeros

    @cached_property
    def counts(self) -> Counts:
        """How many poses there are of which sort."""
        return Counts(
            found=len(self.R),
            real=int(self.real.sum()),
            certified=int(self.certified.sum()),
            singular=int((self.multiplicity > 1).sum()),
        )

    @cached_property
    def residuals(self) -> Array:
        """Residual of each constraint at each pose, units of the instance, shape (n, 6)."""
        R, T, real = self.R, self.T, self.real
        found = np.empty((len(R), 6))
        for measure, chosen in ((proved_residuals, self.certified), (residuals, ~self.certified)):
            at, off = real & chosen, ~real & chosen
            found[at] = measure(self.arrangement, R[at].real, T[at].real)
            found[off] = measure(self.arrangement, R[off], T[off])
        return found

    @cached_property
    def conditions(self) -> Array:
        """Condition number of each pose, shape (n,)."""
        return condition_numbers(self.arrangement, self.R, self.T)

    @cached_property
    def sides(self) -> NDArray[np.int64]:
        """On which side of each plane: 1, -1, or 0 if that is not known, shape (n, 6)."""
        sides = known_sides(self.arrangement, self.R, self.T)
        if self.poses.signs is None:
            return sides
        proved = self.arrangement.sided & (self.arrangement.targets != 0)
        return np.where((sides == 0) & proved, self.poses.signs, sides).astype(int)

    @cached_property
    def solutions(self) -> tuple[Solution, ...]:
        """The poses one by one."""
        quaternions = self.quaternions
        sides = self.sides
        names = {1: Side.POSITIVE.value, -1: Side.NEGATIVE.value}
        limits = self._limits()
        home = self.home.number if self.home and self.counts.real else None
        return tuple(
            Solution(
                number=k + 1,
                real=bool(self.real[k]),
                certified=bool(self.certified[k]),
                multiplicity=int(self.multiplicity[k]),
                R=self.R[k].real if self.real[k] else self.R[k],
                T=self.T[k].real if self.real[k] else self.T[k],
                quaternion=quaternions[k].real if self.real[k] else quaternions[k],
                residual=float(self.residuals[k].max()),
                condition=float(self.conditions[k]),
                sides={i + 1: names[s] for i, s in enumerate(sides[k].tolist()) if s},
                limits=limits.get(k),
                home=k + 1 == home,
            )
            for k in range(len(self.R))
        )

    def _limits(self) -> dict[int, tuple[LeftLimit, ...]]:
        """Return the limits that real poses do not keep, by their indices, if there are any."""
        if not restricts(self.instance):
            return {}
        real = np.flatnonzero(self.real)
        values = self.arrangement.values * np.where(self.sides[real] < 0, -1.0, 1.0)
        found = left_limits(self.instance, values, self.R[real].real, self.T[real].real)
        return dict(zip(real.tolist(), found, strict=True))

    @property
    def real_R(self) -> NDArray[np.float64]:
        """The rotations of the real poses, real, shape (n, 3, 3)."""
        return self.R[self.real].real

    @property
    def real_T(self) -> NDArray[np.float64]:
        """The translations of the real poses, real, shape (n, 3)."""
        return self.T[self.real].real

    @property
    def real_solutions(self) -> tuple[Solution, ...]:
        """The real poses: the assembly modes."""
        return self.solutions[: self.counts.real]

    def to_json(self, *, everything: bool = False) -> dict[str, Any]:
        """Return the result as plain data of schema ``gsp.solve/1``.

        Parameters
        ----------
        everything
            Whether poses that are not real are included.
        """
        chosen = self.solutions if everything else self.real_solutions
        document: dict[str, Any] = {
            "schema": SCHEMA,
            **self.instance.to_json(),
            "expected": self.expected,
            "verdict": self.verdict,
            "proof": self.proof.to_json() if self.proof else None,
            "geometry_count": self.geometry_count,
            "exact_count": self.exact_count,
            "counts": self._counts_json(),
            "home": None if self.home is None else self.home.to_json(),
            "solutions": [solution.to_json(self.arrangement.length) for solution in chosen],
        }
        if self.motions:
            document["motions"] = [motion.to_json() for motion in self.motions]
        return {**document, "seed": self.seed, "version": __version__}

    def _counts_json(self) -> dict[str, int]:
        account = self.account
        return {
            **vars(self.counts),
            "at_infinity": account.at_infinity,
            "on_curves": account.on_curves,
            "spurious": account.spurious,
            "lost": account.lost,
        }

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the poses to look at (`gspcli.notebook_view`)."""
        # Pictures are in a room above this one: only the package itself imports them.
        from gspcli import notebook_view

        return notebook_view(self)

    def to_frame(self, *, everything: bool = False) -> pd.DataFrame:
        """Return the poses as a table with a row for each (pandas is imported now).

        The columns are those of `gspcli.solver.results.columns`, as in the CSV of `gsp solve`; the
        index is the number, from 1. With ``everything`` the quaternions and translations are
        complex.
        """
        import pandas as pd

        from gspcli.solver.results.columns import COLUMNS

        count = len(self.R) if everything else self.counts.real
        data: dict[str, Any] = {}
        for column in COLUMNS:
            values = column.read(self)[:count]
            data[column.key] = np.real(values) if column.of_pose and not everything else values
        return pd.DataFrame(data, index=pd.RangeIndex(1, count + 1, name="number"))
