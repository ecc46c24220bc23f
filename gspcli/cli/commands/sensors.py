"""`gsp sensors`: which one more sensor tells the assembly modes of a platform apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from gspcli.cli import options
from gspcli.cli.pose_options import column_options, pose_options, text_of
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.specs import standard_deviations
from gspcli.cli.streams import working
from gspcli.errors import GspError, IncompleteError
from gspcli.wording import counted, shown

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.sensing import Sensor, SensorResult

FIELDS = Fields("sensors")

_KINDS = ("leg", "joint", "inclinometer", "distance", "angle")
#: The options that say how ROWS are read.
_ABOUT_ROWS = ("--relative", "--euler", "--pivot", "--relative-to", "--ignore", "--columns")


@click.command(cls=options.Command)
@options.together(*(options.needs(name, "ROWS") for name in _ABOUT_ROWS))
@click.argument("spec", metavar="SPEC")
@click.argument("rows", metavar="[ROWS]", required=False)
@options.value_options
@options.option("--relative", "The values in the file are added to those of SPEC.")
@pose_options
@column_options
@options.option(
    "--sensor SENSOR",
    "Only this sensor, such as 'leg P1 (0, 0, 50)' or 'joint 1 base about x'; may be repeated.",
    name="names",
    multiple=True,
)
@options.option(
    "--sigma WHAT=NUMBER",
    f"Standard deviation of what is measured: {', '.join(_KINDS)}, in the unit of SPEC; "
    "may be repeated.  [default: lengths a thousandth of the size, angles 0.1 degrees]",
    name="deviations",
    multiple=True,
)
@options.option(
    "--need N",
    "Modes count as distinguished if their readings differ by at least N standard deviations.",
    type=options.Positive(),
    default=6.0,
)
@options.option(
    "--known-side", "Assume that the platform is on the same side of the base as at home."
)
@options.option("--all-sensors", "Show each sensor, not the best ones only.", name="everything")
@options.seed_option(": of --random")
@options.jobs_option
@options.output_options()
def command(o: options.Options) -> None:
    """Say which one more sensor tells the assembly modes of a platform apart.

    All real modes are found, and the reading of each sensor at each of them. Sensors are one more
    leg between joints, an angle of a joint, and an inclinometer. A sensor is judged by the two
    modes whose readings are nearest, in standard deviations of the sensor.

    If the joints of either body lie in a plane, modes come in mirror images, and no leg between
    the planes tells them apart: --known-side leaves out those on the other side of the base. Near
    a fold, where two modes meet, their readings are nearly equal: no sensor suffices there, and the
    output says so.

    With the sensor, gsp solve SPEC --reading finds the mode that a reading belongs to.

    Exit codes: 0 done (that nothing suffices is an answer, too); 2 bad input; 3 the poses are
    infinitely many; 4 some poses could not be found.

    \b
    Examples:
      gsp sensors @rubin-m2
      gsp sensors @simscape-hexapod --known-side
      gsp sensors platform.yaml path.csv --euler ZYX
      gsp sensors platform.yaml --sigma inclinometer=0.02
      gsp sensors platform.yaml --sensor "leg P1 B3" --sensor inclinometer
    """
    instance, table = o.instance, None
    chosen = _chosen(o.names, instance)
    if o.rows is not None:
        from gspcli.motion import read_values

        table = read_values(*text_of(o.rows), instance, o.form, delta=o.relative)
    from gspcli.sensing import sensors

    with working("solving"):
        result = sensors(
            instance,
            None if table is None else table.values,
            coordinates=None if table is None else table.coordinates,
            seed=o.seed,
            sensors=chosen,
            sigma=_deviations(o.deviations),
            need=o.need,
            known_side=o.known_side,
            jobs=o.jobs,
        )
    shown = sensor_table(result, o.output.format, everything=o.everything or bool(o.names))
    emit(o.output, shown, document=result.to_json())
    if missing := int((~result.separations.complete).sum()):
        sets = len(result.separations.modes)
        raise IncompleteError(f"at {counted(missing, 'set')} of {sets} not all poses are known")


def _chosen(names: tuple[str, ...], instance: Instance) -> list[Sensor] | None:
    """Return the sensors that are named; None for all."""
    from gspcli.errors import ArgumentError
    from gspcli.sensing.sensor_kinds import parse_sensor

    found = []
    for name in names:
        try:
            found.append(parse_sensor(name, instance))
        except ArgumentError as error:
            raise GspError(f"--sensor {name!r}, {error}") from None
    return found or None


def _deviations(texts: Sequence[str]) -> dict[str, float]:
    found = standard_deviations(texts)
    for kind in found.keys() - {*_KINDS}:
        raise GspError(f"--sigma: found {shown(kind)}, expected one of {', '.join(_KINDS)}")
    return found


#: Differences below this many standard deviations are rounding.
_ZERO = 1e-6


def sensor_table(result: SensorResult, form: str, *, everything: bool) -> Result:
    """Return the table of the sensors."""
    units = {"length": result.instance.units.length, "angle": result.instance.units.angle.value}
    unit_of = {str(sensor): units[sensor.unit] for sensor in result.sensors}
    rows = result.rows()
    if form == "csv":
        return Result([Field(key) for key in rows[0]], rows, summary=_summary(result))
    if not everything:
        kept = {str(result.sensors[result.of_kind(kind)[0]]) for kind in result.kinds}
        rows = [row for row in rows if row["sensor"] in kept]
    several = result.values is not None
    for row in rows:
        row["sigma"] = f"{row['sigma']:.3g} {unit_of[row['sensor']]}"
        row["pair"] = f"{row['first']}, {row['second']}" if row["first"] else None
        row["least"] = _difference(row["low"] if several else row["least"])
        row["median"] = _difference(row["median"])
        share = row["share"]
        row["suffices"] = None
        if share is not None:
            row["suffices"] = _percent(share) if several else "yes" if share == 1 else "no"
    least = FIELDS["least"].but(title="5 % below" if several else "apart by")
    middle = "median" if several else "pair"
    columns = [*FIELDS.of("sensor sigma"), least, *FIELDS.of(f"{middle} suffices")]
    worst = ", of the pair of modes that it tells apart worst" if several else ""
    notes = [f"in standard deviations of the sensor{worst}"]
    if not everything:
        counts = ", ".join(f"{len(result.of_kind(kind))} {kind}" for kind in result.kinds)
        notes.append(f"the best of each sort ({counts}): --all-sensors shows each")
    return Result(columns, rows, result.instance.title, notes, _summary(result))


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _difference(value: float | None) -> float | None:
    """Return a difference for people; what is only rounding is zero."""
    if value is None:
        return None
    return 0.0 if value < _ZERO else float(f"{value:.3g}")


def _summary(result: SensorResult) -> list[str]:
    found, told = result.separations, int(result.told.sum())
    known = found.modes[found.complete]
    side = " on the known side" if result.known_side else ""
    if result.values is None:
        modes = int(known.sum())
        lines = [f"{counted(modes, 'real mode')}{side}"]
        if modes < 2:
            return [f"{lines[0]}: there is nothing to tell apart"]
    else:
        ends = sorted({int(known.min()), int(known.max())}) if len(known) else []
        number = " to ".join(map(str, ends)) or "unknown numbers of"
        lines = [
            f"{counted(len(result.values), 'set')} of values of the file, with {number} real "
            f"modes{side}; {told} with more than one"
        ]
        if not told:
            return lines
    lines.append(_answer(result))
    if result.hopeless.any():
        lines.append(_fold(result))
    return lines


def _answer(result: SensorResult) -> str:
    """Say which sensor suffices, or how far the best goes."""
    best = result.best
    assert best is not None
    name, share = result.sensors[best], result.shares[best]
    least = result.separations.least[best, result.told].min()
    if share == 1:
        return f"one more sensor suffices: {name}, {_apart(least)} at least"
    several = result.values is not None
    where = f"in {_percent(share)} of these sets" if several else f"only {_apart(least)}"
    return f"no single sensor suffices; best is {name}, {where}"


def _apart(least: float) -> str:
    return f"{_difference(least):.3g} standard deviations"


def _fold(result: SensorResult) -> str:
    """Say that modes are too close for any sensor."""
    near = result.closest_json()
    assert near is not None
    units = result.instance.units
    first, second = near["modes"]
    which = f"modes {first} and {second}"
    if result.values is None:
        which += " are"
    else:
        sets = counted(near["hopeless"], "set")
        which = f"in {sets} two modes are too close; {which} of set {near['set']}"
    length, turn = f"{near['translation']:.2g} {units.length}", f"{near['turn']:.2g}"
    return (
        f"{which} only {length} and {turn} {units.angle.value} apart: near a fold, where modes "
        "meet, no sensor suffices"
    )
