"""What the pages show of instance files: correct ones with real poses, messages of mistakes."""

import re
from pathlib import Path

import pytest

from gspcli.errors import SpecError
from gspcli.solver import solve
from gspcli.spec import loads, read_text

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "machine-file.md").read_text(encoding="utf-8")
FILE, MESSAGES = (
    re.search(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)[1] for kind in ("yaml", "text")
)


def test_the_file_is_correct():
    assert read_text(FILE).warnings == ()


#: Files of `gsp freedoms` may have fewer than six constraints: its page is left out.
PAGES = [
    ROOT / "README.md",
    *sorted(set((ROOT / "docs").glob("*.md")) - {ROOT / "docs" / "constraint-solvers.md"}),
]
EXAMPLES = [
    pytest.param(text, id=f"{page.name}-{number}")
    for page in PAGES
    for number, text in enumerate(
        re.findall(r"```yaml\n(gsp: .*?)```", page.read_text(encoding="utf-8"), re.DOTALL), 1
    )
]


@pytest.mark.parametrize("text", EXAMPLES)
def test_every_instance_in_the_pages_has_real_poses(text):
    reading = read_text(text)
    assert reading.warnings == ()
    result = solve(reading.instance)
    assert result.verdict == "complete"
    assert result.counts.real > 0


def test_the_messages_are_those_of_its_mistakes():
    wrong = FILE.replace("[P1, L5]", "[P1, L7]").replace("value: 60", "value: 200")
    with pytest.raises(SpecError) as caught:
        loads(wrong.replace("value: 70", "vlaue: 70"), name="f.yaml")
    assert f"{caught.value}\n" == MESSAGES
