"""Stores an instance in a file for another program, so that `gsp import` returns it exactly.

The text of the instance file is stored beside a digest of the model. A model that was changed since
has another digest: then the model is read, not the text. MJCF has texts of its own; SDF and URDF
get an element in a namespace, which their programs ignore.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from gspcli.machines.source import MarkupElement, parse
from gspcli.spec.writing import dumps

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

#: Names of the stored texts of MJCF: the instance, and the digest of the model around it.
INSTANCE, DIGEST = "gsp", "gsp-model"
#: The element of SDF and URDF, which has the digest as an attribute, and its namespace.
_ELEMENT, _SPACE = "gsp:instance", "https://example.invalid/gsp"


def digest(root: MarkupElement, *beside: str) -> str:
    """Return a digest of a model and the texts of its other files, without the stored instance."""
    return hashlib.sha256("\n".join((*_lines(root), *beside)).encode()).hexdigest()


def _lines(element: MarkupElement) -> Iterator[str]:
    if element.tag in ("custom", _ELEMENT):
        return
    yield repr((element.tag, sorted(element.attributes.items()), element.text.strip()))
    for child in element.children:
        yield from _lines(child)
    yield "/"


def stored_text(root: MarkupElement, *beside: str) -> tuple[str | None, bool]:
    """Return the text of the instance that a model stores, and whether the model is unchanged.

    The model is the root of MJCF, SDF or URDF, with the texts of files that belong to it.
    """
    element = next(root.everywhere(_ELEMENT), None)
    if element is not None:
        return element.text.strip() + "\n", element.get("model") == digest(root, *beside)
    texts = {
        text.get("name"): text.get("data")
        for custom in root.all("custom")
        for text in custom.all("text")
    }
    found = texts.get(INSTANCE)
    return found, found is not None and texts.get(DIGEST) == digest(root, *beside)


def store_custom(root: ET.Element, instance: Instance) -> None:
    """Store an instance in a finished model in MJCF."""
    found = digest(parse(ET.tostring(root, encoding="unicode"), ""))
    custom = ET.SubElement(root, "custom")
    ET.SubElement(custom, "text", name=INSTANCE, data=dumps(instance))
    ET.SubElement(custom, "text", name=DIGEST, data=found)


def signed(root: ET.Element, where: ET.Element, instance: Instance, *beside: str) -> str:
    """Store an instance in an element of a finished SDF or URDF, and return the text of the model.

    Texts of files that belong to the model count for its digest.
    """
    found = digest(parse(ET.tostring(root, encoding="unicode"), ""), *beside)
    stored = ET.SubElement(where, _ELEMENT, {"xmlns:gsp": _SPACE, "model": found})
    stored.text = "\n" + dumps(instance)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"
