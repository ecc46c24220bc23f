"""The table of `gsp sensors`: which sensor suffices, which never can, and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.output import Column, Table
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.sensing import SensorResult

#: The origin of the sets of values, in words.
_DRAWN = {
    "rows": "of the file",
    "within": "drawn within the intervals given",
    "ranges": "drawn in the ranges of SPEC",
    "poses": "measured at random poses about home (10 % of the size, 15 degrees)",
    "cranks": "with the cranks turned to random poses about home (10 % of the size, 15 degrees)",
    "drives": "with the drives moved to random poses about home (10 % of the size, 15 degrees)",
    "motors": "with each drive moved at random about home (slides 10 % of the size, cranks 15 "
    "degrees)",
}
_NOUNS = {"leg": "leg", "coordinate": "coordinate", "joint": "angle of a joint"}
#: Differences below this many standard deviations are rounding.
_ZERO = 1e-6


def sensor_table(result: SensorResult, form: str, *, everything: bool) -> Table:
    """Return the table of the sensors.

    Parameters
    ----------
    result
        Of `gspcli.sensors`.
    form
        The format; CSV has the numbers in full.
    everything
        Whether each sensor is shown, not only the best of each sort.
    """
    units = {"length": result.instance.units.length, "angle": result.instance.units.angle.value}
    unit_of = {str(sensor): units[sensor.unit] for sensor in result.sensors}
    rows = result.rows()
    if form == "csv":
        return Table([Column(key) for key in rows[0]], rows, summary=_summary(result))
    if not everything:
        best = {result.in_group(group)[0]: group for group in result.groups}
        kept = {str(result.sensors[k]) for k in best}
        rows = [row for row in rows if row["sensor"] in kept]
    several = len(result.values) > 1
    shown = [
        {
            **row,
            "sigma": f"{row['sigma']:.3g} {unit_of[row['sensor']]}",
            "least": _difference(row["low"] if several else row["least"]),
            "median": _difference(row["median"]),
            "pair": None if not row["first"] else f"{row['first']}, {row['second']}",
            "suffices": _suffices(row, several),
        }
        for row in rows
    ]
    columns = [
        Column("sensor", essential=True, fold=" "),
        Column("sigma", align="right", minor=2),
        Column("least", "5 % below" if several else "apart by", "right", essential=True),
        *([Column("median", align="right", minor=1)] if several else []),
        *([] if several else [Column("pair", "worst pair", minor=1)]),
        Column("suffices", align="right", essential=True, fold=" "),
    ]
    notes = [
        "in standard deviations of the sensor"
        + (", of the pair of modes that it tells apart worst" if several else ""),
        *_notes(result, everything),
    ]
    return Table(columns, shown, result.instance.title, notes=notes, summary=_summary(result))


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _difference(value: float | None) -> float | None:
    """Return a difference for people; what is only rounding is zero."""
    if value is None:
        return None
    return 0.0 if value < _ZERO else float(f"{value:.3g}")


def _suffices(row: dict[str, Any], several: bool) -> str | None:
    if row["share"] is None:
        return None
    if row["blind"]:
        return "never"
    if several:
        return _percent(row["share"])
    return "yes" if row["share"] == 1 else "no"


def _summary(result: SensorResult) -> list[str]:
    found, told = result.separations, int(result.told.sum())
    known = found.modes[found.complete]
    side = " on the known side" if result.known_side else ""
    if result.drawn == "given":
        modes = int(known.sum())
        lines = [f"{counted(modes, 'real mode')}{side}"]
        if modes < 2:
            return [f"{lines[0]}: there is nothing to tell apart"]
    else:
        ends = (
            sorted({int(known.min()), int(known.max())}) if len(known) else ["unknown numbers of"]
        )
        number = " to ".join(map(str, ends))
        lines = [
            f"{counted(len(result.values), 'set')} of values {_DRAWN[result.drawn]}, with {number} "
            f"real modes{side}; {told} with more than one"
        ]
        if not told:
            return lines
    lines.append(_answer(result))
    if result.hopeless.any():
        lines.append(_fold(result))
    return lines


def _answer(result: SensorResult) -> str:
    """Say which sensor suffices, or which two."""
    best = result.best
    assert best is not None
    name, share = result.sensors[best], result.shares[best]
    least = result.separations.least[best, result.told].min()
    several = result.drawn != "given"
    if share == 1:
        return f"one more sensor suffices: {name}, {_apart(least)} at least"
    where = f"in {_percent(share)} of these sets" if several else f"only {_apart(least)}"
    text = f"no single sensor suffices; best is {name}, {where}"
    pair = result.to_json()["pair"]
    if pair is None:
        return text
    both = " and ".join(pair["sensors"])
    if pair["share"] == 1:
        return f"{text}; two do: {both}, {_apart(pair['least'])} at least"
    where = f"in {_percent(pair['share'])}" if several else f"only {_apart(pair['least'])}"
    return f"{text}; of two {both}, {where}"


def _apart(least: float) -> str:
    return f"{_difference(least):.3g} standard deviations"


def _fold(result: SensorResult) -> str:
    """Say that modes are too close for any sensor."""
    near = result.closest_json()
    assert near is not None
    units = result.instance.units
    first, second = near["modes"]
    which = f"modes {first} and {second} are"
    if result.drawn != "given":
        sets = counted(near["hopeless"], "set")
        which = (
            f"in {sets} two modes are too close; modes {first} and {second} of set {near['set']}"
        )
    length, turn = f"{near['translation']:.2g} {units.length}", f"{near['turn']:.2g}"
    return (
        f"{which} only {length} and {turn} {units.angle.value} apart: near a fold, where modes "
        "meet, no sensor suffices"
    )


def _notes(result: SensorResult, everything: bool) -> list[str]:
    notes = []
    if blind := int(result.blind.sum()):
        legs = [s for s, b in zip(result.sensors, result.blind, strict=True) if b]
        kinds = {"leg": 0, "coordinate": 0, "joint": 0}
        for sensor in legs:
            kinds[sensor.kind] += 1
        parts = [counted(number, _NOUNS[kind]) for kind, number in kinds.items() if number]
        drives = [getattr(g, "drive", None) for g in result.instance.primitives]
        sorts = {f"{drive.sort}s" for drive in drives if drive is not None}
        what = " and ".join(sorted(sorts))
        planar = "planar" + (f" with the {what} as stated" if sorts else "")
        notes.append(
            f"{' and '.join(parts)} never {'suffices' if blind == 1 else 'suffice'}, proved: base "
            f"and platform are {planar}, and each mode has a mirror image at which they read the "
            "same"
        )
    if not everything:
        notes += [_group_note(result)]
    return notes


def _group_note(result: SensorResult) -> str:
    counts = [f"{len(result.in_group(group))} {group}" for group in result.groups]
    return f"the best of each sort ({', '.join(counts)}): --all-sensors shows each"
