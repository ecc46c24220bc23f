"""Options of the commands that take poses, and the text of files that are not instances."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import click

from gspcli.cli import options
from gspcli.cli.options import HOME, Function, Options
from gspcli.cli.specs import refuse_to_replace
from gspcli.cli.streams import say, working
from gspcli.errors import GspError, IncompleteError, NotFiniteError
from gspcli.records import dataclass
from gspcli.wording import listed, shortened, shown

if TYPE_CHECKING:
    from gspcli.dynamics.trajectories import PoseRates
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.home_mode import HomeMode
    from gspcli.geometry.instance import Array, Instance
    from gspcli.motion import PoseFormat
    from gspcli.motion.files.pose_files import PoseTable


def frame_note(frame: PoseFrame) -> list[str]:
    """Return the note below a table with poses in a frame; none for the platform's own."""
    return [] if frame.is_identity else [f"x y z and the rotation: {frame.words}"]


#: `--euler`, `--pivot` and `--relative-to`; the command gets them as `Options.form`.
pose_options = options.together(
    options.option(
        "--euler AXES",
        "Order of the axes of rx, ry, rz: capitals turn with the platform (ZYX), small letters "
        "about the axes of the base (xyz); or PI, LinuxCNC, Symetrie.",
    ),
    options.option(
        "--pivot X,Y,Z",
        "The point of the platform whose position is x, y, z: its coordinates in the frame of the "
        "platform, or of the tool that SPEC states.",
    ),
    options.option(
        options.RELATIVE,
        "Poses are relative to the home of SPEC: zero is home.",
        type=click.Choice([HOME]),
    ),
)


def _names(_: click.Context, __: click.Parameter, texts: Any) -> tuple[str, ...]:
    """Return names between commas, of an option that may be repeated, or not."""
    texts = [texts] if isinstance(texts, str) else texts or ()
    return tuple(name.strip() for text in texts for name in text.split(","))


#: `--ignore` and `--columns`; the command gets them as `Options.form`.
column_options = options.together(
    options.option(
        "--ignore COLUMN",
        "Leave out a column of the file, by its heading (* stands for any text); may be repeated, "
        "or several between commas.",
        multiple=True,
        callback=_names,
    ),
    options.option(
        "--columns NAMES",
        "The names of the columns of a file without a heading, between commas; - leaves a column "
        "out.",
        name="column_names",
        callback=_names,
    ),
)


def text_of(path: str) -> tuple[str, str]:
    """Return the content of a file or, for -, of standard input, and its name."""
    from gspcli.spec.document import text_of_table

    refuse_to_replace(path)
    name = "standard input" if path == "-" else path
    return text_of_table(path, name), name


def warn_of_range(instance: Instance, t: Sequence[float], values: Array) -> None:
    """Say on standard error which values are outside the ranges of the instance, if any.

    The rods of cranks and slides are left out: their lengths do not change.
    """
    import numpy as np

    from gspcli.geometry.machine import Machine

    machine = Machine.of(instance)
    outside = machine.outside(machine.read(values, {}))
    for drive in np.flatnonzero(~machine.moved & np.isfinite(machine.high)):
        k = machine.first[drive]
        constraint, rows = instance.constraints[k], np.flatnonzero(outside[:, drive])
        if len(rows) and constraint.limits is not None:
            low, high = map(constraint.reading_of, constraint.limits)
            more = f" (and at {len(rows) - 1} more rows)" if len(rows) > 1 else ""
            say(
                f"t = {t[rows[0]]:g}: the value {values[rows[0], k]:.6g} of constraint {k + 1} is "
                f"outside its range from {low} to {high}{more}"
            )


#: The first character of the name of a file where a POSE is expected.
_FILE = "@"
#: The ways to write a POSE, for help texts.
_POSE_HELP = "x,y,z,qw,qx,qy,qz, or x,y,z,rx,ry,rz with --euler, or @FILE"


@dataclass(frozen=True)
class GivenPose:
    """A POSE as written; its meaning depends on `--euler`, `--pivot` and the unit."""

    #: Numbers between commas, or ``@`` and the name of a file with one pose.
    text: str
    #: The option that it was given with.
    option: str

    @property
    def is_standard_input(self) -> bool:
        """Whether the pose is read from there."""
        return self.text == f"{_FILE}-"

    def read(self, form: PoseFormat) -> tuple[Array, Array]:
        """Return the pose, R (3, 3) and T (3,)."""
        from gspcli.motion import read_pose

        if self.text.startswith(_FILE):
            table = self._of_file(form)
        else:
            table = read_pose(self.text, replace(form, columns=()), self.option)
        if len(table.R) != 1:
            where = f"{self.option} {shortened(self.text)}"
            raise GspError(f"{where}: found {len(table.R)} poses, expected one")
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


def _pose_option(option: str, meaning: str) -> Callable[[Function], Function]:
    """Return an option that takes a POSE; the command gets a `GivenPose` or None."""
    return options.option(f"{option} POSE", f"{meaning} ({_POSE_HELP}).", type=PoseType())


