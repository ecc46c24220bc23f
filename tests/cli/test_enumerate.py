"""`gsp enumerate`: filters, sorting, counts, formats."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from itertools import pairwise

import pytest

from gspcli.catalogue.listing import COLUMNS, DEFAULT_COLUMNS, TypeList

Run = Callable[..., object]
HEADER = (
    "number,id,class,distances,angles,theorem_5_2,theorem_5_3,theorem_5_4,table_3,"
    "refined_one_sided,refined_two_sided,generic_one_sided,generic_two_sided"
)


def _rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_the_whole_catalogue_as_csv(gsp: Run) -> None:
    outcome = gsp("enumerate", "--format", "csv")
    assert outcome.code == 0
    assert outcome.err == ""
    assert outcome.out.startswith(HEADER)
    rows = _rows(outcome.out)
    assert [int(row["number"]) for row in rows] == list(range(1, 3851))
    assert {len(row["id"].split()) for row in rows} == {6}
    for row in rows:
        for sides in ("one_sided", "two_sided"):
            assert int(row[f"generic_{sides}"]) <= int(row[f"refined_{sides}"])
    # Table 3 is for 3D3A alone, Theorem 5.4 for DPH and angles alone.
    assert all(bool(row["table_3"]) is (row["class"] == "3D3A") for row in rows)
    planar = [row for row in rows if row["theorem_5_4"]]
    assert len(planar) == 35
    assert all(set(row["distances"].split()) == {"PH"} for row in planar)


def test_counts_beside_the_binomials(gsp: Run) -> None:
    counted = json.loads(gsp("enumerate", "--by-class", "--format", "json").out)["classes"]
    by_class = {row["class"]: (row["types"], row["selected"]) for row in counted}
    assert by_class == {
        "3D3A": (1120, 1120),
        "4D2A": (1260, 1260),
        "5D1A": (1008, 1008),
        "6D": (462, 462),
        "all": (3850, 3850),
    }
    assert counted[0]["formula"] == "C(6,3) · C(8,3) = 20 · 56"


@pytest.mark.parametrize(
    ("arguments", "count"),
    [
        (["--class", "6D"], 462),
        (["--class", "6D", "--class", "3d3a"], 1582),
        (["--only", "PH", "A"], 35),
        (["--only", "PH,A"], 35),
        (["--only", "PH A", "--class", "6D"], 1),
        (["--only", "A"], 0),
        (["--only", "D"], 462),
        (["--with", "PP,PL,LP,PH,HP,DLL"], 1),
        (["--with", "ALL", "ALH", "AHL"], 56),
        (["--without", "D"], 0),
        (["--without", "LL", "LH", "HL", "HH"], 210),
        (["--max-refined-two-sided", "0"], 0),
        (["--first", "7"], 7),
        (["--first", "0"], 0),
    ],
)
def test_filters(gsp: Run, arguments: list[str], count: int) -> None:
    assert len(_rows(gsp("enumerate", *arguments, "--format", "csv").out)) == count


def test_ceilings_drop_types_without_a_value(gsp: Run) -> None:
    rows = _rows(gsp("enumerate", "--max-table-3", "16", "--format", "csv").out)
    assert rows
    assert all(0 < int(row["table_3"]) <= 16 for row in rows)
    others = _rows(gsp("enumerate", "--class", "3D3A", "--format", "csv").out)
    assert len(rows) == sum(int(row["table_3"]) <= 16 for row in others)


def test_sorting_and_columns(gsp: Run) -> None:
    outcome = gsp(
        "enumerate", "--sort", "-theorem_5_3,number", "--columns", "theorem-5-3", "number",
        "--format", "csv",
    )  # fmt: skip
    assert outcome.out.startswith("theorem_5_3,number\n")
    keys = [(-int(row["theorem_5_3"]), int(row["number"])) for row in _rows(outcome.out)]
    assert all(a < b for a, b in pairwise(keys))
    last = _rows(gsp("enumerate", "--sort", "theorem_5_4", "--format", "csv").out)[-1]
    assert last["theorem_5_4"] == ""


@pytest.mark.parametrize("fmt", ["table", "markdown", "latex", "json"])
def test_every_format_has_every_row(gsp: Run, fmt: str) -> None:
    shown = gsp("enumerate", "--class", "6D", "--first", "5", "--format", fmt).out
    assert all(str(number) in shown for number in range(3389, 3394))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--class", "7D"], "unknown class"),
        (["--only", "PX"], "unknown constraint"),
        (["--sort", "colour"], "unknown column 'colour': the columns are number, id"),
        (["--coincident", "PP"], "a platform has six"),
        (["-o", "types.xyz"], "use --format, or one of .csv, .json"),
    ],
)
def test_mistakes_are_named(gsp: Run, arguments: list[str], message: str) -> None:
    outcome = gsp("enumerate", *arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert message in outcome.err


def test_sharing_is_counted_and_listed(gsp: Run) -> None:
    counted = {
        row["class"]: int(row["patterns"])
        for row in json.loads(gsp("enumerate", "--coincident", "--format", "json").out)["classes"]
    }
    assert counted.pop("all") == sum(counted.values())
    listed = _rows(gsp("enumerate", "--coincident", "6PP", "--format", "csv").out)
    only = json.loads(gsp("enumerate", "--only", "PP", "--coincident", "--format", "json").out)[
        "classes"
    ]
    assert len(listed) == len({row["pattern"] for row in listed}) == only[-1]["patterns"]


def test_a_type_list_is_a_sequence_and_a_frame() -> None:
    types = TypeList()
    assert len(types) == 3850
    assert types[:3][2] == types[2]
    frame = types.where(at_most={"refined_two_sided": 16}).to_frame()
    assert list(frame.columns) == [column.key for column in DEFAULT_COLUMNS[1:]]
    assert (frame["refined_two_sided"] <= 16).all()
    assert TypeList().to_frame()["theorem_5_4"].count() == 35


def test_columns_with_gaps_are_integers_in_pandas(gsp, tmp_path) -> None:
    import pandas as pd

    path = tmp_path / "types.csv"
    assert gsp("enumerate", "--format", "csv", "-o", path).code == 0
    read = pd.read_csv(path, dtype_backend="numpy_nullable")
    frame = TypeList().to_frame()
    for key in ("theorem_5_4", "table_3", "best_real"):
        assert str(frame[key].dtype) == str(read[key].dtype) == "Int64"
        assert frame[key].tolist() == read[key].tolist()


def test_patterns_are_a_column_on_request() -> None:
    key = COLUMNS[-1].key
    assert key == "patterns"
    row = next(TypeList()[-1:].rows(COLUMNS))
    assert isinstance(row["patterns"], int)


def test_a_count_says_that_it_is_filtered(gsp) -> None:
    run = gsp("enumerate", "--max-table-3", "8", "--by-class")
    assert run.out.splitlines()[0].split()[-1] == "selected"
    assert run.out.splitlines()[-1] == "200 of 3850 types, as the options select them"
    run = gsp("enumerate", "--by-class")
    assert run.out.splitlines()[0].split()[-1] == "enumerated"
    assert "select" not in run.out


def test_a_note_where_table_3_counts_one_orientation(gsp) -> None:
    note = "Table 3 counts one orientation of each DLL; all other columns count both"
    assert note in gsp("enumerate", "--class", "3D3A", "--with", "DLL").out
    for others in (("--without", "DLL"), ("--class", "6D"), ("--columns", "id,generic_one_sided")):
        assert note not in gsp("enumerate", *others).out
