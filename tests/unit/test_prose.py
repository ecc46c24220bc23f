"""The check of sentences finds long ones and riddles, in code and in pages."""

from pathlib import Path

import pytest

from tools.recording import ROOT
from tools.verify import prose

LONG = "word " * 36


def found(text: str, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what is found in a file: line and reason."""
    monkeypatch.setattr(prose, "ROOT", tmp_path)
    path = tmp_path / f"file{suffix}"
    path.write_text(text, encoding="utf-8")
    return [f"{finding.line} {finding.why.split(' (')[0]}" for finding in prose.findings(path)]


@pytest.mark.parametrize(
    ("suffix", "text", "expected"),
    [
        (".py", '"""The end, which nobody knows."""\n', ["1 'nobody'", "1 'knows'"]),
        (".py", f'"""Title.\n\n{LONG}.\n"""\n', ["3 36 words"]),
        (".py", f"x = 1  # {LONG}\n", ["1 36 words"]),
        (".py", "# The rest is skipped.\n#: Whatever comes.\n", ["2 'Whatever'"]),
        (".py", "nobody = 'nobody knows'\n", []),
        (
            ".cpp",
            "int x; // as it is.\n/* The path\n * ends nowhere. */\n",
            ["1 'as it is'", "2 'ends nowhere'"],
        ),
        (".py", '"""Title.\n\n\\b\nExamples:\n  gsp as it is.\n\nIt wants.\n"""\n', ["7 'wants'"]),
        (".md", "# Nobody\n\nThe `nobody` of [a page](nobody.md).\n\n    nobody\n", []),
        (".md", "# What nobody can read\n", ["1 'nobody'"]),
        (
            ".md",
            f"| a | b |\n|---|---|\n| `x` | of no use. A {LONG[5:]} |\n",
            ["3 'of no use'", "3 36 words"],
        ),
        (".py", "x = 1  # The path is taken up and followed anew.\n", ["1 'taken up'", "1 'anew'"]),
        (".md", f"Text.\n\n- {LONG}\n", ["3 36 words"]),
        (".md", "```\nnobody\n```\n\nand somebody\n", ["5 'somebody'"]),
    ],
)
def test_what_is_found(
    suffix: str,
    text: str,
    expected: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert found(text, suffix, tmp_path, monkeypatch) == expected


def test_messages_of_the_package_are_checked() -> None:
    source = (
        '''"""A docstring: nobody."""\nx = f"found {1}, which nobody can read"\ny = "nobody"\n'''
    )
    assert list(prose.message_texts(source)) == [(2, "found 0, which nobody can read")]


def test_parameters_and_items_are_sentences_of_their_own() -> None:
    text = "Title.\n\nx\n    one two\ny\n    three\n- an item\n  goes on\n"
    assert [sentence for _, sentence in prose.sentences(1, text)] == [
        "Title.",
        "x",
        "one two",
        "y",
        "three",
        "- an item goes on",
    ]


def test_what_is_checked_exists() -> None:
    assert all((ROOT / name).exists() for name in prose.CHECKED)


def test_exceptions_are_needed() -> None:
    texts = {
        path.relative_to(ROOT).as_posix(): path.read_text()
        for path in prose.files(list(prose.CHECKED))
    }
    for begin, piece in prose.EXCEPTIONS:
        assert any(
            name.startswith(begin) and piece in " ".join(text.split())
            for name, text in texts.items()
        )
