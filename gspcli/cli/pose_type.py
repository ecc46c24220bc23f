"""POSE on the command line: numbers between commas, or `@FILE` with one pose."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gspcli.cli.pose_options import text_of
from gspcli.errors import GspError
from gspcli.records import dataclass
from gspcli.wording import shortened

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.motion import PoseFormat
    from gspcli.motion.files.pose_files import PoseTable

    Array = NDArray[np.float64]

Function = TypeVar("Function", bound=Callable[..., Any])

#: The first character of the name of a file where a POSE is expected.
_FILE = "@"
#: The ways to write a POSE, for help texts.
POSE_HELP = "x,y,z,qw,qx,qy,qz, or x,y,z,rx,ry,rz with --euler, or @FILE"


@dataclass(frozen=True)
class GivenPose:
    """A POSE as written; its meaning depends on `--euler`, `--pivot` and the unit.

    Attributes
    ----------
    text
        Numbers between commas, or ``@`` and the name of a file with one pose.
    option
        The option that it was given with.
    """

    text: str
    option: str

    @property
    def is_standard_input(self) -> bool:
        """Whether the pose is read from there."""
        return self.text == f"{_FILE}-"

    def read(self, form: PoseFormat) -> tuple[Array, Array]:
        """Return the pose, R (3, 3) and T (3,).

        Parameters
        ----------
        form
            How the numbers of a pose are meant: order of axes, pivot, units.

        Raises
        ------
        GspError
            If it is not one pose.
        """
        from gspcli.motion import read_pose

        if self.text.startswith(_FILE):
            table = self._of_file(form)
        else:
            table = read_pose(self.text, replace(form, columns=()), self.option)
        if len(table.R) != 1:
            where = f"{self.option} {shortened(self.text)}"
            message = f"{where}: found {len(table.R)} poses, expected one"
            raise GspError(message)
        return table.R[0], table.T[0]

    def _of_file(self, form: PoseFormat) -> PoseTable:
        """Return the poses of the file; one line of numbers is a POSE unless `form` has names."""
        from gspcli.motion import read_pose, read_poses
        from gspcli.motion.files.number_tables import rows_without_heading

        text, name = text_of(self.text[1:])
        rows = rows_without_heading(text)
        # No column of a single pose is ignored, since all its numbers are needed.
        names = form.columns if rows else ()
        if len(rows) == 1 and not names:
            numbers = ",".join(re.split(r"[,;\s]+", rows[0].strip()))
            return read_pose(numbers, form, f"{self.option} {shortened(self.text)}")
        return read_poses(text, name, replace(form, ignore=("*",), columns=names))

    def numbers(self, form: PoseFormat) -> list[float]:
        """Return the pose as numbers: the position of the pivot, then the rotation.

        These are the numbers as written. Of a file the rotation is a quaternion, or angles if
        `form` has their order.
        """
        from gspcli.motion.files.pose_files import numbers_of_pose, pose_numbers

        if self.text.startswith(_FILE):
            return numbers_of_pose(*self.read(form), form)
        return pose_numbers(self.text, self.option)[1]


class PoseType(click.ParamType):  # type: ignore[type-arg]
    """The type of options that take a POSE; commands get `GivenPose`."""

    name = "pose"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the pose as it was given."""
        del ctx
        if isinstance(value, GivenPose) or param is None:
            return value
        return GivenPose(value, max(param.opts, key=len))


def pose_option(option: str, sentence: str, more: str) -> Callable[[Function], Function]:
    """Return an option that takes a POSE.

    Parameters
    ----------
    option
        ``--pose`` or ``--near``.
    sentence
        The meaning of the option, the same in all commands.
    more
        What this command uses it for.
    """
    return click.option(
        option, type=PoseType(), metavar="POSE", help=f"{sentence}: {more} ({POSE_HELP})."
    )


def pose_value_option(more: str) -> Callable[[Function], Function]:
    """Return `--pose`; the command gets ``pose: GivenPose | None``."""
    return pose_option("--pose", "A pose of the platform", more)


def near_option(more: str) -> Callable[[Function], Function]:
    """Return `--near`; the command gets ``near: GivenPose | None``."""
    return pose_option("--near", "A pose near the mode that is meant", more)
