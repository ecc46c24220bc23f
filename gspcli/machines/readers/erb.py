"""Templates of models in ERB: constants and numbers; nothing of Ruby is run."""

from __future__ import annotations

import re

from gspcli.machines.arithmetic import value_of
from gspcli.machines.source import SourceLine
from gspcli.wording import shown

_BLOCK = re.compile(r"<%(.*?)%>", re.DOTALL)
_ASSIGNED = re.compile(r"\s*([A-Za-z_]\w*)\s*=(?!=)\s*(.+?)\s*")


def expanded(text: str, file: str) -> str:
    """Return a template with its numbers in it.

    Parameters
    ----------
    text
        The template: ``<% NAME = expression %>`` and ``<%= expression %>``.
    file
        Its name.

    Raises
    ------
    SpecError
        If the template has anything else; the message has the line.
    """
    names: dict[str, float] = {}

    def replaced(match: re.Match[str]) -> str:
        line = text.count("\n", 0, match.start()) + 1
        code = match[1]
        if code.startswith("="):
            return repr(_value(code[1:], names, SourceLine(file, line)))
        for number, said in enumerate(code.splitlines()):
            statement = said.split("#")[0]
            if not statement.strip():
                continue
            place = SourceLine(file, line + number)
            assigned = _ASSIGNED.fullmatch(statement)
            if assigned is None:
                message = f"found {shown(statement.strip())}, expected NAME = an expression"
                raise place.error(message + ": templates with programs in them are not read")
            names[assigned[1]] = _value(assigned[2], names, place)
        return "\n" * code.count("\n")

    return _BLOCK.sub(replaced, text)


def _value(code: str, names: dict[str, float], place: SourceLine) -> float:
    plain = re.sub(r"\bPI\b", "pi", re.sub(r"\bMath(?:\.|::)", "", code))
    try:
        return value_of(plain, names, whole=True)
    except ValueError as error:
        raise place.error(f"found {shown(code.strip())}: {error}") from None
