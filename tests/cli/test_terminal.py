"""Every command at every width in a pseudo-terminal: no number is cut, no line too wide."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from rich.cells import cell_len

from tools.build.samples import choices, described, samples, words

WIDTHS = [40, 48, 60, 72, 80, 96, 100, 120, 140, 160, 180, 200]
#: Treated as no terminal: everything in its full width.
_UNLIMITED = 50_000
Shown = Callable[..., tuple[list[str], int]]
EXAMPLES = "data/examples"
#: What is tested besides a sample of each command that prints tables and is not here.
CALLS = [
    ["enumerate", "--first", "4"],
    ["enumerate", "--by-class"],
    ["enumerate", "--coincident", "--only", "PP"],
    ["enumerate", "--coincident", "6PP", "--first", "4"],
    ["show", "421"],
    ["bound", "421"],
    ["bound", "3D3A PL PL LP"],
    ["constraint"],
    ["constraint", "DLL"],
    ["realize", "DPL DPL DLP ALL ALH AHH"],
    ["table", "1"],
    ["table", "2"],
    ["table", "3"],
    ["table", "errata"],
    ["derive"],
    ["atlas", "summary"],
    ["check", f"{EXAMPLES}/dietmaier.yaml", f"{EXAMPLES}/example-6.8.yaml"],
    ["solve", f"{EXAMPLES}/example-6.8.yaml"],
    ["solve", f"{EXAMPLES}/dietmaier.yaml", "--all"],
    ["solve", f"{EXAMPLES}/dietmaier.yaml", "--digits", "20"],
    ["solve", "@dietmaier", "--rotation", "matrix", "--legend"],
    [
        "solve",
        "@dietmaier",
        "--rotation",
        "ZYX",
        "--near",
        "0,0,0,0,0,0",
        "--euler",
        "ZYX",
        "--decimals",
        "9",
    ],
    ["solve", "@no-real-pose"],
    ["solve", "@parallel-edges"],
    ["example"],
    ["count", "@planar-hexagons", "@example-6.8"],
    ["count", "--type", "6PP", "--geometry", "generic,3-3"],
    ["analyze", "@rubin-m2"],
    ["analyze", "@octahedral-3-3", "--mode", "1", "--load", "0,0,-9.81", "--tolerance", "0.001"],
    ["dynamics", "MASSES", "--mode", "15"],
    ["dynamics", "MASSES", "--mode", "1", "--modes"],
    ["clearance", "@octahedral-3-3", "--mode", "1"],
    ["clearance", "@octahedral-3-3", "--mode", "1", "--of", "pose"],
    ["sensors", "@rubin-m2"],
    ["sensors", "@simscape-hexapod"],
    ["solve", "@rubin-m2", "--reading", "leg P1 B2 = 2.913 ± 0.002"],
    ["workspace", "@workspace-study", "--shift", "z=0:10:2"],
    ["workspace", "@workspace-study", "--over", "x,z"],
    ["workspace", "@workspace-study", "--over", "x,z", "--boxes", "--gap", "0.9"],
    ["scan", "@octahedral-3-3", "--vary", "1=1.4:1.6:5"],
    ["measure", "@dietmaier", "--pose", "0.1,0.2,1.5,1,0.1,0,0"],
    ["sample", "3D3A PH PH PH", "--count", "20", "--jobs", "1"],
]
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]\d+)?(?![\w.])")
_FEWEST_DIGITS = 3


def _others() -> Iterator[list[str]]:
    """Yield a call of each command that is not in `CALLS`; its files have names in capitals."""
    known = {call[0] for call in CALLS}
    for name, command in described().items():
        if "table" in choices(command, "format") and name.split()[0] not in known:
            yield [name, *shlex.split(samples(name, command)[0])]


@pytest.mark.parametrize("call", [*CALLS, *_others()], ids=" ".join)
def test_no_number_is_cut_at_any_width(shown: Shown, call: list[str], tmp_path: Path) -> None:
    run = words(call[0], shlex.join(call[1:]), tmp_path)
    (*pages, whole, _), code = shown(*run, widths=[*WIDTHS, _UNLIMITED])
    assert code in (0, 1, 4)
    # Home is said once, with the first page.
    full = set(_NUMBER.findall(whole + pages[0].partition("home is mode")[2][:4]))
    rounded = sorted(map(float, full))
    for width, page in zip(WIDTHS, pages, strict=True):
        assert page.count("…") <= whole.count("…")
        for number in set(_NUMBER.findall(page)) - full:
            assert _is_rounded(number, rounded), f"{number} at {width} columns"
        for line in page.splitlines():
            assert cell_len(line) <= width or " " not in line.strip(), f"{width}: {line}"


def _is_rounded(text: str, known: list[float]) -> bool:
    """Return whether a number is one of those known, to fewer digits."""
    mantissa, _, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    half = 0.5001 * 10.0 ** (int(exponent or 0) - decimals)
    significant = len(mantissa.replace(".", "").lstrip("-0"))
    near = any(abs(float(text) - value) <= half for value in known)
    return near and (significant >= _FEWEST_DIGITS or decimals > 0 or not known)


@pytest.mark.parametrize("width", [60, 80, 120])
def test_help_fits(shown: Shown, width: int) -> None:
    (page,), code = shown("--help", widths=[width])
    assert code == 0
    assert max(map(cell_len, page.splitlines())) <= width


def test_wider_terminals_show_no_less(shown: Shown) -> None:
    (*pages, _), _ = shown("enumerate", "--first", "2", widths=WIDTHS[2:])
    left_out = [page.partition("(left out")[2].count(",") for page in pages]
    assert all(a >= b for a, b in pairwise(left_out))
    assert left_out[0] > left_out[-1]


def test_the_bounds_of_the_paper_stay_longest(shown: Shown) -> None:
    (*pages, _), _ = shown("enumerate", "--first", "2", widths=[60, 80])
    for page in pages:
        heading = " ".join(page.splitlines()[:3])
        assert heading.count("Thm") == 3
        assert "Table" in heading
        assert "refined" in page.split("(left out")[1]


def test_colour_of_errors(shown: Shown) -> None:
    (coloured,), _ = shown("show", "9999", widths=[80], styled=True)
    assert "\x1b[31m" in coloured
    for setting in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        for call in (["show", "9999"], ["bound", "1"]):
            pages, _ = shown(*call, widths=[80], environment=setting, styled=True)
            assert "\x1b" not in "".join(pages)


def test_what_a_terminal_would_obey_is_written_out(shown: Shown) -> None:
    pages, code = shown("check", "\x1b[2Jbad\x07.yaml", widths=[80], styled=True)
    assert code == 2
    assert "\x1b[2J" not in "".join(pages)
    assert "\\x1b[2Jbad\\x07.yaml" in pages[0]


def test_derived_equations_fit_the_terminal(monkeypatch):
    from gspcli.cli.render import folded_lines
    from gspcli.symbolic.derivation import derive

    text = str(derive("psc"))
    for width in (60, 80, 120, 200):
        monkeypatch.setenv("COLUMNS", str(width))
        shown = folded_lines(text)
        assert max(map(len, shown.splitlines())) <= width
        assert shown.split() == text.split()
    assert folded_lines(text) == text


def test_remarks_stay_where_fewer_digits_make_room():
    from gspcli.cli.render import lay_out
    from gspcli.cli.result import Field, Result

    numbers = [Field(key, align="right", essential=True) for key in "abc"]
    row = {"a": 0.123456, "b": 0.123456, "c": 0.123456, "d": 1.5, "e": "home"}
    columns = [*numbers, Field("d", minor=2), Field("e", minor=-1)]
    table = Result(columns, [row])

    def shown(width):
        return [column.key for column in lay_out(table, width).columns]

    assert [shown(width) for width in (40, 34, 30, 26)] == [
        list("abcde"), list("abce"), list("abce"), list("abc"),
    ]  # fmt: skip
