"""The search for the simple poses of one system, by means that cost more and more."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.counting import poses_by_elimination
from gspcli.certification.equations.normalized import many_digits, normalized
from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.distinct import same
from gspcli.certification.poses.isolation import Isolation
from gspcli.certification.poses.locator import FIRST_PRECISION, AtInfinity, Located, Locator
from gspcli.certification.poses.partners import is_alone, partner
from gspcli.continuation.pursuit import PursuedEnds, Pursuit, joined_ends
from gspcli.continuation.systems import Coefficients, ExtendedCoefficients
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import Field, pose_from_study, unit_quaternion
from gspcli.solver.study_systems import coefficients_of

#: Bits in which all poses are computed by elimination, and the largest number for which that is
#: worth it: some seconds; with the fewest bits, where most paths lead to none.
_ELIMINATION = (512, 1024, 2048)
_ELIMINABLE, _MOST_ELIMINABLE = 130, 200
#: The first elimination takes as long as so many paths with 64 digits, or as this part of the cube
#: of all paths.
_ELIMINATION_PATHS = 8, 1 / 8000
#: Sets of random paths that are tried, and at most if each of them leads to more poses.
_ATTEMPTS, _MOST_ATTEMPTS = 3, 8
#: The attempt whose paths are followed in doubles; those with more digits follow others.
_OTHER_PATHS = _MOST_ATTEMPTS
#: Poses that agree to this part of their largest entry are not worth locating again.
_KNOWN = 1e-13
#: Points with smaller imaginary parts may be real.
_NEARLY_REAL = 1e-6


class Effort(IntEnum):
    """What comes next."""

    LITTLE = 0
    """What takes about as long as following the paths in doubles did."""
    SOME = 1
    """The long rest of some ways, with 32 digits."""
    MORE = 2
    """The same with 64, or what takes its place."""
    MUCH = 3
    """Each path has been followed as far as all digits lead: what does not use them."""


class Search:
    """The simple poses of an instance with the sides of its planes chosen, as they are proved.

    Parameters
    ----------
    arrangement
        The platform in floating point.
    locator
        Of the exact instance, with points in the coordinates of ``arrangement.normalized``.
    pursuit
        The paths.
    sides
        For each constraint the index of its equation (`BallSystem.equations`).

    Attributes
    ----------
    found
        What is proved so far.
    infinite
        The simple solutions at infinity that were met, all different.
    left
        The ends, with 64 digits, of paths that have led to none of these.
    simple
        Whether all poses are to be simple ones. They are found without paths, then, before many
        paths are followed with the most digits, which takes longer.
    steps
        Adds poses by one means after the other, and yields the `Effort` of the next;
        whoever has enough stops asking.
    """

    def __init__(
        self,
        arrangement: Arrangement,
        locator: Locator,
        pursuit: Pursuit,
        sides: tuple[int, ...],
    ) -> None:
        self.arrangement = arrangement
        self.locator = locator
        self.pursuit = pursuit
        self.sides = sides
        self.found = Collection(locator, sides)
        self.infinite: list[Isolation] = []
        self.left: PursuedEnds | None = None
        self.simple = False
        self._shared: list[Located] = []
        self.steps = self._steps()

    def _steps(self) -> Iterator[Effort]:
        ends = self.pursuit.first()
        proved = self._add_simple(ends)
        yield Effort.LITTLE
        unproved = ends.simple & ~proved
        if unproved.any():
            self._locate(ends.take(unproved))
            yield from self._compared(Effort.LITTLE)
        astray = np.flatnonzero(~proved & ~unproved)
        near, better = self.pursuit.converged(ends.take(astray), self._target)
        found = near[self._locate(better)]
        yield from self._compared(Effort.LITTLE)
        left = yield from self._follow_deeply(np.delete(astray, found), Effort.SOME, 0)
        if len(found):
            # Those of Newton's method may be the poses of other paths.
            yield from self._follow_deeply(astray[found], Effort.SOME, 0)
        if self._shared:
            self._add_partners()
        yield Effort.MORE
        # Where a path jumped another one leads to the pose that is missing, and takes far less
        # than more digits do.
        others = self.pursuit.others(_OTHER_PATHS)
        if self._locate(others.take(others.simple)).any():
            yield from self._compared(Effort.MORE)
        paths = self.pursuit.paths
        tried = 0
        # Where nothing is found at all, paths with more digits hardly find more.
        few, of_cube = _ELIMINATION_PATHS
        many = len(left) > (max(few, of_cube * paths**3) if len(self.found) else few)
        if self.simple and paths <= _MOST_ELIMINABLE and many:
            tried = 1
            self._eliminate(_ELIMINATION[0])
            yield Effort.MORE
        yield from self._follow_deepest(left, Effort.MORE, 0)
        for bits in _ELIMINATION[tried:] if paths <= _ELIMINABLE else ():
            self._eliminate(bits)
            yield Effort.MUCH
        if not len(self.found) and self.left is not None and not self.left.settled.any():
            # All poses are farther away than any paths lead.
            return
        for attempt in range(1, _MOST_ATTEMPTS):
            before = len(self.found)
            left = yield from self._follow_deeply(np.arange(paths), Effort.MUCH, attempt)
            yield from self._follow_deepest(left, Effort.MUCH, attempt)
            if attempt + 1 >= _ATTEMPTS and len(self.found) == before:
                break

    def _follow_deeply(
        self, index: NDArray[np.intp], effort: Effort, attempt: int
    ) -> Generator[Effort, None, NDArray[np.intp]]:
        """Add the poses at the ends of some paths, with 32 digits; return which led to none."""
        new = np.zeros(len(index), np.bool_)
        for which, ends in self.pursuit.deeply(index, self._target, attempt):
            new[which[ends.settled]] = self._locate(ends.take(ends.settled))
            yield effort
        yield from self._compared(effort)
        # Two paths to one pose: one of them has jumped.
        return index[~new]

    def _follow_deepest(
        self, index: NDArray[np.intp], effort: Effort, attempt: int
    ) -> Iterator[Effort]:
        """Add the poses at the ends of some paths, with 64 digits, and keep those of the others."""
        left = []
        for _, ends in self.pursuit.deepest(index, self._target, attempt):
            left.append(ends.take(~self._locate(ends)))
            yield effort
        self._add_partners()
        self.left = joined_ends(left)
        yield Effort.MUCH

    @cached_property
    def _target(self) -> ExtendedCoefficients:
        """The equations from the exact numbers, in 32 digits."""
        arrangement = self.arrangement
        asked = np.where(arrangement.sides == 0, 1 - 2 * np.array(self.sides), arrangement.signs)
        with many_digits():
            numbers = normalized(self.locator.instance, self.locator.frames)
            values = numbers.values * np.where(asked < 0, -1, 1)
            structure, coefficients = coefficients_of(arrangement.kinds, *numbers[:4], values[None])
            order = list(structure.order)
            given = Coefficients(*(x[0, order] for x in coefficients))
            return ExtendedCoefficients.of(self.pursuit.balanced(given))

    def _compared(self, effort: Effort) -> Iterator[Effort]:
        """Yield, and where that was not enough add conjugates that only balls tell from others."""
        yield effort
        if self.found.add_close_conjugates():
            yield effort

    def _add_simple(self, ends: PursuedEnds) -> NDArray[np.bool_]:
        """Add the ends that floating point can prove; return which."""
        R, T, quaternions = self._in_frames(ends.points)
        finite = np.isfinite(T).all(axis=1)
        proved = np.zeros(len(ends.points), np.bool_)
        proved[finite] = self.found.add_doubles(R[finite], T[finite], quaternions[finite])
        return proved

    def _locate(self, ends: PursuedEnds) -> NDArray[np.bool_]:
        """Add the poses near ends, and their conjugates; return which ends have led to new ones."""
        if not len(ends.points):
            return np.zeros(0, np.bool_)
        new = ~self._is_known(ends)
        index = np.flatnonzero(new)
        # One of each pair of conjugates is enough.
        source = index[_sources(ends.points[index])]
        sought = index[source == index]
        new[sought], located = self._adds_near(ends.take(sought))
        new[index] = new[source]
        self.found.add_conjugates()
        for end in located:
            if isinstance(end, AtInfinity):
                isolation = end.isolation
                if not any(same(isolation, other) for other in self.infinite):
                    self.infinite.append(isolation)
        return new

    def _adds_near(
        self, ends: PursuedEnds
    ) -> tuple[NDArray[np.bool_], list[Located | AtInfinity | None]]:
        """Add the poses near ends; return near which were new ones, and what balls prove."""
        new = self.found.add_with_digits(ends.points, ends.low)
        left = np.flatnonzero(~new)
        if not len(left):
            return new, []
        near = self.pursuit.improved(ends.take(left), self._target)
        new[left] = self.found.add_with_digits(near.points, near.low)
        rest = np.flatnonzero(~new[left])
        near = near.take(rest)
        bits = FIRST_PRECISION * near.digits // 16
        located = self.locator.locate(near.points, near.low, self.sides, bits)
        new[left[rest]] = [self._adds(end) for end in located]
        return new, located

    def _adds(self, end: Located | AtInfinity | None) -> bool:
        """Add what a path has led to; return whether that is new."""
        if self.found.add([end]):
            return True
        if isinstance(end, Located) and not is_alone(end):
            # Two paths to one pose may be those to two that are side by side.
            self._shared.append(end)
        return False

    def _add_partners(self) -> None:
        """Add the second of two poses side by side where two paths have led to the first."""
        tried: list[Located] = []
        for pose in self._shared:
            if not any(same(pose.isolation, other.isolation) for other in tried):
                tried.append(pose)
                self.found.add([partner(self.locator, pose)])
        self._shared.clear()
        self.found.add_conjugates()
        self.found.add_close_conjugates()

    def _eliminate(self, bits: int) -> None:
        """Add the poses that eigenvectors give, paths or not."""
        instance = self.locator.instance
        for pose in poses_by_elimination(instance, bits, seed=self.pursuit.seed) or ():
            if self._is_on_sides(pose.signs):
                start = self.locator.point_of_pose(pose.R, pose.T, bits)
                self.found.add([self.locator.locate_exactly(start, self.sides, bits // 2)])
        self.found.add_conjugates()
        self.found.add_close_conjugates()

    def _is_on_sides(self, signs: tuple[int, ...]) -> bool:
        """Whether signs of the distances mean the equations of this search."""
        each = zip(signs, self.sides, self.arrangement.sides.tolist(), strict=True)
        return all((sign < 0) == (side == 1) for sign, side, asked in each if asked == 0)

    def _in_frames(self, points: Field) -> tuple[Field, Field, Field]:
        """Return R, T and quaternions of Study points of the normalized arrangement."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            R, T = pose_from_study(points[:, :4], points[:, 4:])
            return R, self.arrangement.restored(R, T), unit_quaternion(points[:, :4])

    def _is_known(self, ends: PursuedEnds) -> NDArray[np.bool_]:
        """Return which ends are proved poses as well as doubles tell, shape (k,)."""
        R, T, _ = self._in_frames(ends.points)
        here, known = (
            np.concatenate((x.reshape(-1, 9), y / self.arrangement.length), axis=1)
            for x, y in ((R, T), (self.found.R, self.found.T))
        )
        with np.errstate(invalid="ignore"):
            size = np.abs(here).max(axis=1, initial=1.0)
            near = [
                (np.abs(known - pose).max(axis=1) < _KNOWN * unit).any()
                for pose, unit in zip(here, size.tolist(), strict=True)
            ]
        return np.array(near, np.bool_).reshape(len(here))


def _sources(points: Field) -> NDArray[np.intp]:
    """Return for each Study point an earlier one whose conjugate it is, else itself, shape (k,).

    Lost paths may end at no point at all; those are nobody's conjugates.
    """
    source = np.arange(len(points))
    for i, point in enumerate(points):
        k = np.abs(point[:4]).argmax()
        others = points[:i].conj()
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = point / point[k]
            size = np.repeat([1.0, np.abs(unit[4:]).max()], 4)
            if np.abs(unit.imag / size).max() < _NEARLY_REAL:
                continue
            gaps = np.abs((others / others[:, k : k + 1] - unit) / size).max(axis=1, initial=0.0)
        same = np.flatnonzero(gaps < _KNOWN)
        if len(same):
            source[i] = source[same[0]]
    return source
