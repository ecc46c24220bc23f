"""Recognizes a graph as a platform with six constraints, or says what it is instead.

There is no table of chains. The drives are held, and bodies that then do not move against each
other are one body. Two bodies on which three or more chains end are the base and the platform.
`chain_constraints` finds what each chain holds; six constraints are a platform. If the file does
not name drives, the usual ones are tried, and the notes say which.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import MEETING_SHARE
from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE
from gspcli.machines.chain_constraints import (
    Held,
    Primitives,
    held_constraints,
    measured,
    pose_after,
)
from gspcli.machines.graph import Graph, Joint, NoPlatform, Part, extent, inverse, split
from gspcli.machines.source import LARGEST_NUMBER
from gspcli.machines.structure import (
    BodyChain,
    ChainPart,
    Clusters,
    JoinedBodies,
    structure,
)
from gspcli.records import dataclass
from gspcli.wording import counted, nearest, shown

#: A drive changes a value if it does by more than this, as a share of the size, or in radians.
_CHANGED = 1e-9
#: A value is the coordinate of its drive if the slope is 1 to this.
_SLOPE = 1e-6
#: The widest range of a crank, in degrees.
_TURN = 360.0
#: Points of a range at which a value is computed.
_SAMPLES = 17


@dataclass(frozen=True, eq=False)
class ArmOfCrank:
    """What turns the base's point of a constraint.

    Attributes
    ----------
    centre, axis
        A point of the axis and the unit axis in the frame of the base, shape (3,).
    radius
        The distance of the point from it.
    limits
        The least and the greatest angle from where the point is, in degrees; None if they are not
        known, or more than a turn apart.
    """

    centre: Array
    axis: Array
    radius: float
    limits: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class RailOfCarriage:
    """What moves the base's point of a constraint along a line.

    Attributes
    ----------
    axis
        The unit direction of the rail in the frame of the base, shape (3,).
    limits
        The least and the greatest way from where the point is, if they are known.
    """

    axis: Array
    limits: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class Found:
    """A constraint of a machine.

    Attributes
    ----------
    held
        The constraint.
    chain
        The name of the chain.
    letters
        The letters of its joints, such as RRP.
    limits
        The smallest and the largest value, if they are known; equal where nothing drives it.
    driven
        Whether a drive changes the value.
    negative
        Of a distance to a plane: whether the point lies where the normal does not point. The
        limits are then those of the modulus.
    crank, rail
        What moves the base's point of a distance of two points: a hinge or a slide.
    remarks
        What an instance file cannot state.
    """

    held: Held
    chain: str
    letters: str
    limits: tuple[float, float] | None
    driven: bool
    negative: bool
    crank: ArmOfCrank | None
    rail: RailOfCarriage | None
    remarks: tuple[str, ...]

    @property
    def kind(self) -> str:
        """Its kind."""
        return self.held.kind


def with_drives(held: Held, chain: BodyChain, length: str) -> Found:
    """Return a constraint with its drives, as far as they are known.

    Parameters
    ----------
    held
        The constraint while the drives are held in the configuration of the file.
    chain
        Its chain.
    length
        The name of the unit of length.
    """
    driven = [(k, p) for k, p in enumerate(chain.parts) if p.held]
    inside = [(k, p) for k, p in driven if p.where == "inside" and _changes(held, chain, k)]
    remarks: list[str] = []
    limits: tuple[float, float] | None = None
    if not driven:
        limits = held.value, held.value
    elif len(inside) == 1:
        place_, drive = inside[0]
        held = _at_the_coordinate(held, chain, place_)
        limits = _limits(held, chain, place_, remarks)
        if not _linear(held, chain, place_):
            remarks.append(f"the value is no coordinate of {_named(drive)}")
    elif inside:
        remarks.append(f"{len(inside)} drives change the value")
    elif all(p.where == "inside" for _, p in driven):
        limits = held.value, held.value
    negative = held.value < 0 or (held.value == 0 and limits is not None and limits[1] <= 0)
    if held.kind in ("DPH", "DHP") and limits is not None and negative:
        limits = -limits[1], -limits[0]
    moved = _moved(held, [p for _, p in driven if p.where == "base"], remarks, length)
    if above := [p for _, p in driven if p.where == "platform"]:
        names = ", ".join(map(_named, above))
        remarks.append(f"the platform's {_sort(held, 1)} is moved by {names}")
    if limits is not None and limits[0] < 0:
        low, high = limits
        remarks.append(f"range [{low:.6g}, {high:.6g}], which passes zero")
        limits = None
    crank = moved if isinstance(moved, ArmOfCrank) else None
    rail = moved if isinstance(moved, RailOfCarriage) else None
    said = tuple(remarks)
    return Found(held, chain.name, chain.letters, limits, bool(inside), negative, crank, rail, said)


def _named(drive: ChainPart) -> str:
    return drive.part.name or {"R": "a hinge", "P": "a slide"}.get(drive.part.letter, "a ball")


def _sort(held: Held, position: int) -> str:
    return {"P": "point", "L": "line", "H": "plane"}[held.kind[position]]


def _value(held: Held, chain: BodyChain, drive: int) -> Callable[[float], float]:
    """Return what the constraint measures after a change of a drive."""

    def value(change: float) -> float:
        X = pose_after(chain, drive, change)
        return float(measured(held.kind, held.platform, held.base, X)[0, 0])

    return value


def _unit(held: Held, chain: BodyChain, drive: int) -> tuple[float, float]:
    """Return the unit of the drive's coordinate and that of the value."""
    size = chain.size
    own = size if chain.parts[drive].part.letter == "P" else 1.0
    return own, 1.0 if held.kind[0] == "A" else size


