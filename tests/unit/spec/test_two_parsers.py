"""The parser in C and the one in Python say the same of a file, places included."""

from __future__ import annotations

import random
from typing import Any

import pytest

from gspcli.errors import SpecError
from gspcli.resources import instance_files
from gspcli.spec import loads
from gspcli.spec.document import Mapping, Scalar, Sequence, Value, parse, parse_correct
from tests.support.effort import calls

FILES = instance_files()
#: What may stand in a file, and what may go wrong in one.
PIECES = [":", " ", "\n", "\t", "'", '"', "[", "]", "{", "}", ",", "-", "#", "&a", "*a", "!t", "é"]


def located(value: Value) -> Any:
    """Return content and places as plain data."""
    where = str(value.location), value.path
    if isinstance(value, Mapping):
        return where, [(located(key), located(item)) for key, item in value.items()]
    if isinstance(value, Sequence):
        return where, [located(item) for item in value]
    assert isinstance(value, Scalar)
    return where, str(value)


@pytest.mark.parametrize("name", FILES)
def test_places_are_the_same(name):
    text = FILES[name].read_text(encoding="utf-8")
    quick = parse_correct(text, name)
    assert quick is not None
    assert located(quick) == located(parse(text, name, []))


def test_what_is_taken_for_correct_is_so():
    """Files with something put in or taken out: accepted by one parser, so by the other."""
    rng = random.Random(1)
    texts = [path.read_text(encoding="utf-8") for path in FILES.values()]
    correct = 0
    for _ in range(300):
        text = rng.choice(texts)
        start = rng.randrange(len(text))
        changed = text[:start] + rng.choice(PIECES) + text[start + rng.randrange(3) :]
        quick = parse_correct(changed, "file")
        if quick is None:
            continue
        problems = []
        try:
            full = parse(changed, "file", problems)
        except SpecError as error:
            pytest.fail(f"{error}\n{changed}")
        assert located(quick) == located(full)
        assert not problems
        correct += 1
    assert correct > 50


def test_an_ordinary_file_is_read_with_few_calls():
    """3 ms on a quiet machine."""
    text = FILES["example-6.8"].read_text(encoding="utf-8")
    loads(text)
    assert calls(lambda: loads(text)) < 8000
