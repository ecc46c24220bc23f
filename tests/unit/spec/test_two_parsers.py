"""The reader of ordinary files says the same of them as PyYAML, places included."""

from __future__ import annotations

import json
import random
from typing import Any

import pytest
import yaml

from gspcli.errors import SpecError
from gspcli.resources import instance_files
from gspcli.spec import loads
from gspcli.spec.any_yaml import parse
from gspcli.spec.document import Mapping, Scalar, Sequence, Value
from gspcli.spec.ordinary import read_ordinary
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


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("name", FILES)
def test_places_are_the_same(name, ending):
    text = FILES[name].read_text(encoding="utf-8").replace("\n", ending)
    quick = read_ordinary(text, name)
    assert quick is not None
    assert located(quick) == located(parse(text, name, []))


@pytest.mark.parametrize("name", FILES)
def test_a_file_as_json_has_the_same_content_and_places(name):
    text = json.dumps(yaml.safe_load(FILES[name].read_text(encoding="utf-8")), ensure_ascii=False)
    if "\\" in text:
        pytest.skip("escapes are left to the parser")
    quick = read_ordinary(text, name)
    assert quick is not None
    assert located(quick) == located(parse(text, name, []))


#: Ordinary in all ways that there are; shipped files use few of them.
ORDINARY = """\
a: b
e:
  - f: [1, -2, "q r"]   # list
    g:
      h: 'i'
  - j#k
  # a remark
l:
- {m: n, o: {p: [q,
r], s: -t}}
- ''
u: http://v.w:x/y#z   two  blanks
1: "é # {"
"2 3": ~
end:
"""
#: What is no ordinary file, though it is YAML.
OTHERS = [
    "a: b\n c",
    "a: >\n  b",
    'a: "b\\n"',
    "a: 'b''c'",
    "a: &b c",
    "a: !b c",
    "? a\n: b",
    "---\na: b",
    "a: b\n...\n",
    "a: 'b\tc'",
    "a: [b, ]",
    "a: {b, c: d}",
    "a: [b\n c]",
    "a:\n  'b\n  c'",
    "- - a",
    '{"a":1}',
    " a: b",
    "a: b\rc: d",
]


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_every_ordinary_form_is_read(ending):
    text, mistakes = ORDINARY.replace("\n", ending), []
    quick = read_ordinary(text, "file")
    assert quick is not None
    assert located(quick) == located(parse(text, "file", mistakes))
    assert not mistakes


@pytest.mark.parametrize("text", OTHERS)
def test_other_forms_are_left_to_the_parser(text):
    parse(text, "file", [])
    assert read_ordinary(text, "file") is None


def test_what_is_taken_for_ordinary_is_read_as_such():
    """Files with something put in or taken out: accepted by the reader, so by the parser."""
    rng = random.Random(1)
    texts = [path.read_text(encoding="utf-8") for path in FILES.values()] + [ORDINARY] * 20
    correct = 0
    for _ in range(300):
        text = rng.choice(texts)
        start = rng.randrange(len(text))
        changed = text[:start] + rng.choice(PIECES) + text[start + rng.randrange(3) :]
        quick = read_ordinary(changed, "file")
        if quick is None:
            continue
        mistakes = []
        try:
            full = parse(changed, "file", mistakes)
        except SpecError as error:
            pytest.fail(f"{error}\n{changed}")
        assert located(quick) == located(full)
        assert not mistakes
        correct += 1
    assert correct > 50


def test_an_ordinary_file_is_read_with_few_calls():
    text = FILES["example-6.8"].read_text(encoding="utf-8")
    loads(text)
    assert calls(lambda: loads(text)) < 8000