def _changes(held: Held, chain: BodyChain, drive: int) -> bool:
    if chain.parts[drive].part.letter == "S":
        return True
    value, (step, unit) = _value(held, chain, drive), _unit(held, chain, drive)
    return any(abs(value(d * step) - held.value) > _CHANGED * unit for d in (0.05, -0.05, 0.1))


def _linear(held: Held, chain: BodyChain, drive: int) -> bool:
    """Return whether the value changes by as much as the coordinate, in the file."""
    if chain.parts[drive].part.letter == "S":
        return False
    value, (step, unit) = _value(held, chain, drive), _unit(held, chain, drive)
    slopes = [(value(d * step) - value(-d * step)) / (2 * d * unit) for d in (1e-4, 1e-2)]
    return step == unit and all(abs(abs(slope) - 1) < _SLOPE for slope in slopes)


def _at_the_coordinate(held: Held, chain: BodyChain, drive: int) -> Held:
    """Return a distance to a plane that is the coordinate of its drive, signed.

    The chain does not say where the plane is: only its normal. Other kinds are unchanged.
    """
    if held.kind not in ("DPH", "DHP") or not _linear(held, chain, drive):
        return held
    value, (step, _) = _value(held, chain, drive), _unit(held, chain, drive)
    sign = 1.0 if value(1e-3 * step) > value(-1e-3 * step) else -1.0
    shift = held.value - sign * chain.parts[drive].part.at
    own, base = held.platform, held.base
    if held.kind == "DPH":
        base = Primitives(base.points + shift * base.directions, sign * base.directions)
    else:
        own = Primitives(own.points + shift * own.directions, sign * own.directions)
    return replace(held, platform=own, base=base, value=sign * (held.value - shift))


def _limits(
    held: Held, chain: BodyChain, drive: int, remarks: list[str]
) -> tuple[float, float] | None:
    """Return the values in the range of a drive, if they are between those at its ends."""
    part = chain.parts[drive].part
    if part.letter == "S" or not (math.isfinite(part.low) and math.isfinite(part.high)):
        return None
    value = _value(held, chain, drive)
    values = [value(x - part.at) for x in np.linspace(part.low, part.high, _SAMPLES)]
    rises = np.diff(values)
    if (rises > 0).all() or (rises < 0).all():
        return min(values), max(values)
    remarks.append(f"{_named(chain.parts[drive])} in [{part.low:.6g}, {part.high:.6g}]")
    return None


