"""What commands print is what the files of fields describe, and every field has a meaning."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import gspcli.cli.result
from gspcli.cli.result import Fields

CLI = Path(gspcli.cli.result.__file__).parent
NAMES = sorted(
    path.stem
    for path in (CLI / "fields").glob("*.txt")
    if path.stem not in ("platform", "verdicts")
)


@pytest.mark.parametrize("name", NAMES)
def test_every_field_has_a_meaning_and_every_column_is_found(name: str) -> None:
    described = Fields(name)
    assert all(one.meaning for fields in described.forms.values() for one in fields)
    source = CLI / "commands" / f"{name.replace('-', '_').removesuffix('_summary')}.py"
    if source.exists():
        for names in re.findall(r'FIELDS\.of\(\s*"([^"]+)"\s*\)', source.read_text()):
            described.of(names)


def _paths(value: Any, above: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for key, entry in value.items():
            path = f"{above}.{key}" if above else key
            yield path
            yield from _paths(entry, path)
    elif isinstance(value, list):
        for entry in value:
            yield from _paths(entry, above)


@pytest.mark.parametrize(
    "words",
    [
        "show 421",
        "bound 6PP",
        "constraint DLL",
        "example",
        "check @dietmaier",
        "count @planar-hexagons",
        "solve @planar-hexagons --all",
        "sensors @rubin-m2",
        "measure @t-top-head --pose 0,0,0.17,1,0,0,0 --drives",
        "measure @workspace-study --pose 0,0,400,1,0,0,0 --nearest",
        "measure @rubin-m2 --pose 0,0,0,1,0,0,0 --require range",
        "freedoms @rubin-m2",
        "analyze @rubin-m2",
        "clearance @rubin-m2",
        "scan @platform-6-3 --vary 3=1.4:1.5:2",
        "workspace @workspace-study --shift x=1:2:2",
    ],
)
def test_every_key_that_is_printed_is_described(words: str, gsp: Callable) -> None:
    document = json.loads(gsp(*words.split(), "--format", "json").out)
    described = [
        re.compile(
            re.escape(one.path.replace("[]", "")).replace(r"\*", ".+").replace("1…6", "[1-6]")
        )
        for one in Fields(words.split()[0]).forms[document.pop("schema")]
        if one.path
    ]
    printed = set(_paths(document))
    assert not {path for path in printed if not any(one.fullmatch(path) for one in described)}
