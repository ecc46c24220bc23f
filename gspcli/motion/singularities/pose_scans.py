"""Determinants and conditions of poses while one or two of their coordinates vary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.files.pose_files import PoseFormat, pose_columns, poses_of, rotations_of
from gspcli.motion.poses.cranks import drive_values
from gspcli.motion.singularities.pose_clearances import pose_clearances
from gspcli.records import dataclass

Array = NDArray[np.float64]
#: An edge of the grid: its axis and its first node.
Edge = tuple[int, int, int]

_VARIABLE = ("x", "y", "z", "rx", "ry", "rz")
#: Halvings of an edge of the grid: to the last digit of a double.
_HALVINGS = 52


@dataclass(frozen=True)
class PoseAxis:
    """A coordinate of the pose that varies.

    Attributes
    ----------
    name
        ``x``, ``y``, ``z``, or ``rx``, ``ry``, ``rz``.
    values
        The nodes, increasing, in the units of the instance.
    """

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class PoseScan:
    """A grid of poses, and the determinant of the Jacobian matrix on it.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used but for the rods that cranks and slides move:
        these are where the pose asks them to be, on the side of home.
    axes
        One or two coordinates that vary.
    pose
        The numbers of the pose, some of which vary: x, y, z and a quaternion, or three angles, or
        the nine entries of R.
    form
        The conventions of these numbers.
    """

    instance: Instance
    axes: tuple[PoseAxis, ...]
    pose: Sequence[float]
    form: PoseFormat

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if len(names) not in (1, 2) or len(set(names)) < len(names):
            message = "expected one or two different coordinates to vary"
            raise ArgumentError(message, "axes")
        self._check_pose()
        for name in names:
            if name not in self._names or name not in _VARIABLE:
                found = " ".join(self._names)
                message = f"found {name} to vary, expected one of {' '.join(_VARIABLE)}"
                raise ArgumentError(f"{message} that the pose has: {found}", "axes")

    def _check_pose(self) -> None:
        if not self._names:
            message = f"found {len(self.pose)} numbers, expected 6, 7 or 12"
        elif len(self.pose) == len(_VARIABLE) and self.form.euler is None:
            message = "found angles without the order of their axes: say it with euler"
        else:
            wrong = rotations_of(np.array([self.pose[3:]]), self.form)[1]
            message = wrong[0][1] if wrong else ""
        if message:
            raise ArgumentError(message, "pose")

    @property
    def _names(self) -> tuple[str, ...]:
        return pose_columns(len(self.pose)) or ()

    def poses(self, places: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) for numbers of the coordinates that vary, shape (n, axes)."""
        names = self._names
        rows = np.tile(np.asarray(self.pose, dtype=float), (len(places), 1))
        for axis, column in zip(self.axes, places.T, strict=True):
            rows[:, names.index(axis.name)] = column
        return poses_of(rows, self.form)

    def determinants_at(self, places: Array) -> Array:
        """Return determinants of the Jacobian matrix without units; NaN where there is none, (n,).

        Turns are about the centre of the platform's points, lengths in units of the typical
        length of the instance.
        """
        R, T = self.poses(places)
        arrangement = self._arrangement(R, T)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            rows = jacobian(arrangement, R, T)
            length = Arrangement.of(self.instance).length
            rows[..., :3] /= length
            rows[:, arrangement.angles] *= length
            regular = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
            found = np.linalg.det(np.where(regular[:, None, None], rows, np.eye(6)))
        # The determinant does not depend on the point that the platform turns about.
        return np.asarray(np.where(regular, found, np.nan))

    def _arrangement(self, R: Array, T: Array) -> Arrangement:
        """Return the platform with its joints where its drives have them, NaN out of reach."""
        if not is_driven(self.instance):
            return Arrangement.of(self.instance)
        drives, q = drive_values(self.instance, R, T, along=False)
        return drives.arrangement(q)

    @cached_property
    def places(self) -> Array:
        """The nodes, shape (n1, axes) or (n1, n2, axes)."""
        return np.stack(np.meshgrid(*(axis.values for axis in self.axes), indexing="ij"), axis=-1)

    @cached_property
    def determinants(self) -> Array:
        """At the nodes, shape (n1,) or (n1, n2)."""
        flat = self.places.reshape(-1, len(self.axes))
        return self.determinants_at(flat).reshape(self.places.shape[:-1])

    @cached_property
    def conditions(self) -> Array:
        """Condition numbers at the nodes, shape (n1,) or (n1, n2)."""
        R, T = self.poses(self.places.reshape(-1, len(self.axes)))
        found = condition_numbers(self._arrangement(R, T), R, T)
        return np.asarray(found.reshape(self.places.shape[:-1]))

    @cached_property
    def clearances(self) -> Array:
        """Proved distances from singular poses (`pose_clearances`), shape (n1,) or (n1, n2)."""
        if is_driven(self.instance):
            message = (
                "of poses of a machine with cranks or slides there is none here: gsp clearance has "
                "that of one pose"
            )
            raise ArgumentError(message, "clearance")
        R, T = self.poses(self.places.reshape(-1, len(self.axes)))
        found = pose_clearances(self.instance, R, T)
        return np.asarray(found.reshape(self.places.shape[:-1]))

    @cached_property
    def singular(self) -> dict[Edge, Array]:
        """The changes of the sign of the determinant on edges of the grid, each shape (axes,).

        They are found by halving to the last digit. Two changes on one edge are not found.
        """
        signs = np.sign(self.determinants)
        starts, ends, edges = [], [], []
        for axis in range(len(self.axes)):
            low, high = (np.take(signs, _span(signs, axis, k), axis) for k in (0, 1))
            for node in np.argwhere(low * high < 0).tolist():
                other = [k + (d == axis) for d, k in enumerate(node)]
                starts.append(self.places[tuple(node)])
                ends.append(self.places[tuple(other)])
                edges.append((axis, node[0], node[1] if len(node) == 2 else 0))
        if not edges:
            return {}
        a, b = np.array(starts), np.array(ends)
        before = np.sign(self.determinants_at(a))
        for _ in range(_HALVINGS):
            middle = (a + b) / 2
            same = np.sign(self.determinants_at(middle)) == before
            a, b = np.where(same[:, None], middle, a), np.where(same[:, None], b, middle)
        # Where a machine with cranks or slides does not reach, the sign is not known.
        known = np.isfinite(self.determinants_at(a)) & np.isfinite(self.determinants_at(b))
        middles = zip(edges, (a + b) / 2, known.tolist(), strict=True)
        return {edge: middle for edge, middle, there in middles if there}

    @cached_property
    def curves(self) -> list[Array]:
        """The singular curve through these points, over two coordinates, in parts of shape (n, 2).

        Two points in a cell of the grid are joined; four are joined by the sign in the middle.
        """
        if len(self.axes) != 2:
            return []
        links: dict[Edge, list[Edge]] = {edge: [] for edge in self.singular}
        for first, second in self._joined():
            links[first].append(second)
            links[second].append(first)
        return [np.stack([self.singular[edge] for edge in chain]) for chain in _chains(links)]

    def _joined(self) -> Iterator[tuple[Edge, Edge]]:
        rows, columns = self.determinants.shape
        cells = {
            (i - di, j - dj)
            for axis, i, j in self.singular
            for di, dj in (((0, 0), (0, 1)) if axis == 0 else ((0, 0), (1, 0)))
        }
        for i, j in sorted(cells):
            if not (0 <= i < rows - 1 and 0 <= j < columns - 1):
                continue
            around: list[Edge] = [(0, i, j), (1, i + 1, j), (0, i, j + 1), (1, i, j)]
            here = [edge for edge in around if edge in self.singular]
            if len(here) == 2:
                yield here[0], here[1]
            elif len(here) == 4:
                corners = self.places[i : i + 2, j : j + 2].reshape(-1, 2)
                middle = np.sign(self.determinants_at(corners.mean(axis=0)[None]))[0]
                # The curve cuts off the corners whose sign is not that of the middle.
                turn = 0 if middle == np.sign(self.determinants[i, j]) else 1
                yield around[0], around[1 if turn == 0 else 3]
                yield around[2], around[3 if turn == 0 else 1]


def _span(array: Array, axis: int, first: int) -> NDArray[np.intp]:
    return np.arange(first, array.shape[axis] - 1 + first)


def _chains(links: dict[Edge, list[Edge]]) -> list[Sequence[Edge]]:
    """Return the chains and rings of a graph whose nodes have at most two neighbours."""
    left = dict(links)
    chains: list[Sequence[Edge]] = []
    starts = [edge for edge, others in links.items() if len(others) < 2]
    for start in (*starts, *links):
        if start not in left:
            continue
        chain, here = [start], left.pop(start)
        while ahead := [edge for edge in here if edge in left]:
            chain.append(ahead[0])
            here = left.pop(ahead[0])
        if len(chain) > 2 and start in here and len(links[start]) == 2:
            chain.append(start)
        chains.append(chain)
    return chains