def _moved(
    held: Held, outer: list[ChainPart], remarks: list[str], length: str
) -> ArmOfCrank | RailOfCarriage | None:
    """Return what turns or slides the base's point; refuse other drives with what they move."""
    if not outer:
        return None
    drive = outer[0]
    part = drive.part
    primitive = f"the base's {_sort(held, 2)}"
    if len(outer) > 1:
        names = ", ".join(map(_named, outer))
        remarks.append(f"{primitive} is moved by {len(outer)} drives: {names}")
        return None
    bounded = math.isfinite(part.low) and math.isfinite(part.high)
    low, high = part.low - part.at, part.high - part.at
    if part.letter == "R" and held.kind == "DPP":
        point = held.base.points[0]
        centre = part.point + part.axis * ((point - part.point) @ part.axis)
        limits = None
        if bounded:
            low, high = np.degrees([low, high]).tolist()
            if high - low <= _TURN:
                limits = low, high
            else:
                remarks.append(f"the crank {_named(drive)} turns from {low:.6g} to {high:.6g} deg")
        return ArmOfCrank(centre, part.axis, float(np.linalg.norm(point - centre)), limits)
    if part.letter == "P" and held.kind == "DPP":
        return RailOfCarriage(part.axis, (low, high) if bounded else None)
    moves = "slides" if part.letter == "P" else "turns"
    axis = ", ".join(f"{x:.12g}" for x in part.axis)
    said = f"{primitive} {moves} with {_named(drive)} along [{axis}]"
    if part.letter != "P":
        centre = ", ".join(f"{x:.12g}" for x in part.point)
        said = f"{primitive} {moves} with {_named(drive)} about [{axis}] through [{centre}]"
    if bounded and part.letter == "P":
        said += f" by {low:.6g} to {high:.6g} {length}"
    remarks.append(said)
    return None


Array = NDArray[np.float64]

#: What the configuration of a file misses by more than this share of the size is said.
_EXACT = 1e-9
#: Bodies of a machine, and joints at one of them, at most.
_MOST_BODIES = 1500


@dataclass(frozen=True, eq=False)
class Machine:
    """A platform that was recognized.

    Attributes
    ----------
    graph
        The graph in which it was recognized.
    structure
        Its base, its platform and its chains.
    constraints
        The six constraints.
    pose
        Of the platform in the base, as the file states it, shape (4, 4).
    size
        The diagonal of the box around all joints.
    gap
        How far the constraints are from their values at that pose: lengths, and angles times the
        size.
    notes
        What was assumed, and what the file leaves open.
    carried
        The bodies of the file that move with the platform, and their poses in it.
    """

    graph: Graph
    structure: JoinedBodies
    constraints: tuple[Found, ...]
    pose: Array
    size: float
    gap: float
    notes: tuple[str, ...]
    carried: tuple[tuple[str, Array], ...]


def recognized(
    graph: Graph,
    *,
    base: str | None = None,
    platform: str | None = None,
    meet: float = MEETING_SHARE,
) -> Machine:
    """Return the platform that a graph is.

    Parameters
    ----------
    graph
        The machine.
    base, platform
        The names of the bodies to take as base and platform; found if None.
    meet
        Axes that pass each other at up to this share of the size are taken to meet.

    Raises
    ------
    NoPlatform
        If it is no platform; the message says what it is, and what would make it one.
    """
    if len(graph.bodies) > _MOST_BODIES:
        message = f"found {len(graph.bodies)} bodies, expected at most {_MOST_BODIES}"
        raise NoPlatform(message)
    for body in (base, platform):
        if body is not None and body not in graph.bodies:
            near = nearest(body, graph.bodies)
            expected = f"did you mean {shown(near)}?" if near else _names(graph)
            raise NoPlatform(f"found no body {shown(body)}: {expected}")
    _check_numbers(graph)
    joints = tuple(split(graph.joints))
    reasons: list[str] = []
    for held, assumed in _drives(graph, joints, base):
        try:
            return _recognized(Clusters.made(graph, joints, held), assumed, base, platform, meet)
        except NoPlatform as error:
            reasons.append(f"{assumed}: {error}" if assumed else str(error))
    # What comes after the first are less likely drives.
    raise NoPlatform(f"{graph.described()}\n{reasons[0]}")


