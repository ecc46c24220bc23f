"""C99 for one platform: ``platform.h`` and ``platform.c`` with its numbers in them.

Parts that the kinds of the platform do not need are left out. The complete source is compiled into
the kernel (native/controller.cpp) for `gspcli.Follower`.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from importlib import resources

import numpy as np

from gspcli.errors import ArgumentError
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.motion.following.follower import (
    LimitNumbers,
    PlatformNumbers,
    limit_numbers,
    platform_numbers,
)
from gspcli.solver import Solution
from gspcli.spec import dumps
from gspcli.wording import shown

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,40}")
_CONDITION = re.compile(r"#if (HAS_\w+(?: \|\| HAS_\w+)*)$")
_WORD = re.compile(r"@(\w+)@")
_WIDTH = 100


def controller(
    instance: Instance,
    prefix: str,
    *,
    tries: int = 48,
    name: str = "",
    home: Solution | None = None,
    margin: float = 0.0,
) -> tuple[str, str]:
    """Return the header and the source for a platform.

    Parameters
    ----------
    instance
        The platform; its values are used for the rods of cranks and slides only.
    prefix
        The beginning of all public names.
    tries
        How many parts of a line of values are tried before it is refused.
    name
        The name of the files without suffix; the prefix if it is empty.
    home
        A pose that the header is to have as a constant, or None.
    margin
        The part of its range by which a value may leave it, from 0 to 1.

    Raises
    ------
    ArgumentError
        If the prefix is no name in C, the margin is not from 0 to 1, or a crank or slide is not at
        the end of exactly one leg.
    """
    if not _IDENTIFIER.fullmatch(prefix):
        message = f"found {shown(prefix)}, expected a name in C: letters, digits and _"
        raise ArgumentError(message, "prefix")
    numbers = platform_numbers(instance, margin)
    pivot = PoseFrame.of(instance).tool.T
    limits = limit_numbers(instance, numbers, pivot=pivot)
    words = _words(instance, numbers, home) | {
        "MARGIN": _number(margin),
        "PIVOT": _row(np.zeros(3) if pivot is None else pivot),
        "TURN": _number(limits.weight * numbers.reach),
        "LIMITS": _limits(limits),
    }
    have = {*numbers.kinds, "DATA"} | ({"HOME"} if home is not None else set())
    have |= {"CONES"} if limits.cones else set()
    texts = []
    for parts in (("platform.h",), ("platform.c", "nearest.c")):
        files = [resources.files(__package__).joinpath(part) for part in parts]
        template = "\n".join(file.read_text(encoding="utf-8") for file in files)
        text = _resolved(template, have)
        words["DATA"] = _data(numbers, text)
        text = _WORD.sub(lambda match: words[match[1]], text)
        text = text.replace("or a crank does not", f"or a {_drive_word(numbers.kinds)} does not")
        text = text.replace("PLATFORM_TRIES 48", f"PLATFORM_TRIES {tries}")
        text = text.replace("platform.h", f"{name or prefix}.h")
        text = re.sub(r"\bplatform_(?=\w)", f"{prefix}_", text)
        texts.append(re.sub(r"\bPLATFORM_(?!CRANK|SLIDE)", f"{prefix.upper()}_", text))
    return texts[0], texts[1]


def _resolved(template: str, have: set[str]) -> str:
    """Return a template without the parts that the platform does not need."""
    lines: list[str] = []
    kept = [True]
    conditional: list[bool] = []
    for line in template.splitlines():
        condition = _CONDITION.fullmatch(line)
        if condition:
            names = {name.removeprefix("HAS_") for name in condition[1].split(" || ")}
            kept.append(kept[-1] and bool(names & have))
            conditional.append(True)
            continue
        if line.startswith("#if"):
            conditional.append(False)
        elif line == "#endif" and conditional.pop():
            kept.pop()
            continue
        if kept[-1]:
            lines.append(line)
    return "\n".join(lines) + "\n"


def _words(instance: Instance, numbers: PlatformNumbers, home: Solution | None) -> dict[str, str]:
    """Return what stands for the words in the templates."""
    cranked = any(kind.endswith("CRANK") for kind in numbers.kinds)
    slides = any(kind.endswith("SLIDE") for kind in numbers.kinds)
    of_two = ""
    if cranked or slides:
        what = "two angles of a crank" if cranked else "two places of a slide"
        what = "two numbers of a crank or slide" if cranked and slides else what
        of_two = f"; of the {what} the one nearer to "
    sided = any(row.kind.has_sides for row in instance.constraints)
    return {
        "NAME": _comment(instance.name or instance.type.id),
        "LENGTH": _comment(instance.units.length),
        "ANGLE": instance.units.angle.value,
        "VALUES": _values(instance, numbers),
        "SIGNED": "\n * Distances to planes are signed." if sided else "",
        "CRANKED": (
            "\n * The value of a crank is its angle from where the file states its joint."
            if cranked
            else ""
        )
        + (
            "\n * The value of a slide is its way from where the file states its joint."
            if slides
            else ""
        ),
        "DIGEST": "sha256 " + hashlib.sha256(dumps(instance).encode()).hexdigest()[:16],
        "REACH": _number(numbers.reach),
        "MIDDLE": _row(numbers.middle),
        "HOME": _home(home),
        "HINT": of_two and f"{of_two}what `values` holds",
        "ZERO": of_two and f"{of_two}zero",
    }


def _drive_word(kinds: tuple[str, ...]) -> str:
    """Return the word for a drive in messages about reach."""
    cranked, slides = (any(kind.endswith(end) for kind in kinds) for end in ("CRANK", "SLIDE"))
    return "crank or slide" if cranked and slides else "slide" if slides else "crank"


def _comment(text: str) -> str:
    """Return a text without the mark that ends a comment."""
    return " ".join(text.replace("*/", "* /").split())


def _values(instance: Instance, numbers: PlatformNumbers) -> str:
    """Return the meaning of the values, for a comment."""
    parts = []
    for k, (row, kind) in enumerate(zip(instance.constraints, numbers.kinds, strict=True)):
        what = {
            "BASE_CRANK": f"crank {row.base_name}",
            "PLATFORM_CRANK": f"crank {row.platform_name}",
            "BASE_SLIDE": f"slide {row.base_name}",
            "PLATFORM_SLIDE": f"slide {row.platform_name}",
        }
        names = "-".join(name for name in (row.platform_name, row.base_name) if name)
        parts.append(_comment(f"{k + 1} {what.get(kind, kind)} {names}".strip()))
    lines, line = [], ""
    for part in parts:
        if line and len(line) + len(part) > _WIDTH - 14:
            lines.append(line)
            line = ""
        line += ("; " if line else "") + part
    return ";\n *   ".join((*lines, line))


def _home(home: Solution | None) -> str:
    if home is None:
        return ""
    position = ", ".join(_number(x) for x in home.T.real)
    rotation = ", ".join(_number(x) for x in home.quaternion.real)
    return f"{{{{{position}}}, {{{rotation}}}}}"


def _data(numbers: PlatformNumbers, source: str) -> str:
    """Return the definition of the numbers that the struct in a source has."""
    struct = source.partition("typedef struct {\n  unsigned char kind")[2].partition("} geometry;")[
        0
    ]
    names = set(re.findall(r"\b(\w+)(?=(?:\[\d\])*[,;])", "unsigned char kind" + struct))
    lines = ["static const geometry data = {"]
    for name in PlatformNumbers.__annotations__:
        if name in names:
            lines += _entry(name, numbers)
    return "\n".join([*lines, "};", ""])


def _limits(limits: LimitNumbers) -> str:
    """Return the definition of the ranges and cones."""
    lines = ["static const limits within = {"]
    lines += [f"    .{name} = {_row(getattr(limits, name))}," for name in ("low", "high", "pivot")]
    lines += [f"    .weight = {_number(limits.weight)},"]
    if limits.cones:
        rows = limits.axis[: limits.cones]
        lines += ["    .axis = {", *(f"        {_row(row)}," for row in rows), "    },"]
        lines += [
            f"    .half = {_row(limits.half[: limits.cones])},",
            f"    .cones = {limits.cones},",
            f"    .leg = {_row(limits.leg)},",
            f"    .on_base = {_row(limits.on_base.astype(np.uint8))},",
        ]
    return "\n".join([*lines, "};", ""])


def _row(numbers: Iterable[float | np.generic]) -> str:
    return f"{{{', '.join(map(_number, numbers))}}}"


def _entry(name: str, numbers: PlatformNumbers) -> list[str]:
    value = getattr(numbers, name)
    if name == "kind":
        return [f"    .kind = {{{', '.join(numbers.kinds)}}},"]
    if np.ndim(value) == 0:
        return [f"    .{name} = {_number(value)},"]
    if np.ndim(value) == 1:
        return [f"    .{name} = {_row(value)},"]
    return [f"    .{name} = {{", *(f"        {_row(row)}," for row in value), "    },"]


def _number(x: float | np.generic) -> str:
    """Return the shortest literal that is read back as this number."""
    return str(int(x)) if isinstance(x, np.uint8) else repr(float(x))
