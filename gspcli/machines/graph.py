"""A machine as described by a file of another program: bodies, and joints between them.

All readers make a `Graph`, and `recognition` reads nothing else. Lengths are in the unit of the
graph, angles in radians.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import GspError
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.records import dataclass
from gspcli.wording import counted


def frame(R: ArrayLike | None = None, T: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the motion with a rotation, shape (3, 3), and a translation, shape (3,)."""
    X = np.eye(4)
    if R is not None:
        X[:3, :3] = R
    X[:3, 3] = T
    return X


def inverse(X: Array) -> Array:
    """Return the inverse of a motion."""
    R = X[:3, :3].T
    return frame(R, -R @ X[:3, 3])


def place(X: Array, point: Array) -> Array:
    """Return where a motion takes points, shape (..., 3)."""
    return np.asarray(point @ X[:3, :3].T + X[:3, 3])


def turn(X: Array, direction: Array) -> Array:
    """Return where a motion takes directions, shape (..., 3)."""
    return np.asarray(direction @ X[:3, :3].T)


def unit(vector: Array) -> Array | None:
    """Return a vector divided by its length; None if that is zero or not finite."""
    length = float(np.linalg.norm(vector))
    return vector / length if 0 < length < np.inf else None


Array = NDArray[np.float64]

#: Singular values of the equations of a graph below this are taken as zero.
_NONE = 1e-6


class NoPlatform(GspError):
    """A file describes no platform with six constraints; the message says what it describes."""


@dataclass(frozen=True, eq=False)
class Part:
    """One freedom of a joint (a hinge or a slide), or a ball."""

    #: R for a hinge, P for a slide, S for a ball.
    letter: str
    #: Unit vector, shape (3,), in the frame of the joint's first body; zero for a ball.
    axis: Array
    #: A point of the axis, or the centre, shape (3,), there.
    point: Array
    #: The joint's coordinate in the configuration of the file.
    at: float = 0.0
    #: The range of the coordinate; infinite where there is none.
    low: float = -math.inf
    high: float = math.inf
    #: Whether a motor moves it.
    driven: bool = False
    #: What the file calls it.
    name: str = ""

    def motion(self, change: Array | float) -> Array:
        """Return the motion by a change of the coordinate; of a ball, a rotation vector."""
        if self.letter == "P":
            return frame(T=self.axis * change)
        turned = np.asarray(change if self.letter == "S" else self.axis * change, float)
        R = rotation_from_vector(turned)
        return frame(R, self.point - R @ self.point)

    def moved(self, X: Array) -> Part:
        """Return it in another frame."""
        return replace(self, axis=turn(X, self.axis), point=place(X, self.point))

    def backwards(self) -> Part:
        """Return the part seen from the second body: same coordinate, opposite axis."""
        return replace(self, axis=-self.axis)

    @property
    def screws(self) -> Array:
        """The twists that it allows, rotation first, shape (1 or 3, 6)."""
        if self.letter == "P":
            return np.concatenate((np.zeros(3), self.axis))[None]
        axes = np.eye(3) if self.letter == "S" else self.axis[None]
        return np.concatenate((axes, np.cross(self.point, axes)), axis=1)