def _check_numbers(graph: Graph) -> None:
    """Refuse numbers that cannot be computed with.

    Raises
    ------
    NoPlatform
        Naming the joint or the body.
    """
    for joint in graph.joints:
        arrays = [joint.relative, *(x for part in joint.parts for x in (part.axis, part.point))]
        values = [part.at for part in joint.parts]
        if not all(_usable(x) for x in (*arrays, np.array(values))):
            message = f"found numbers of the joint {shown(joint.name)} that are not finite, or huge"
            raise NoPlatform(message)
    for body in graph.bodies.values():
        masses = (np.array(body.mass or 0.0), body.centre, body.inertia)
        if not all(_usable(x) for x in (body.pose, *masses)):
            message = f"found numbers of the body {shown(body.name)} that are not finite, or huge"
            raise NoPlatform(message)


def _usable(numbers: Array) -> bool:
    return bool((np.abs(numbers) < LARGEST_NUMBER).all())


def _names(graph: Graph) -> str:
    names = list(graph.bodies)
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return f"the bodies are {', '.join(map(shown, names[:8]))}{more}"


def _drives(
    graph: Graph, joints: tuple[Joint, ...], base: str | None
) -> Iterator[tuple[set[int], str]]:
    """Yield sets of joints that may be the drives, each with the assumption that it needs."""
    if graph.drives_known:
        yield {k for k, joint in enumerate(joints) if any(p.driven for p in joint.parts)}, ""
        return
    said = "the file names no drives; taken for drives:"
    slides = {k for k, joint in enumerate(joints) if joint.letters == "P"}
    if slides:
        # Hinges are not tried then: that read another machine than the one that was meant.
        yield slides, f"{said} all slides"
        yield set(), f"{said} none"
        return
    free = Clusters.made(graph, joints, set())
    try:
        bodies = [structure(free, base, None).base]
    except NoPlatform:
        # Arms that carry several rods are bodies on which chains end, too.
        degree = Counter(end for k in free.passive for end in free.ends(k))
        bodies = [body for body, count in degree.most_common(6) if count >= 3]
    for body in bodies:
        hinges = {
            k for k in free.passive if joints[k].letters == "R" and free.of[body] in free.ends(k)
        }
        if hinges:
            yield hinges, f"{said} the hinges at {shown(body)}"
    yield set(), f"{said} none"


def _recognized(
    clusters: Clusters, assumed: str, base: str | None, platform: str | None, meet: float
) -> Machine:
    graph = clusters.graph
    shape = structure(clusters, base, platform)
    points = [p.part.point for c in shape.chains for p in c.parts if p.part.letter != "P"]
    size = extent(points or [chain.pose[:3, 3] for chain in shape.chains])
    met = [_meeting(chain, size, meet) for chain in shape.chains]
    shape = replace(shape, chains=tuple(chain for chain, _, _ in met))
    found: list[Found] = []
    problems, count = [], 0
    for chain in shape.chains:
        held, number = held_constraints(chain, meet)
        count += number
        if len(held) < number:
            kinds = ", ".join(h.kind for h in held) or "none"
            problems.append(
                f"{chain.name} holds {number}, of which only {kinds} is of the ten kinds"
            )
        found += [with_drives(h, chain, graph.length) for h in held]
    if count != 6 or problems:
        missed = max((missed for _, _, missed in met), default=0.0)
        raise NoPlatform(_refusal(shape, count, problems, missed, size, graph.length))
    notes = [*graph.notes, *([assumed] if assumed else [])]
    moved = max(moved for _, moved, _ in met)
    if moved > _EXACT * size:
        notes.append(f"axes that pass each other at up to {moved:.2g} {graph.length} are taken "
                     "to meet")  # fmt: skip
    slack = max(f.held.change * (size if f.kind[0] == "A" else 1.0) for f in found)
    if slack > 1e-7 * size:
        notes.append(f"constraints hold within {slack:.2g} {graph.length}: the file has few digits")
    bodies = graph.bodies
    pose = inverse(bodies[shape.base].pose) @ bodies[shape.platform].pose
    if not graph.has_home:
        pose = shape.chains[0].pose
    gap = max(_missed(f, pose, size) for f in found)
    if graph.has_home and gap > _EXACT * size:
        loops = max((joint.gap for joint in graph.joints), default=0.0)
        said = f"the pose that the file states misses the values by {gap:.2g} {graph.length}"
        notes.append(said + (f"; its loops are open by up to {loops:.2g}" if loops > 0 else ""))
    return Machine(
        graph, shape, tuple(found), pose, size, gap, tuple(notes), _carried(clusters, shape)
    )


