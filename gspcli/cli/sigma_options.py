"""The numbers of ``--sigma WHAT=NUMBER``: standard deviations of what is measured."""

from __future__ import annotations

from collections.abc import Sequence

from gspcli.errors import Mistake, SpecError
from gspcli.wording import shown


def standard_deviations(texts: Sequence[str]) -> dict[str, float]:
    """Return the standard deviations of ``--sigma WHAT=NUMBER`` by the names of what is measured.

    Raises
    ------
    SpecError
        With all mistakes.
    """
    from gspcli.motion.files.number_tables import wrong_number

    found: dict[str, float] = {}
    mistakes = []
    for text in texts:
        name, equals, number = text.partition("=")
        message = ""
        if not equals:
            message = f"found {shown(text)}, expected WHAT=NUMBER, as value=0.001"
        elif name in found:
            message = f"found {name} twice"
        else:
            message = wrong_number(number)
        if message:
            mistakes.append(Mistake(None, "--sigma", message))
        else:
            found[name] = float(number)
    if mistakes:
        raise SpecError(mistakes)
    return found