def pose_value_option(more: str) -> Callable[[Function], Function]:
    """Return `--pose`."""
    return _pose_option("--pose", f"A pose of the platform: {more}")


def near_option(more: str) -> Callable[[Function], Function]:
    """Return `--near`."""
    return _pose_option("--near", f"A pose near the mode that is meant: {more}")


#: A number as `gsp solve` lists the real poses, from 1, or the home mode.
Mode: TypeAlias = "int | Literal['home']"


class ModeNumber(options.Whole):
    """A whole number of at least 1, or the word home."""

    name = "mode"

    def __init__(self) -> None:
        super().__init__(1)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number or the word, or fail."""
        if value == HOME:
            return HOME
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as error:
            message = f"{error.message.rstrip('.')}; expected a number of gsp solve, or {HOME}."
            self.fail(message, param, ctx)


def mode_option(what: str) -> Callable[[Function], Function]:
    """Add ``--mode K|home``; the help says what it is for."""
    meaning = f"A real pose by its number of `gsp solve`, or home: {what}"
    return options.option("--mode K|home", meaning, type=ModeNumber())


def chosen(mode: Mode | None, home: HomeMode | None, count: int) -> int:
    """Return the number of the mode asked for. If none is, it is home, and stderr says so."""
    from gspcli.motion.poses.mode_filters import chosen_mode

    number = mode if isinstance(mode, int) else None
    found = chosen_mode(number, home, count)
    if number is None and home is not None:
        if count > 1:
            say(home.text)
        if home.doubt:
            say(f"warning: {home.doubt}")
    return found


#: What poses vary by: position of the pivot, turns.
PARAMETERS = ("x", "y", "z", "rx", "ry", "rz")
_SPAN = re.compile(r"([^=]+)=([^:]+):([^:]+)(?::(\d{1,9}))?")


def span_of(
    option: str, text: str, names: Sequence[str], example: str, *, several: bool = True
) -> tuple[str, float, float, int]:
    """Return name, ends and number of values of NAME=LOW:HIGH:COUNT, or with 0 of NAME=LOW:HIGH."""
    from gspcli.motion.files.number_tables import wrong_number

    match = _SPAN.fullmatch(text.replace(" ", ""))
    if (
        match is None
        or match[1] not in names
        or any(map(wrong_number, match.group(2, 3)))
        or (not int(match[4] or 0) if several else match[4])
    ):
        form = f"NAME=LOW:HIGH{':COUNT' * several} with {listed(names)}"
        found = f"--{option}: found {shown(text)}"
        raise GspError(f"{found}, expected {form}, such as {names[0]}={example}")
    return match[1], float(match[2]), float(match[3]), int(match[4] or 0)


def one_mode(instance: Instance, mode: Mode | None) -> tuple[int, Array, Array]:
    """Return the number of a mode and its pose, shapes (1, 3, 3) and (1, 3); by default home."""
    from gspcli.geometry.home_mode import home_mode

    R, T = real_poses(instance)
    number = chosen(mode, home_mode(instance, R, T), len(R))
    return number, R[number - 1 : number], T[number - 1 : number]


def mode_number(instance: Instance, mode: Mode | None) -> int:
    """Return the number of a mode. For home it is found, and printed on stderr."""
    return mode if isinstance(mode, int) else one_mode(instance, mode)[0]


def real_poses(instance: Instance) -> tuple[Array, Array]:
    """Return the real poses, at least one, as `gsp solve`: shapes (n, 3, 3) and (n, 3)."""
    from gspcli.solver import solve

    with working("solving"):
        result = solve(instance)
    if result.verdict == "infinite":
        raise NotFiniteError("the poses of the platform are infinitely many\ngive one with --pose")
    if result.verdict != "complete":
        what = "the poses of the platform could not all be found"
        raise IncompleteError(f"{what}\ngive one with --pose")
    R, T = result.R[result.real].real, result.T[result.real].real
    if not len(R):
        raise GspError(
            "the platform has no real pose for its values\n"
            "give a pose with --pose, or other values (gsp solve says which contradict each other)"
        )
    return R, T


@dataclass(frozen=True, eq=False)
class AskedPoses:
    """Poses, and what to call them."""

    #: The poses, shapes (n, 3, 3) and (n, 3).
    R: Array
    T: Array
    #: What each is called, as data: its ``row`` in a file, from 1, and ``t`` there; its ``mode``.
    places: Sequence[Mapping[str, Any]]
    #: Readings of the drives, shape (n, m), where SPEC or a file says them; else None.
    drives: Array | None = None
    #: Modes that end before the last row of a file of values, in words.
    lost: tuple[str, ...] = ()
    #: Times, shape (n,), and how the platform moves there, if a file says it.
    t: Array | None = None
    motion: PoseRates | None = None

    @property
    def columns(self) -> str:
        """The columns that say what the poses are called."""
        named = {key for place in self.places for key, value in place.items() if value is not None}
        return " ".join(key for key in ("row", "t", "mode") if key in named) or "mode"

    def check(self) -> None:
        """Raise `IncompleteError` if a mode was lost on the way."""
        if self.lost:
            raise IncompleteError("\n".join(self.lost))


def rows_options(mode: str) -> Callable[[Function], Function]:
    """Return SPEC, ROWS and the options of commands that take both; what ``--mode`` is for."""
    return options.together(
        options.exclusive("--mode", "--pose", "--near"),
        options.exclusive("ROWS", "--pose"),
        options.needs("--near", "ROWS"),
        click.argument("spec", metavar="SPEC"),
        click.argument("rows", metavar="[ROWS]", required=False),
        mode_option(mode),
        pose_value_option("instead of the modes of SPEC"),
        near_option("of a file of values only this one is followed"),
        options.value_options,
        pose_options,
        column_options,
    )


def asked_poses(o: Options) -> AskedPoses:
    """Return the poses of `rows_options`: of a file, the one given, or the real ones of SPEC."""
    instance, form = o.instance, o.form
    if o.rows is not None:
        return _of_file(o)
    if o.pose is not None:
        R, T = o.pose.read(form)
        return AskedPoses(R[None], T[None], [{"mode": None}])
    if o.mode is not None:
        number, R, T = one_mode(instance, o.mode)
        places = [{"mode": number}]
    else:
        R, T = real_poses(instance)
        places = [{"mode": k} for k in range(1, len(R) + 1)]
    return AskedPoses(R, T, places, _stated_drives(instance, len(R)))


def _stated_drives(instance: Instance, count: int) -> Array | None:
    """Return readings of drives as stated, shape (count, m); None without cranks and slides."""
    import numpy as np

    from gspcli.geometry.machine import Machine

    drives = Machine.of(instance)
    if not drives.moves:
        return None
    # A drive without a crank or slide is the value itself; it is not asked for here.
    return drives.readings(np.zeros((count, drives.count)))


def _of_file(o: Options) -> AskedPoses:
    import numpy as np

    from gspcli.motion import read_poses, read_values, track
    from gspcli.motion.files.pose_files import has_poses

    instance, form = o.instance, o.form
    text, name = text_of(o.rows)
    if has_poses(text, name, form):
        refuse_modes(o, name)
        table = read_poses(text, name, form)
        check_poses(o, text, name, table.R, table.T)
        t = range(1, len(table.R) + 1) if table.t is None else table.t.tolist()
        places = [{"row": k, "t": float(at), "mode": None} for k, at in enumerate(t, 1)]
        return AskedPoses(table.R, table.T, places)
    values = read_values(text, name, instance, form)
    modes = None if o.mode is None else [mode_number(instance, o.mode)]
    with working("following"):
        start = None if o.near is None else o.near.read(form)
        found = track(
            instance, values.values, coordinates=values.coordinates, t=values.t, modes=modes,
            near=start,
        )  # fmt: skip
    if not len(found.modes):
        raise GspError("there is no real pose at the first row")
    rows, which = np.nonzero(~np.isnan(found.T[..., 0].T))
    numbers = ((rows + 1).tolist(), found.t[rows].tolist(), found.modes[which].tolist())
    return AskedPoses(
        found.R[which, rows],
        found.T[which, rows],
        [{"row": row, "t": t, "mode": mode} for row, t, mode in zip(*numbers, strict=True)],
        values.drives(instance)[rows],
        tuple(f"mode {one.mode} ends at t = {one.low:.10g} ({one.kind})" for one in found.ends),
    )


def refuse_modes(o: Options, name: str) -> None:
    """Raise for options that choose a mode where a file says the poses."""
    if o.mode is not None or o.near is not None:
        option = "--near" if o.mode is None else "--mode"
        raise GspError(f"{option}: found the poses of {name}, expected a file of values to follow")


def check_poses(o: Options, text: str, name: str, R: Array, T: Array) -> None:
    """Refuse a file without poses, and compare what it says of values with them.

    The rods of cranks and slides have the values of SPEC.
    """
    if not len(R):
        raise GspError(f"{name}: found no poses, expected at least one")
    import numpy as np

    from gspcli.geometry.machine import driven_points
    from gspcli.motion.files.value_files import nominal_values
    from gspcli.motion.poses.inverse_kinematics import measure

    rods = [bool(driven_points(one)) for one in o.instance.constraints]
    values = np.where(rods, nominal_values(o.instance), measure(o.instance, R, T))
    warn_of_values(text, name, o.form, o.instance, values)


def warn_of_values(
    text: str, name: str, form: PoseFormat, instance: Instance, values: Array
) -> None:
    """Say on standard error that values beside poses, which are not used, contradict them.

    The file is one of n poses, at which the constraints measure the values, shape (n, 6).
    """
    if not text or text.lstrip()[:1] in "{[":
        return
    from gspcli.motion.files.number_tables import NumberTable
    from gspcli.motion.files.value_files import compare_values

    table = NumberTable(text, name, form.units.of(instance), form.ignore, form.columns)
    compare_values(table, instance, values)
    if table.mistakes:
        more = f" (and {len(table.mistakes) - 1} more)" if len(table.mistakes) > 1 else ""
        say(f"warning: {table.mistakes[0]}{more}: not used, the values are measured")