def _missed(found: Found, pose: Array, size: float) -> float:
    held = found.held
    off = abs(float(measured(held.kind, held.platform, held.base, pose)[0, 0]) - held.value)
    return off * (size if held.kind[0] == "A" else 1.0)


def _refusal(
    shape: JoinedBodies, count: int, problems: list[str], missed: float, size: float, length: str
) -> str:
    """Return why the chains are not six constraints, and what would change that."""
    kinds = Counter(chain.letters for chain in shape.chains)
    chains = ", ".join(f"{number} {letters}" for letters, number in kinds.items())
    said = f"found {len(shape.chains)} chains ({chains}) from the base {shown(shape.base)} to the "
    said += f"platform {shown(shape.platform)}, which hold {count} constraints, expected six"
    if count == 6:
        said += " distances and angles of points, lines and planes"
    if missed > 0:
        share = missed / size * 1.1
        return said + (
            f"; the axes at one end of a leg pass each other at {missed:.3g} {length}: "
            f"--meet {share:.2g} takes them to meet"
        )
    if count > 6 and all(p.part.letter != "S" for chain in shape.chains for p in chain.parts):
        said += "; with a ball joint at one end, or a hinge along each leg, it would hold fewer"
    elif count > 6:
        said += f": {counted(count - 6, 'constraint')} too many"
    elif count < 6:
        said += ": name the drives, or the platform is not held"
    return f"{said}; {problems[0]}" if problems else said


def _carried(clusters: Clusters, shape: JoinedBodies) -> tuple[tuple[str, Array], ...]:
    """Return the bodies that always move with the platform."""
    cluster = clusters.of[shape.platform]
    carried = []
    for body in clusters.members(cluster):
        steps = clusters.path(shape.platform, body)
        if not any(k in clusters.held for k, _ in steps):
            X = np.eye(4)
            for step in steps:
                X = X @ clusters.step(step).relative
            carried.append((body, X))
    return tuple(carried)


def _meeting(chain: BodyChain, size: float, meet: float) -> tuple[BodyChain, float, float]:
    """Return a chain in which neighbouring hinge axes that nearly meet are moved to meet.

    It is returned with how far axes were moved, and how far apart the others are.
    """
    moved = missed = 0.0
    parts: list[ChainPart] = []
    for run in _runs(chain.parts):
        axes = [p.part for p in run]
        if not 2 <= len(run) <= 3 or any(_parallel(a, b) for a, b in pairwise(axes)):
            parts += run
            continue
        across = [np.eye(3) - np.outer(a.axis, a.axis) for a in axes]
        rights = np.sum([A @ a.point for A, a in zip(across, axes, strict=True)], axis=0)
        centre = np.linalg.solve(np.sum(across, axis=0), rights)
        off = 2 * max(float(np.linalg.norm(np.cross(centre - a.point, a.axis))) for a in axes)
        if off <= meet * size:
            moved = max(moved, off)
            run = [replace(p, part=replace(p.part, point=centre)) for p in run]
        else:
            missed = max(missed, off)
        parts += run
    return replace(chain, parts=tuple(parts)), moved, missed


def _runs(parts: tuple[ChainPart, ...]) -> Iterator[list[ChainPart]]:
    """Yield passive hinges that follow each other as one group, and each other part alone."""
    run: list[ChainPart] = []
    for p in parts:
        if p.part.letter == "R" and not p.held:
            run.append(p)
            continue
        if run:
            yield run
        run = []
        yield [p]
    if run:
        yield run


def _parallel(first: Part, second: Part) -> bool:
    return float(np.linalg.norm(np.cross(first.axis, second.axis))) < MEASURED_PARALLEL_SINE