def ball(point: Array, name: str = "") -> Part:
    """Return a ball joint about a point, shape (3,), in the frame of the first body."""
    return Part("S", np.zeros(3), np.asarray(point, float), name=name)


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint between two bodies; without parts it is rigid."""

    #: What the file calls it.
    name: str
    #: The bodies.
    first: str
    second: str
    #: The pose of the second in the first in the configuration of the file, with the joint closed.
    relative: Array
    #: From the first body to the second; each axis is where it is in that configuration.
    parts: tuple[Part, ...] = ()
    #: Whether the file has it as the closure of a loop, and not as a branch of its tree.
    closure: bool = False
    #: How far that closure is open in the configuration of the file.
    gap: float = 0.0

    @property
    def letters(self) -> str:
        """Its parts as RRP; ``fixed`` without any."""
        return "".join(part.letter for part in self.parts) or "fixed"


def closure(
    name: str, bodies: tuple[str, str], there: Array, ends: tuple[Array, Array], weld: Array | None
) -> Joint:
    """Return the closure of a loop: a ball at points of both bodies, (3,) each, or a weld.

    The second body is at the pose `there` in the first, and where it is welded at `weld`, (4, 4).
    """
    gap = float(np.linalg.norm(ends[0] - place(there, ends[1])))
    if weld is not None:
        return Joint(name, *bodies, weld, (), True, gap)
    R = there[:3, :3]
    parts = (ball(ends[0], name),)
    return Joint(name, *bodies, frame(R, ends[0] - R @ ends[1]), parts, True, gap)


@dataclass(frozen=True, eq=False)
class Body:
    """A body."""

    #: What the file calls it.
    name: str
    #: In the world, in the configuration of the file, shape (4, 4).
    pose: Array
    #: Kilogrammes; None if the file does not say.
    mass: float | None = None
    #: Of mass, in its frame, shape (3,).
    centre: Array = field(default_factory=lambda: np.zeros(3))
    #: About the centre, in its axes, shape (3, 3).
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, eq=False)
class Graph:
    """A machine."""

    #: Of the file, as MJCF.
    format: str
    #: What the file calls the machine.
    name: str
    #: By their names.
    bodies: Mapping[str, Body]
    #: In the order of the file.
    joints: tuple[Joint, ...]
    #: The body that does not move, if the file has one.
    world: str | None = None
    #: The unit of length.
    length: str = "m"
    #: Whether the file says which joints are driven.
    drives_known: bool = False
    #: Whether it states a pose of the platform.
    has_home: bool = True
    #: The acceleration of gravity, shape (3,), if the file states it.
    gravity: Array | None = None
    #: What was ignored or assumed.
    notes: tuple[str, ...] = ()
    #: By the names of joints: properties that an instance file cannot state.
    remarks: Mapping[str, str] = field(default_factory=dict)

    @property
    def loops(self) -> int:
        """The number of independent loops."""
        parts = components(self.bodies, ((joint.first, joint.second) for joint in self.joints))
        return len(self.joints) - len(self.bodies) + len(set(parts.values()))

    def mobility(self, *, held: bool = False) -> int:
        """Return the freedoms in the configuration of the file, also with its drives held."""
        names = list(self.bodies)
        column = {name: 6 * i for i, name in enumerate(names)}
        placed = [
            (joint, [part.moved(self.bodies[joint.first].pose) for part in joint.parts])
            for joint in self.joints
        ]
        size = extent([part.point for _, parts in placed for part in parts])
        rows = []
        for joint, parts in placed:
            free = [scaled(part, size).screws for part in parts if not (held and part.driven)]
            screws = np.concatenate((np.zeros((1, 6)), *free))
            _, values, V = np.linalg.svd(screws)
            for across in V[int((values > _NONE).sum()) :]:
                row = np.zeros(6 * len(names))
                row[column[joint.second] : column[joint.second] + 6] += across
                row[column[joint.first] : column[joint.first] + 6] -= across
                rows.append(row)
        count = 6 * (len(names) - 1)
        if not rows:
            return count
        return count - int((np.linalg.svd(np.array(rows), compute_uv=False) > _NONE).sum())

    def described(self) -> str:
        """Return its numbers of bodies, joints, loops and drives, in one line."""
        kinds = Counter(joint.letters for joint in self.joints)
        joints = ", ".join(f"{count} {letters}" for letters, count in sorted(kinds.items()))
        driven = sum(part.driven for joint in self.joints for part in joint.parts)
        drives = counted(driven, "drive") if self.drives_known else "no drives named"
        said = f"{len(self.bodies)} bodies, {counted(len(self.joints), 'joint')} ({joints}), "
        said += f"{counted(self.loops, 'loop')}, {drives}"
        if len(self.bodies) > _MOST_ANALYSED:
            return said
        said += f", mobility {self.mobility()}"
        return f"{said}, {self.mobility(held=True)} with the drives held" if driven else said


#: With more bodies the mobility is not computed.
_MOST_ANALYSED = 150


def components(nodes: Iterable[str], edges: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return the component of each node, named by one of its nodes."""
    parent = {node: node for node in nodes}

    def root(node: str) -> str:
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = parent[node]
        return node

    for first, second in edges:
        parent[root(second)] = root(first)
    return {node: root(node) for node in parent}


def split(joints: Iterable[Joint]) -> Iterator[Joint]:
    """Yield joints of at most one part each; the bodies between them have names with a ``#``."""
    for joint in joints:
        previous, last = joint.first, len(joint.parts) - 1
        for i, part in enumerate(joint.parts[:-1]):
            between = f"{joint.name}#{joint.second}#{i + 1}"
            yield replace(joint, first=previous, second=between, relative=np.eye(4), parts=(part,))
            previous = between
        yield replace(joint, first=previous, parts=joint.parts[max(last, 0) :])


def scaled(part: Part, size: float) -> Part:
    """Return a part with lengths in units of a size."""
    return replace(part, point=part.point / size)


def extent(points: Iterable[Array]) -> float:
    """Return the diagonal of the box around points; 1 if there is none."""
    found = np.array(list(points)).reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(found, axis=0))) if len(found) else 0.0
    return size if size > 0 else 1.0


def opposite(joint: Joint) -> Joint:
    """Return a joint of at most one part from its second body to its first."""
    X = inverse(joint.relative)
    parts = tuple(part.moved(X).backwards() for part in joint.parts)
    return replace(joint, first=joint.second, second=joint.first, relative=X, parts=parts)


#: The names of the entries of a matrix of inertia, and where they are.
ENTRIES = (("xx", 0, 0), ("xy", 0, 1), ("xz", 0, 2), ("yy", 1, 1), ("yz", 1, 2), ("zz", 2, 2))


def matrix(entry: Callable[[str], float], X: Array) -> Array:
    """Return a matrix of inertia in the axes of a body, shape (3, 3).

    From its entries by name, as ``ixx``, in the axes of X, the frame of the centre of mass, (4, 4).
    """
    own = np.zeros((3, 3))
    for axes, i, j in ENTRIES:
        own[i, j] = own[j, i] = entry(f"i{axes}")
    return np.asarray(X[:3, :3] @ own @ X[:3, :3].T)
