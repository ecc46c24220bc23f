"""Other values for the constraints of an instance."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from gspcli.errors import ArgumentError, Mistake, SpecError
from gspcli.geometry.checking import expected, wrong_value
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number, Real, parse_number
from gspcli.wording import shortened, shown


def set_values(
    instance: Instance, settings: Mapping[int, Real] | Iterable[Real], *, delta: bool = False
) -> Instance:
    """Return the instance with other values for some constraints.

    Parameters
    ----------
    instance
        The instance.
    settings
        Values by the numbers of the constraints, from 1, as ``{1: 5.2, 3: "sqrt(2)"}``; or such
        texts as ``["1=5.2", "3=sqrt(2)"]``; or the values of all six, shape (6,). They are numbers
        of any kind (`Number.of`), in the units of the instance; offsets are added to them.
    delta
        Whether the numbers are added to the values of the instance (or readings), exactly.

    Raises
    ------
    ArgumentError
        Names the mistake, such as ``settings[3]``.
    SpecError
        With all mistakes in texts.

    Examples
    --------
    >>> import gspcli
    >>> made = gspcli.hexapod(*[[[k, k * k, k**3] for k in range(6)]] * 2, range(1, 7))
    >>> [str(row.value) for row in set_values(made, {1: 5.2, 3: "sqrt(2)"}).constraints]
    ['5.2', '2', 'sqrt(2)', '4', '5', '6']
    >>> [str(row.value) for row in set_values(made, {1: "-0.1"}, delta=True).constraints]
    ['0.9', '2', '3', '4', '5', '6']
    """
    expected(instance)
    if isinstance(settings, Mapping):
        return instance.with_values(_of_mapping(instance, settings, delta))
    if not isinstance(settings, Iterable):
        message = f"found a {type(settings).__name__}, expected values by number, as {{1: 5.2}}"
        raise ArgumentError(message, "settings")
    items = [settings] if isinstance(settings, str) else list(settings)
    texts = [item for item in items if isinstance(item, str)]
    if len(texts) == len(items):
        return instance.with_values(_of_texts(instance, texts, delta))
    count = len(instance.constraints)
    if len(items) != count:
        message = f"found {len(items)} values, expected {count}, or {{1: 5.2}} for some"
        raise ArgumentError(message, "settings")
    values = {k: _value(instance, k, item, f"settings[{k}]", delta) for k, item in enumerate(items)}
    return instance.with_values(values)


def _of_mapping(instance: Instance, settings: Mapping[int, Real], delta: bool) -> dict[int, Number]:
    count = len(instance.constraints)
    values = {}
    for number, value in settings.items():
        found = shortened(repr(number))
        where = f"settings[{found}]"
        if isinstance(number, bool) or number not in range(1, count + 1):
            message = f"found constraint {found}, expected a number from 1 to {count}"
            raise ArgumentError(message, where)
        values[int(number) - 1] = _value(instance, int(number) - 1, value, where, delta)
    return values


def _value(instance: Instance, index: int, value: Real, where: str, delta: bool) -> Number:
    try:
        exact = Number.of(value)
    except ArgumentError as error:
        raise error.within(where) from None
    row = instance.constraints[index]
    value = row.raised_by(exact) if delta else row.value_of(exact)
    if wrong := wrong_value(row.kind, value, instance.units.angle):
        message = f"found {exact}, {wrong}"
        raise ArgumentError(message, where)
    return value


def _of_texts(instance: Instance, settings: Iterable[str], delta: bool) -> dict[int, Number]:
    option = "--delta" if delta else "--set"
    mistakes, values = [], {}
    count = len(instance.constraints)
    for setting in settings:
        key, equals, text = setting.partition("=")
        index = int(key) - 1 if key.strip().isdecimal() and len(key) < 5 else -1
        message = ""
        if not equals:
            message = "expected I=V, as 1=5.2"
        elif not 0 <= index < count:
            message = f"found constraint {shown(key)}, expected a number from 1 to {count}"
        elif index in values:
            message = f"found constraint {index + 1} twice"
        else:
            try:
                row = instance.constraints[index]
                number = parse_number(text)
                values[index] = row.raised_by(number) if delta else row.value_of(number)
            except ValueError as error:
                message = str(error)
            else:
                if wrong := wrong_value(row.kind, values[index], instance.units.angle):
                    message = f"found {shown(text)}, {wrong}"
        if message:
            mistakes.append(Mistake(None, f"{option} {shown(setting)}", message))
    if mistakes:
        raise SpecError(mistakes)
    return values
