"""Tables laid out for a width: digits, folded headings and prose, columns left out, records."""

from __future__ import annotations

import math

import pytest

from gspcli.cli.render import _lines, folded, lay_out
from gspcli.cli.result import Field, Result, cell_text, column_texts
from gspcli.cli.streams import printable


def _drawn(table: Result, width: int) -> list[str]:
    return list(_lines(table, lay_out(table, width), width, bold=False))


def _numbers(*values: float) -> Result:
    return Result([Field("x", align="right", aligned=True)], [{"x": value} for value in values])


@pytest.mark.parametrize(
    ("values", "digits", "texts"),
    [
        ((12.3456789, -0.5), 6, ["12.3457", "-0.5000"]),
        ((12.3456789, -0.5), 4, ["12.35", "-0.50"]),
        ((0.1234567, -1e-9), 6, ["0.123457", "0.000000"]),
        ((1.5e7, 2.25), 6, ["1.5e+07", "2.25"]),
        ((1.5e-7, -2.25e-8), 6, ["1.5e-07", "-2.25e-08"]),
        ((54321.9876, 1.0), 6, ["54321.99", "1.00"]),
        ((0.0, -0.0), 6, ["0", "0"]),
        ((1.0, math.inf), 6, None),
    ],
)
def test_points_stand_under_each_other(
    values: tuple[float, ...], digits: int, texts: list[str] | None
) -> None:
    table = _numbers(*values)
    found = column_texts(table, table.columns[0], digits)
    assert found == (texts or ["1", "inf"])


def test_so_many_decimals_as_were_asked_for_at_any_width() -> None:
    column = Field("x", decimals=9, align="right", essential=True)
    table = Result([column, column], [{"x": 1 / 3}])
    assert _drawn(table, 200)[-1] == "0.333333333  0.333333333"
    assert _drawn(table, 20) == ["x 0.333333333", "x 0.333333333"]


def test_digits_go_before_records_are_made() -> None:
    columns = [Field(k, align="right", essential=True, aligned=True) for k in "abc"]
    table = Result(columns, [dict.fromkeys("abc", -math.pi)])
    assert _drawn(table, 28)[-1] == "-3.14159  -3.14159  -3.14159"
    assert _drawn(table, 27)[-1] == "-3.1416  -3.1416  -3.1416"
    assert _drawn(table, 20)[-1] == "-3.14  -3.14  -3.14"
    assert _drawn(table, 18) == ["a -3.14159", "b -3.14159", "c -3.14159"]


def test_what_matters_least_goes_first() -> None:
    columns = [Field("aaaa", essential=True), *(Field(k * 4, minor=ord(k)) for k in "cbd")]
    table = Result(columns, [{}])
    kept = {}
    for width in (24, 17, 11, 5, 4):
        grid = lay_out(table, width)
        assert grid is not None
        kept[width] = "".join(column.key[0] for column in grid.columns)
    assert kept == {24: "acbd", 17: "acb", 11: "ab", 5: "a", 4: "a"}
    assert lay_out(table, 3) is None


def test_headings_and_prose_are_folded_at_blanks() -> None:
    table = Result(
        [Field("n", "how many", align="right"), Field("why", fold=" "), Field("l", fold=", ")],
        [
            {
                "n": 12,
                "why": "one two three four five six seven eight nine ten",
                "l": "a b, c d, e f",
            }
        ],
    )
    assert _drawn(table, 46) == [
        " how  why                        l",
        "many",
        "─" * 46,
        "  12  one two three four five    a b, c d, e f",
        "      six seven eight nine ten",
    ]
    lists = Result([Field("l", fold=", ")], [{"l": "a b, c d, e f"}])
    assert _drawn(lists, 10)[2:] == ["a b, c d,", "e f"]


def test_a_word_is_never_broken() -> None:
    assert folded("  a 1234567890 b", 6) == ["  a", "  1234567890", "  b"]
    assert folded("a, b c, d", 5, ", ") == ["a,", "b c,", "d"]
    assert folded("", 5) == [""]


def test_records_say_every_cell_that_is_not_empty() -> None:
    columns = [
        Field("x", align="right", essential=True),
        Field("empty"),
        Field("text", essential=True),
        Field("y", align="right"),
    ]
    rows = [{"x": 1.5, "text": "t" * 30, "y": 2}, {"x": -10.25, "text": "u", "y": 3}]
    assert _drawn(Result(columns, rows), 30) == [
        "x    1.5",
        "text:",
        "t" * 30,
        "y 2",
        "",
        "x -10.25",
        "text: u",
        "y 3",
    ]


def test_cells_for_people() -> None:
    assert [cell_text(v) for v in (None, True, 1 / 3, [1, 2.5], "a\nb")] == [
        "", "yes", "0.333333", "1 2.5", "a b",
    ]  # fmt: skip
    assert printable("a\x1b[2Jb\u202ec\nd") == "a\\x1b[2Jb\\u202ec\nd"
