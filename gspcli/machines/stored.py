"""An instance in a file for another program, so that the file leads back to it exactly.

The text of the instance file is stored beside a digest of the model. A model that was changed since
has another digest: then the model is read, not the text.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

from gspcli.machines.markup import Element

#: Names of the stored texts: the instance, and the digest of the model around it.
INSTANCE, DIGEST = "gsp", "gsp-model"


def digest(root: Element) -> str:
    """Return a digest of a model: of its elements and attributes, but not of the stored texts."""
    return hashlib.sha256("\n".join(_lines(root)).encode()).hexdigest()


def _lines(element: Element) -> Iterator[str]:
    if element.tag == "custom":
        return
    yield repr((element.tag, sorted(element.attributes.items())))
    for child in element.children:
        yield from _lines(child)
    yield "/"


def stored_text(root: Element) -> tuple[str | None, bool]:
    """Return the text of the instance that a model stores, and whether the model is the same still.

    Parameters
    ----------
    root
        The root of an MJCF file.
    """
    texts = {
        text.get("name"): text.get("data")
        for custom in root.all("custom")
        for text in custom.all("text")
    }
    found = texts.get(INSTANCE)
    return found, found is not None and texts.get(DIGEST) == digest(root)
