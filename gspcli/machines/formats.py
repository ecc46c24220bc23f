"""Which format a file has, by what is in it, and its reader."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from gspcli.geometry.instance import Instance
from gspcli.machines.graph import Graph
from gspcli.machines.markup import MarkupElement, parse
from gspcli.machines.source import SourceLine, text_of
from gspcli.machines.stored import stored_text
from gspcli.spec.reading import loads
from gspcli.wording import listed, shown

#: What a file can be, by what is in it.
FORMATS = (
    "<mujoco> (MJCF)",
    "<sdf> (SDF)",
    "<robot> (URDF)",
    "<cables> (CASPR)",
    "setp genhexkins (LinuxCNC)",
    "columns bx, by, bz, px, py, pz (a table)",
)


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
        return _marked_up(text, path, stored)
    from gspcli.machines.readers import linuxcnc, tables

    if linuxcnc.is_hal(text):
        return linuxcnc.read(text, path)
    if tables.is_table(text):
        return tables.read(text, file, path.stem)
    first = next((line for line in text.splitlines() if line.strip()), "")
    raise SourceLine(file).error(f"found {shown(first)}, expected {listed(FORMATS)}")


def _marked_up(text: str, path: Path, stored: bool) -> Graph | Instance:
    root = parse(text, str(path))
    if root.tag == "mujoco":
        from gspcli.machines.readers import mjcf

        return _or_stored(root, path, stored, lambda: mjcf.read(root, path.stem))
    if root.tag == "sdf":
        from gspcli.machines.readers import sdf

        return _or_stored(root, path, stored, lambda: sdf.read(root, path.stem))
    if root.tag == "robot":
        from gspcli.machines.readers import urdf

        beside = urdf.beside(path)
        texts = [text_of(beside)] if beside.exists() else []
        return _or_stored(root, path, stored, lambda: urdf.read(root, path), *texts)
    if root.tag in ("cables", "bodies_system"):
        return _caspr(root, path)
    raise root.error(f"found <{root.tag}>, expected {listed(FORMATS)}")


def _or_stored(
    root: MarkupElement, path: Path, stored: bool, read: Callable[[], Graph], *beside: str
) -> Graph | Instance:
    """Return the instance that gsp stored in a model, else what a reader makes of it."""
    text, same = stored_text(root, *beside)
    if text is not None and same and stored:
        return loads(text, name=f"{path.name}, the stored instance")
    graph = read()
    if text is None or same:
        return graph
    note = "the model was changed after gsp wrote it: the instance stored in it is not used"
    return replace(graph, notes=(*graph.notes, note))


def _caspr(root: MarkupElement, path: Path) -> Graph:
    """Read the two files of a robot: NAME_bodies.xml and NAME_cables.xml."""
    from gspcli.machines.readers import caspr

    own, other = ("cables", "bodies") if root.tag == "cables" else ("bodies", "cables")
    beside = path.with_name(path.name.replace(f"_{own}", f"_{other}"))
    if beside == path or not beside.exists():
        message = f"found the {own} alone, expected NAME_{own}.xml and NAME_{other}.xml together"
        raise root.error(message)
    found = {own: root, other: parse(text_of(beside), str(beside))}
    name = path.stem.replace(f"_{own}", "")
    return caspr.read(found["bodies"], found["cables"], name)
