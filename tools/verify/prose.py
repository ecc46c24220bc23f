"""Check the sentences of docstrings, comments, messages and pages: their length, and their words.

    python -m tools.verify.prose [FILE ...]

A sentence has at most 35 words. Numbers, programs and files are no persons: words such as `nobody`
and `wants` are refused, and the plain word to write instead is named. Code and text in backquotes
are not checked; headings and cells of tables are. Help and messages are the strings in `gspcli` of
four words or more. Prints each finding as FILE:LINE, and ends with 1 if there is one.
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tools.recording import ROOT

#: The longest sentence, in words.
MOST_WORDS = 35

#: Words that are refused (regular expressions), and what to write instead.
BANNED = {
    r"(?:no|any|every|some)body": "name the user, or say what is not known",
    r"whoever": "name the program or the person",
    r"who (?:can|knows?|judges?|asks?|leads?|finds?|found)": "name the user or the program",
    r"(?:know|known|knows|say|says) no (?:word|words|thing)": "say what the code does not use",
    r"(?:lead|leads|led|end|ends|ended) nowhere": "say how it ends: no pose, lost, at infinity",
    r"as (?:it is|they are)(?= written)": "'as written'",
    r"as (?:it is|they are)(?=[.,;:)])": "'unchanged', 'as given'",
    r"what (?:is|are) left(?: out| over)?": "'the rest', 'the remainder', 'the residual'",
    r"(?:that|which) (?:is|are) left(?! (?:out|open))": "'the rest', 'the others'",
    r"by (?:itself|themselves)": "'alone', 'separately', 'automatically'",
    r"without a word": "'without a message'",
    r"frighten\w*": "say what is shown, and what is omitted",
    r"want(?:s|ed)?": "'needs', 'takes', 'asked for'",
    r"knows": "'has', 'uses', 'depends on'",
    r"says? of": "'says about'",
    r"told": "'given', 'stated', 'distinguished'",
    r"for first": "'first'",
    r"lonely": "'single'",
    r"whatever": "'for any', 'independently of'",
    r"an?other'?s one": "name the thing",
    r"such a one": "name the thing",
    r"come(?:s)? of (?:it|them|age)": "say the result",
    r"has come": "say the state",
    r"had better": "'should'",
    r"so to speak": "leave it out",
    r"as good as": "say how good",
    r"of age": "leave it out",
    r"looked at": "'tested', 'compared', 'read'",
    r"(?:come|comes|came) out": "'the result is'",
    r"(?:stand|stands) behind": "'the proof of', 'the reason for'",
    r"said of": "'stated about'",
    r"taken up": "'continued'",
    r"(?:of no|of|no) use": "say what it does not help",
    r"went wrong": "say what is wrong",
    r"born": "'begins'",
    r"near no": "'not near a'",
    r"no other one": "name the thing",
    r"bec[ao]mes? of": "'the result of', 'the account of'",
    r"anew": "'again'",
}
_BANNED = [(re.compile(rf"\b{word}\b", re.IGNORECASE), better) for word, better in BANNED.items()]

#: A string of the package with this many words is a help or a message.
FEWEST_WORDS = 4

#: Sentences that stay: the beginning of a file's path, and a piece of the sentence.
EXCEPTIONS: tuple[tuple[str, str], ...] = (
    # The manifest of data/counts has this text; a record states it as it was when it was made.
    ("gspcli/atlas/records.py", "along a general pencil, relative"),
    # Notes of two files of data/platforms.
    ("docs/platforms.md", "The joints on the base are the ends of the arms at the motor angles"),
    ("docs/platforms.md", "four actuators push on the mirror and let it slide"),
    # A column of the record.
    ("tools/verify/sensors.py", "sets, told"),
)

#: Folders and files whose sentences are checked.
CHECKED = (
    "bench",
    "docs",
    "gspcli",
    "native",
    "tests",
    "tools",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "README.md",
)

_SOURCES = {".py", ".cpp", ".hpp", ".c", ".js", ".md"}
#: A line that begins a new sentence though the one before has no full stop.
_BEGINS = re.compile(r"\s*(?:$|[-*+] |\d+\. |[>|#]|\.\. |```|:\w+|-{3,})")
#: Comments of C: in asterisks, whole lines, and after code.
_COMMENTS = re.compile(
    r"/\*(?:[^*]|\*(?!/))*\*/|(?:^[ \t]*//[^\n]*\n)+|(?<=[ \t])//[^\n]*", re.MULTILINE
)
_ITEM = re.compile(r"\s*(?:[-*+]|\d+\.) ")
_ENDS = re.compile(r"(?<=[.:;!?])[)\"']*\s+(?=[^a-z])|\s·\s")
#: Lines that the help shows unchanged (examples and tables, after click's mark), and commands.
_AS_WRITTEN = re.compile(
    r"^[ \t]*(?:\\b|\x08)\n(?:[ \t]*\S[^\n]*(?:\n|\Z))*|^[ \t]+python -m [^\n]*", re.MULTILINE
)
_LEFT_OUT = re.compile(r"``.*?``|`[^`]*`|\[([^\]]*)\]\([^)]*\)|\$[^$]*\$|!\[[^\]]*\]\([^)]*\)")


class Finding(NamedTuple):
    """A sentence to rewrite, and why."""

    path: str
    line: int
    why: str
    sentence: str

    def __str__(self) -> str:
        """Return the line to print."""
        return f"{self.path}:{self.line}: {self.why}: {self.sentence[:160]}"


def python_texts(source: str) -> Iterator[tuple[int, str]]:
    """Yield docstrings and blocks of comments, each with the number of its first line."""
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Expr(value=ast.Constant(value=str(text))):
                yield node.lineno, _AS_WRITTEN.sub(_blank, text)
    last = -1
    block: list[str] = []
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type != tokenize.COMMENT:
            continue
        row, text = token.start[0], token.string.lstrip("#!: ")
        if row != last + 1 and block:
            yield last - len(block) + 1, "\n".join(block)
            block = []
        block.append(text)
        last = row
    if block:
        yield last - len(block) + 1, "\n".join(block)


def _blank(match: re.Match[str]) -> str:
    """Return as many empty lines."""
    return "\n" * match[0].count("\n")


def message_texts(source: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of strings of several words that are no docstrings, each with its line."""
    tree = ast.parse(source)
    # What is within another string, or is a statement: a docstring.
    parts: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            parts.update(part for part in ast.walk(node) if part is not node)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            parts.add(node.value)
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(text)):
                pass
            case ast.JoinedStr(values=values):
                # Each value is a word that does not count.
                text = "".join(str(x.value) if isinstance(x, ast.Constant) else "0" for x in values)
            case _:
                continue
        if node not in parts:
            for line in text.splitlines():
                if _count(line) >= FEWEST_WORDS:
                    yield node.lineno, line


