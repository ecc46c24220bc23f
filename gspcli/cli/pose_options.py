"""Options of the commands that take poses, and the text of files that are not instances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gspcli.cli.streams import say
from gspcli.errors import GspError
from gspcli.wording import named

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat

    Array = NDArray[np.float64]

Function = TypeVar("Function", bound=Callable[..., Any])


def pose_options(function: Function) -> Function:
    """Add ``--euler`` and ``--pivot``."""
    function = click.option(
        "--pivot",
        metavar="X,Y,Z",
        help="The point of the platform, in its frame, that x, y, z are the position of.",
    )(function)
    return click.option(
        "--euler",
        metavar="AXES",
        help="Order of the axes of rx, ry, rz: capitals turn with the platform (ZYX), small "
        "letters about the axes of the base (xyz).",
    )(function)


def ignore_option(function: Function) -> Function:
    """Add ``--ignore``; the command gets ``ignore: tuple[str, ...]``."""

    def names(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name.strip() for text in texts for name in text.split(","))

    return click.option(
        "--ignore",
        metavar="COLUMN",
        multiple=True,
        callback=names,
        help="Leave out a column of the file, by its heading (* stands for any text); may be "
        "repeated, or several between commas.",
    )(function)


def pose_format(
    instance: Instance, euler: str | None, pivot: str | None, ignore: tuple[str, ...] = ()
) -> PoseFormat:
    """Return what the options and the instance say of a pose file."""
    units = instance.units
    return pose_form(euler, pivot, ignore, in_radians=units.angle.in_radians, length=units.length)


def pose_form(
    euler: str | None,
    pivot: str | None,
    ignore: tuple[str, ...] = (),
    *,
    in_radians: float = 1.0,
    length: str = "",
) -> PoseFormat:
    """Return what the options say of a pose file."""
    from gspcli.geometry.euler import check_sequence
    from gspcli.motion import PoseFormat
    from gspcli.motion.files.pose_files import pivot_from_text

    return PoseFormat(
        check_sequence(euler) if euler is not None else None,
        pivot_from_text(pivot) if pivot is not None else (0.0, 0.0, 0.0),
        in_radians,
        length,
        ignore,
    )


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
