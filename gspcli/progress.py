"""How long work reports its progress, without knowing who listens."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeVar

Item = TypeVar("Item")


class Progress(Protocol):
    """Wraps an iterable and shows its progress."""

    def __call__(
        self, items: Iterable[Item], *, total: int | None = None, label: str = ""
    ) -> Iterable[Item]:
        """Yield the items unchanged while reporting progress."""
        ...


def silent(items: Iterable[Item], *, total: int | None = None, label: str = "") -> Iterable[Item]:
    """Report nothing: the default `Progress`."""
    return items
