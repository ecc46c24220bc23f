"""Options of the commands that take poses, and the text of files that are not instances."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gspcli.cli.streams import say
from gspcli.errors import ArgumentError, GspError
from gspcli.records import dataclass
from gspcli.wording import named

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat

    Array = NDArray[np.float64]

Function = TypeVar("Function", bound=Callable[..., Any])


#: What poses can be expressed relative to.
HOME = "home"


@dataclass(frozen=True)
class PoseConventions:
    """How poses are expressed, as the options say it.

    Attributes
    ----------
    euler
        The order of the axes of angles, or the name of a maker.
    pivot
        The point whose position is expressed, as text.
    relative_to
        ``home``, or None.
    """

    euler: str | None = None
    pivot: str | None = None
    relative_to: str | None = None

    @property
    def options(self) -> list[str]:
        """The options that are given."""
        given = (("--euler", self.euler), ("--pivot", self.pivot), (RELATIVE, self.relative_to))
        return [name for name, value in given if value]

    def form(self, instance: Instance | None, columns: ColumnOptions | None = None) -> PoseFormat:
        """Return the form of poses by the options and the instance.

        Parameters
        ----------
        instance
            The platform: its units, frames and home; None where there is none yet.
        columns
            The options about the columns of a file.

        Raises
        ------
        GspError
            If an option is wrong, or no home is stated and that is zero.
        """
        from gspcli.motion import PoseFormat
        from gspcli.motion.files.pose_files import pivot_from_text

        columns = columns or ColumnOptions()
        form = PoseFormat(
            None if self.euler is None else order_named("--euler", self.euler),
            (0.0, 0.0, 0.0) if self.pivot is None else pivot_from_text(self.pivot),
            ignore=columns.ignore,
            columns=columns.names,
            note=say,
        )
        if instance is None:
            if self.relative_to is not None:
                message = f"{RELATIVE} {HOME}: there is no platform that states a home"
                raise GspError(message)
            return form
        units = instance.units
        return replace(
            form,
            in_radians=units.angle.in_radians,
            length=units.length,
            frame=self.frame(instance),
        )

    def frame(self, instance: Instance) -> PoseFrame:
        """Return the frame in which poses are printed; quicker than `form`, which has it, too.

        Raises
        ------
        GspError
            If the instance states no home and that is zero.
        """
        from gspcli.geometry.frames import PoseFrame

        try:
            return PoseFrame.of(instance, relative=self.relative_to is not None)
        except ArgumentError as error:
            message = f"{RELATIVE} {HOME}: {error}"
            raise GspError(message) from None


RELATIVE = "--relative-to"


def order_named(option: str, text: str) -> str:
    """Return the order of axes that an option names; the order of a maker is printed on stderr."""
    from gspcli.geometry.euler import MAKERS, named_order

    order = named_order(text)
    if text.strip().lower() in MAKERS:
        say(f"{option} {text}: the order {order}, about the axes of the platform")
    return order


def frame_note(frame: PoseFrame) -> list[str]:
    """Return the note below a table with poses in a frame; none for the platform's own."""
    return [] if frame.is_identity else [f"x y z and the rotation: {frame.words}"]


def pose_options(function: Function) -> Function:
    """Add ``--euler``, ``--pivot``, ``--relative-to``; the command gets `PoseConventions`."""

    @click.option(
        "--euler",
        metavar="AXES",
        help="Order of the axes of rx, ry, rz: capitals turn with the platform (ZYX), small "
        "letters about the axes of the base (xyz); or PI, LinuxCNC, Symetrie.",
    )
    @click.option(
        "--pivot",
        metavar="X,Y,Z",
        help="The point of the platform whose position is x, y, z: its coordinates in the frame of "
        "the platform, or of the tool that SPEC states.",
    )
    @click.option(
        RELATIVE,
        "relative_to",
        type=click.Choice([HOME]),
        help="Poses are relative to the home of SPEC: zero is home.",
    )
    @functools.wraps(function)
    def command(
        *, euler: str | None, pivot: str | None, relative_to: str | None, **others: Any
    ) -> Any:
        return function(conventions=PoseConventions(euler, pivot, relative_to), **others)

    return command  # type: ignore[return-value]


@dataclass(frozen=True)
class ColumnOptions:
    """The options about the columns of a file.

    Attributes
    ----------
    ignore
        Those that are left out.
    names
        Their names where the file has no heading.
    """

    ignore: tuple[str, ...] = ()
    names: tuple[str, ...] = ()

    @property
    def options(self) -> list[str]:
        """The options that are given."""
        given = (("--ignore", self.ignore), ("--columns", self.names))
        return [name for name, value in given if value]


def column_options(function: Function) -> Function:
    """Add ``--ignore`` and ``--columns``; the command gets ``columns: ColumnOptions``."""

    def names(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name.strip() for text in texts for name in text.split(","))

    @click.option(
        "--ignore",
        metavar="COLUMN",
        multiple=True,
        callback=names,
        help="Leave out a column of the file, by its heading (* stands for any text); may be "
        "repeated, or several between commas.",
    )
    @click.option(
        "--columns",
        "text",
        metavar="NAMES",
        help="The names of the columns of a file without a heading, between commas; - leaves a "
        "column out.",
    )
    @functools.wraps(function)
    def command(*, ignore: tuple[str, ...], text: str | None, **others: Any) -> Any:
        listed = () if text is None else tuple(name.strip() for name in text.split(","))
        return function(columns=ColumnOptions(ignore, listed), **others)

    return command  # type: ignore[return-value]


def text_of(path: str) -> tuple[str, str]:
    """Return the content of a file or, for -, of standard input, and its name."""
    from gspcli.cli.names import refuse_to_replace
    from gspcli.spec.whole_files import LARGEST_TABLE, content_of

    refuse_to_replace(path)
    name = "standard input" if path == "-" else path
    try:
        return content_of(path, LARGEST_TABLE).decode("utf-8-sig"), name
    except UnicodeDecodeError as error:
        message = f"{name}: found {error.reason}, expected text in UTF-8"
        raise GspError(message) from error
    except (OSError, ValueError) as error:
        message = f"{named(name)}: cannot be read: {getattr(error, 'strerror', None) or error}"
        raise GspError(message) from error


def warn_of_range(instance: Instance, t: Sequence[float], values: Array) -> None:
    """Say on standard error which values are outside the ranges of the instance, if any.

    The rods of cranks and slides are left out: their lengths do not change.
    """
    from gspcli.geometry.drive_numbers import driven_points
    from gspcli.geometry.readings import values_of
    from gspcli.motion import out_of_range

    outside = out_of_range(instance, values_of(instance, values))
    for k, constraint in enumerate(instance.constraints):
        rows = outside[:, k].nonzero()[0].tolist()
        if rows and constraint.limits is not None and not driven_points(constraint):
            low, high = map(constraint.reading_of, constraint.limits)
            more = f" (and at {len(rows) - 1} more rows)" if len(rows) > 1 else ""
            say(
                f"t = {t[rows[0]]:g}: the value {values[rows[0], k]:.6g} of constraint {k + 1} is "
                f"outside its range from {low} to {high}{more}"
            )
