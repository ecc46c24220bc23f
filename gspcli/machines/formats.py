"""Which format a file has, by what is in it, and its reader."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gspcli.geometry.instance import Instance
from gspcli.machines.graph import Graph
from gspcli.machines.markup import Element, parse
from gspcli.machines.source import Place, text_of
from gspcli.machines.stored import INSTANCE, stored_text
from gspcli.spec.reading import loads
from gspcli.wording import listed, shown

#: What a file can be, by what it begins with.
_FOUND = ("<mujoco> (MJCF)",)


def machine_of(path: Path, *, stored: bool = True) -> Graph | Instance:
    """Return the machine of a file, or the instance that gsp stored in it.

    Parameters
    ----------
    path
        The file; what belongs to it is beside it.
    stored
        Whether a stored instance is looked for.

    Raises
    ------
    OSError
        If it cannot be read.
    GspError
        If it has none of the formats, or mistakes.
    """
    text, file = text_of(path), str(path)
    if text.lstrip()[:1] == "<":
        root = parse(text, file)
        if root.tag == "mujoco":
            return _mjcf(root, path, stored)
        raise root.error(f"found <{root.tag}>, expected {listed(_FOUND)}")
    first = next((line for line in text.splitlines() if line.strip()), "")
    raise Place(file).error(f"found {shown(first)}, expected {listed(_FOUND)}")


def _mjcf(root: Element, path: Path, stored: bool) -> Graph | Instance:
    from gspcli.machines.readers import mjcf

    text, same = stored_text(root)
    if text is not None and same and stored:
        return loads(text, name=f"{path.name}, the text {INSTANCE}")
    graph = mjcf.read(root, path.stem)
    if text is None or same:
        return graph
    note = "the model was changed after gsp wrote it: the instance stored in it is not used"
    return replace(graph, notes=(*graph.notes, note))
