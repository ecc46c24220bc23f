"""A platform as files for another program, as `gsp export` writes them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from gspcli.errors import ArgumentError
from gspcli.export.formats import FORMATS, ControllerFormat, ModeFormat, SystemFormat
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution

#: Names of the unknowns of systems of polynomials.
COORDINATES = ("study", "study-affine", "rt")
#: Digits of irrational numbers, and parts that a step of a controller tries.
DIGITS, TRIES = 40, 48
#: Models in which the frames of an instance are marked.
_MARKED = ("mjcf", "sdf")


@dataclass(frozen=True, eq=False)
class Export:
    """What is written for another program.

    Attributes
    ----------
    target
        The program, as `gsp export --to` names it.
    files
        The texts of the files by the ends of their names: one, whose end is empty, or two, as the
        header and the source of a controller.
    notes
        Notes: which mode it is, what is not exact.
    """

    target: str
    files: dict[str, str]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        size = sum(len(text.encode()) for text in self.files.values())
        return f"<Export to {self.target}: {counted(len(self.files), 'file')}, {size} bytes>"

    def __str__(self) -> str:
        return "".join(self.files.values())


def exported(
    instance: Instance,
    target: str,
    *,
    mode: int | None = None,
    coordinates: str = COORDINATES[0],
    digits: int = DIGITS,
    name: str = "platform",
    prefix: str | None = None,
    tries: int = TRIES,
    margin: float = 0.0,
) -> Export:
    """Write a platform for another program: its text is ``str`` of the result.

    Parameters
    ----------
    instance
        The platform.
    target
        The program: mjcf (MuJoCo), sdf, urdf, c (a controller), or a solver of polynomials, as
        `gsp export --help` lists them.
    mode
        The number of the real pose that is built; home if None.
    coordinates
        The unknowns of a system of polynomials: study, study-affine or rt.
    digits
        To how many digits irrational numbers are written in it.
    name
        Of the two files of a controller, without their ends.
    prefix
        What names in them begin with; the name if None.
    tries
        How many parts of a line of values a step of the controller tries.
    margin
        The part of its range by which a value may leave it in a step of the controller.

    Raises
    ------
    GspError
        If there is no such program, unknowns or mode.
    """
    if target not in FORMATS:
        message = f"found {shown(target)}, expected {listed(FORMATS)}"
        raise ArgumentError(message, "target")
    form = FORMATS[target]
    if isinstance(form, SystemFormat):
        return _system(instance, target, form, coordinates, digits)
    pose, notes = _pose(instance, mode, needed=isinstance(form, ModeFormat))
    if instance.frames is not None and target not in _MARKED:
        notes += ("poses are those of the platform itself: the frames of SPEC are left out",)
    if isinstance(form, ControllerFormat):
        prefix = re.sub(r"\W", "_", name, flags=re.ASCII) if prefix is None else prefix
        program = form.write(instance, prefix, tries, name, pose, margin)
        return Export(target, dict(zip(form.suffixes, program, strict=True)), notes)
    assert pose is not None
    texts = form.write(instance, pose)
    return Export(target, dict(zip(form.suffixes, texts, strict=True)), notes)


def _pose(
    instance: Instance, mode: int | None, *, needed: bool
) -> tuple[Solution | None, tuple[str, ...]]:
    """Return the real pose that is asked for, by default home, and a note about it."""
    from gspcli.motion.poses.mode_filters import chosen_mode
    from gspcli.solver import solve

    result = solve(instance).drawn
    home, count = result.home, result.counts.real
    if home is None and mode is None and not needed:
        return None, ()
    number = chosen_mode(mode, home, count)
    assert home is not None
    said = (home.text,) if mode is None and count > 1 else ()
    return result.real_solutions[number - 1], said


def _system(
    instance: Instance, target: str, form: SystemFormat, coordinates: str, digits: int
) -> Export:
    from gspcli.export.polynomial_systems import MOTIONS, system

    if coordinates not in MOTIONS:
        message = f"found {shown(coordinates)}, expected {listed(COORDINATES)}"
        raise ArgumentError(message, "coordinates")
    if digits < 1:
        message = f"found {digits}, expected at least 1"
        raise ArgumentError(message, "digits")
    found = system(instance, MOTIONS[coordinates]())
    notes: tuple[str, ...] = ()
    if found.constants and form.irrational != "exact":
        how = f"decimals of {digits} digits" if form.irrational == "decimals" else "doubles"
        notes = (f"{counted(len(found.constants), 'irrational number')} became {how}",)
    return Export(target, {"": form.write(found, digits)}, notes)
