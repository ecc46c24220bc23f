"""docs/instance-file.md shows a correct file and the messages that mistakes in it really give."""

import re
from pathlib import Path

import pytest

from gspcli.errors import SpecError
from gspcli.spec import loads, read_text

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "instance-file.md").read_text(
    encoding="utf-8"
)
FILE, MESSAGES = (
    re.search(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)[1] for kind in ("yaml", "text")
)


def test_the_file_is_correct():
    assert read_text(FILE).warnings == ()


def test_the_messages_are_those_of_its_mistakes():
    wrong = FILE.replace("[P1, L5]", "[P1, L7]").replace("value: 60", "value: 200")
    with pytest.raises(SpecError) as caught:
        loads(wrong.replace("value: 70", "vlaue: 70"), name="f.yaml")
    assert f"{caught.value}\n" == MESSAGES