def _count(sentence: str) -> int:
    """Return the number of words."""
    return sum(any(c.isalpha() for c in word) for word in sentence.split())


def comment_texts(source: str) -> Iterator[tuple[int, str]]:
    """Yield blocks of comments of C++, C or JavaScript, each with the number of its first line."""
    for match in _COMMENTS.finditer(source):
        lines = (re.sub(r"^\s*(?://[/!]?|/\*+|\*/?)|\*/", "", x) for x in match[0].splitlines())
        yield source.count("\n", 0, match.start()) + 1, "\n".join(lines)


def page_texts(source: str) -> Iterator[tuple[int, str]]:
    """Yield the text of a page without code and tables, line by line the same.

    Then yield the headings and the cells of tables.
    """
    code = False
    lines, apart = [], []
    for number, line in enumerate(source.splitlines(), 1):
        fence = line.lstrip().startswith("```")
        left_out = code or fence or line.startswith(("    ", "|", "#", "<!--", "gsp:"))
        lines.append("" if left_out else line)
        code ^= fence
        if line.startswith(("|", "#")) and not (code or fence):
            apart += [(number, cell.strip(" #")) for cell in line.strip("|").split("|")]
    yield 1, "\n".join(lines)
    yield from apart


def sentences(first: int, text: str) -> Iterator[tuple[int, str]]:
    """Yield the sentences of a text that begins in a line, each with the number of its line."""
    start = first
    block: list[str] = []
    for number, line in enumerate([*text.splitlines(), ""], first):
        other = bool(block) and line.strip() and _is_apart(block[-1], line)
        if (other or _BEGINS.match(line)) and block:
            yield from _split(start, block)
            block = []
        if line.strip():
            start = start if block else number
            block.append(line)


def _is_apart(before: str, line: str) -> bool:
    """Return whether a line has another indentation than the one before, and continues no item."""
    indents = [len(x) - len(x.lstrip()) for x in (before, line)]
    is_item = _ITEM.match(before) and indents[1] > indents[0]
    # The first line of a docstring stands beside its quotation marks.
    return indents[0] != indents[1] and not is_item


def _split(start: int, block: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the sentences of lines that belong together."""
    text = _LEFT_OUT.sub(lambda match: match[1] or "X", " ".join(line.strip() for line in block))
    for sentence in _ENDS.split(text):
        words = sentence.split()[:3]
        row = next((i for i, line in enumerate(block) if words and words[0] in line), 0)
        yield start + row, sentence


def findings(path: Path) -> Iterator[Finding]:
    """Yield the sentences to rewrite in a file."""
    source, name = path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix()
    texts = {".py": python_texts, ".md": page_texts}.get(path.suffix, comment_texts)
    parts = list(texts(source))
    if name.startswith("gspcli/") and path.suffix == ".py":
        parts += message_texts(source)
    for first, text in parts:
        for line, sentence in sentences(first, text):
            if any(name.startswith(begin) and piece in sentence for begin, piece in EXCEPTIONS):
                continue
            count = _count(sentence)
            if count > MOST_WORDS:
                yield Finding(name, line, f"{count} words", sentence)
            # A word alone is the name of a parameter.
            for banned, better in _BANNED if count > 1 else ():
                if found := banned.search(sentence):
                    yield Finding(name, line, f"{found[0]!r} (better: {better})", sentence)


def files(names: list[str]) -> Iterator[Path]:
    """Yield the files of folders and files that have sentences."""
    for name in names:
        path = ROOT / name
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        yield from (x for x in inside if x.suffix in _SOURCES and "node_modules" not in x.parts)


def main(names: list[str]) -> int:
    """Print the findings in files, or in all that are checked; return the exit code."""
    found = [finding for path in files(names or list(CHECKED)) for finding in findings(path)]
    for finding in found:
        print(finding)
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
