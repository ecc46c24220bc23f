"""The instance files that are part of gsp, by name."""

from __future__ import annotations

from gspcli.geometry.instance import Instance
from gspcli.resources import shipped_file
from gspcli.spec.reading import load


def example(name: str) -> Instance:
    """Return an instance that is part of gsp: an example, or a real machine.

    Parameters
    ----------
    name
        A name in the list of `gsp example`, with or without the ``@`` of the command line.

    Raises
    ------
    GspError
        If there is no instance with that name.

    Examples
    --------
    >>> example("rubin-m2").type.number
    3389
    """
    return load(shipped_file(name.removeprefix("@")))
