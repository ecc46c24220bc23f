"""The public names of the package."""

from __future__ import annotations

import pytest

import gspcli


def test_every_public_name_can_be_imported() -> None:
    for name in gspcli.__all__:
        assert getattr(gspcli, name) is not None
    assert set(dir(gspcli)) == set(gspcli.__all__)


def test_public_names_are_all_listed() -> None:
    assert set(gspcli._HOMES) | {"__version__"} == set(gspcli.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'frobnicate'"):
        _ = gspcli.frobnicate
