"""A machine from the file of another program, as `gsp import` reads it."""

from __future__ import annotations

import os
from pathlib import Path

from gspcli.defaults import IMPORTED_DIGITS, MEETING_SHARE
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.machines.formats import machine_of
from gspcli.machines.graph import NoPlatform
from gspcli.machines.instances import instance_of, plain, sentences, text_of
from gspcli.machines.recognition import recognized
from gspcli.records import dataclass
from gspcli.spec.writing import dumps
from gspcli.wording import named, shown


@dataclass(frozen=True, eq=False)
class ImportedMachine:
    """A machine from the file of another program.

    Attributes
    ----------
    instance
        The platform.
    text
        Its instance file, with comments that say what each chain is, and what the file cannot
        state.
    format
        The format of the file that was read, such as MJCF.
    described
        One line about the file: its bodies, joints and loops, the base and the platform.
    base, platform
        The names of these two bodies in the file.
    chains
        A line for each constraint: its chain, and what the chain holds.
    notes
        What was assumed or left out, and what the file leaves open.
    """

    instance: Instance
    text: str
    format: str
    described: str
    base: str
    platform: str
    chains: tuple[str, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        bodies = f"base {shown(self.base)}, platform {shown(self.platform)}"
        return f"<ImportedMachine from {self.format}: {self.instance.type.id}; {bodies}>"

    def __str__(self) -> str:
        return self.text


def import_machine(
    file: str | os.PathLike[str],
    *,
    base: str | None = None,
    platform: str | None = None,
    meet: float = MEETING_SHARE,
    digits: int = IMPORTED_DIGITS,
) -> ImportedMachine:
    """Read a machine from the file of another program.

    Parameters
    ----------
    file
        MJCF, SDF, URDF, CASPR, LinuxCNC or a table, as `gsp import --help` lists them.
    base, platform
        The names of the bodies to take as base and platform; found if None.
    meet
        Axes that pass each other at up to this share of the size are taken to meet.
    digits
        Number of digits in the instance, counted from the first digit of the machine's size.

    Raises
    ------
    GspError
        If the file cannot be read, or describes no platform with six constraints.
    """
    if not 0 <= meet < 1:
        raise ArgumentError(f"found {meet}, expected a share from 0 to 1", "meet")
    if not 3 <= digits <= 17:
        raise ArgumentError(f"found {digits}, expected 3 to 17", "digits")
    path = Path(file)
    found = machine_of(path, stored=base is None and platform is None)
    if isinstance(found, Instance):
        note = f"{path.name} is a model that gsp wrote: this is the instance stored in it"
        text = f"# {plain(note)}.\n{dumps(found)}"
        said = f"a model of gsp with {found.type.id}"
        return ImportedMachine(found, text, "gsp", said, "world", "platform", (), (note,))
    try:
        machine = recognized(found, base=base, platform=platform, meet=meet)
        instance = instance_of(machine, digits)
    except NoPlatform as error:
        raise NoPlatform(f"{named(path)}: {found.format}: {error}") from None
    notes = tuple(map(plain, machine.notes))
    bottom, top = (plain(body) for body in (machine.structure.base, machine.structure.platform))
    head = f"Imported from {path.name} ({found.format}): base {bottom}, platform {top}"
    text = text_of(machine, instance, [head, *notes])
    said = f"{found.format}: {found.described()}; base {bottom} ({machine.structure.reason}), "
    said += f"platform {top}"
    chains = tuple(sentences(machine))
    return ImportedMachine(instance, text, found.format, said, bottom, top, chains, notes)
