from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

#: R = 1 meets the angles; the point is 3 and 4 from two planes and 13 from a point.
SPEC = """\
gsp: 1
units: {length: mm, angle: deg}
platform:
  O: {point: [0, 0, 0]}
  X: {line: {point: [0, 0, 0], direction: [2, 0, 0]}}
  Y: {line: {point: [0, 0, 0], direction: [0, 1, 0]}}
  Z: {line: {point: [0, 0, 0], direction: [0, 0, 1]}}
base:
  A: {line: {point: [0, 0, 0], direction: [3, 4, 0]}}
  B: {line: {point: [0, 0, 0], direction: [0, 3, 4]}}
  C: {line: {point: [0, 0, 0], direction: [4, 0, 3]}}
  E: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}
  F: {plane: {point: [0, 0, 0], normal: [0, 1, 0]}}
  Q: {point: [0, 0, 0]}
constraints:
  - {angle: [X, A], value: acos(3/5)*180/pi}
  - {angle: [Y, B], value: acos(3/5)*180/pi}
  - {angle: [Z, C], value: acos(3/5)*180/pi}
  - {distance: [O, E], value: 3, side: positive}
  - {distance: [O, F], value: 4, side: both}
  - {distance: [O, Q], value: 13}
"""
Files = Callable[..., tuple[str, str]]


@pytest.fixture
def files(tmp_path: Path) -> Files:
    def write(result: object, spec: str = SPEC) -> tuple[str, str]:
        paths = tmp_path / "spec.yaml", tmp_path / "poses.json"
        paths[0].write_text(spec)
        paths[1].write_text(result if isinstance(result, str) else json.dumps(result))
        return str(paths[0]), str(paths[1])

    return write


def pose(x: float, y: float, z: float, **more: object) -> dict[str, object]:
    return {"quaternion": [1, 0, 0, 0], "T": [x, y, z], **more}


GOOD = [pose(3, 4, 12, real=True), pose(3, -4, 12), pose(3, 4, -12), pose(3, -4, -12)]


def test_table(gsp: Callable, files: Files) -> None:
    run = gsp("certify", *files(GOOD[:2]))
    assert (run.code, run.err) == (0, "")
    lines = run.out.splitlines()
    assert lines[0] == (
        "2 poses: 2 certified, 2 of them proved pairwise different, 2 of these real"
    )
    assert lines[3].split()[:6] == ["no.", "outcome", "real", "same", "as", "residual"]
    assert lines[5].split()[:3] == ["1", "certified", "yes"]
    assert "4:positive 5:positive" in lines[5]
    assert "4:positive 5:negative" in lines[6]


#: A body of a millimetre in a room of kilometres: R = 1, T = (3, 4, 12) is a pose.
MIXED = """\
gsp: 1
units: {length: m, angle: deg}
platform:
  A: {point: [0.001, 0.002, 0]}
  B: {point: [0, -0.001, 0.003]}
  C: {point: [0.002, 0, 0.001]}
  D: {point: [-0.001, 0.001, 0.002]}
  E: {point: [0.003, -0.002, -0.001]}
  F: {point: [-0.002, 0.003, 0]}
base:
  a: {point: [1000, 0, 100]}
  b: {point: [-300, 900, 0]}
  c: {point: [0, 200, 800]}
  d: {point: [-700, -600, 10]}
  e: {point: [100, -800, 300]}
  f: {point: [500, 500, -900]}
constraints:
"""


def mixed() -> str:
    """Return MIXED with the distances at that pose, as roots of exact decimals."""
    rows = []
    for name in "ABCDEF":
        a, b = ([Fraction(x) for x in _point(MIXED, key)] for key in (name, name.lower()))
        squared = sum((x + t - y) ** 2 for x, t, y in zip(a, (3, 4, 12), b, strict=True))
        value = f"sqrt({squared.numerator}/{squared.denominator})"
        rows.append(f"  - {{distance: [{name}, {name.lower()}], value: {value}}}\n")
    return MIXED + "".join(rows)


def _point(text: str, name: str) -> list[str]:
    return text.split(f"  {name}: {{point: [")[1].split("]")[0].split(", ")


def test_the_tolerance_is_that_of_the_least_body(gsp: Callable, files: Files) -> None:
    run = gsp("certify", *files([pose(3, 4, 12)], mixed()))
    assert (run.code, run.err) == (0, "")
    nearness = run.out.splitlines()[1]
    assert nearness.startswith("certified poses are within ")
    assert nearness.endswith(" m in T")
    assert float(nearness.split()[-4]) < 1e-12
    # A thousandth of a metre is a millionth of the room, but all of the body.
    zeros = [[0.0] * 3] * 3
    for wrong in (
        pose(3.001, 4, 12),
        pose(3.000001, 4, 12),
        pose(3, 4, 12, R_imag=zeros, T_imag=[1e-4, 0, 0]),
    ):
        run = gsp("certify", *files([wrong], mixed()))
        assert run.code == 1
        assert "no solution is within the tolerance" in run.err
    document = gsp("certify", *files([pose(3, 4, 12)], mixed()), "--format", "json").out
    length, scale = (json.loads(document)[key] for key in ("least_length", "scale"))
    assert length == 2**-8  # next below the 5 mm of the body
    assert scale == 2048


def test_json(gsp: Callable, files: Files) -> None:
    run = gsp("certify", *files({"solutions": GOOD}), "--format", "json")
    document = json.loads(run.out)
    assert run.code == 0
    assert document["schema"] == "gsp.certify/1"
    assert document["type"]["id"] == "DPP DPH DPH ALL ALL ALL"
    assert document["counts"] == {"poses": 4, "certified": 4, "distinct": 4, "real": 4}
    first = document["solutions"][0]
    assert first["certified"] is first["real"] is first["claimed_real"] is True
    assert first["sides"] == {"4": "positive", "5": "positive"}
    assert first["residual_bound"] < 1e-13
    assert first["deviation"] < 1e-14


def test_digits(gsp: Callable, files: Files) -> None:
    arguments = files([pose(3, 0.5**0.5, 2)], SPEC.replace("value: 4", "value: sqrt(1/2)"))
    spec = Path(arguments[0])
    spec.write_text(spec.read_text().replace("value: 13", "value: sqrt(27/2)"))
    run = gsp("certify", *arguments, "--digits", "40", "--format", "csv")
    heading, row = run.out.splitlines()
    cells = dict(zip(heading.split(","), row.split(","), strict=True))
    assert cells["refined_Ty"] == "0.707106781186547524400844362104849039285"
    assert cells["refined_Tx"] == "3." + "0" * 39
    assert cells["refined_R11"] == "1." + "0" * 40
    table = gsp("certify", *arguments, "--digits", "5").out
    assert "Proved digits" in table
    assert "  1  Ty     0.7071\n" in table


@pytest.mark.parametrize(
    ("result", "code", "message"),
    [
        ([pose(3, 4, 12.1)], 1, "1 of 1: it is proved that no solution is within the tolerance"),
        ([pose(-3, 4, 12)], 1, "1 of 1: it is proved that no solution is within the tolerance"),
        ([*GOOD, GOOD[1]], 1, "1 of 5: the same solution as an earlier one"),
        ([pose(3, 4, 12, real=False)], 1, "1 of 1: said not to be real and is"),
    ],
)
def test_wrong_lists_fail(
    result: list, code: int, message: str, gsp: Callable, files: Files
) -> None:
    run = gsp("certify", *files(result))
    assert run.code == code
    assert run.err == f"error: some poses are wrong\n{message}\n"


def test_a_solution_said_to_be_real_is_not(gsp: Callable, files: Files) -> None:
    spec = SPEC.replace("value: 13", "value: 4")
    claim = pose(3, 4, 0, T_imag=[0, 0, 3], real=True)
    run = gsp("certify", *files([claim], spec))
    assert (run.code, run.err) == (
        1,
        "error: some poses are wrong\n1 of 1: said to be real and is not\n",
    )


def test_two_poses_on_both_sides_of_a_plane_that_doubles_do_not_tell_apart(
    gsp: Callable, files: Files
) -> None:
    spec = SPEC.replace("value: 4", "value: 1e-17")
    found = gsp("solve", files([], spec)[0], "--all", "--format", "json")
    solutions = json.loads(found.out)["solutions"]
    sides = [entry["sides"]["5"] for entry in solutions]
    assert all({*pair} == {"positive", "negative"} for pair in zip(*[iter(sides)] * 2, strict=True))
    assert solutions[0]["T"] == pytest.approx(solutions[1]["T"], abs=1e-16)
    assert gsp("certify", *files({"solutions": solutions}, spec)).code == 0
    csv = gsp("solve", files([], spec)[0], "--format", "csv").out
    assert gsp("certify", *files(csv, spec)).code == 0
    # Numbers near zero are written to 2^-64 lengths, which tells the sides.
    solutions[0]["sides"]["5"] = sides[1]
    spoilt = gsp("certify", *files({"solutions": solutions}, spec))
    assert spoilt.code == 1
    assert "1 of 32: said to be on the other side of a plane" in spoilt.err


def test_the_other_side_of_a_plane_is_wrong(gsp: Callable, files: Files) -> None:
    right = pose(3, 4, 12, sides={"4": "positive", "5": "positive"})
    assert gsp("certify", *files([right])).code == 0
    run = gsp("certify", *files([pose(3, 4, 12, sides={"5": "negative"})]))
    assert (run.code, run.err) == (
        1,
        "error: some poses are wrong\n1 of 1: said to be on the other side of a plane\n",
    )


def test_a_double_solution_cannot_be_certified(gsp: Callable, files: Files) -> None:
    run = gsp("certify", *files([pose(3, 4, 0)], SPEC.replace("value: 13", "value: 5")))
    assert run.code == 4
    assert run.err == (
        "error: some poses are not certified\n"
        "1 of 1: no simple, isolated solution could be proved nearby\n"
    )
    assert "not isolated" in run.out


def test_other_values_and_standard_input(
    gsp: Callable, files: Files, monkeypatch: pytest.MonkeyPatch
) -> None:
    import io
    import sys

    spec, _ = files([])
    stream = io.TextIOWrapper(io.BytesIO(b"1 0 0 0  3 4 0.5\n"))
    monkeypatch.setattr(sys, "stdin", stream)
    run = gsp("certify", spec, "-", "--set", "6=sqrt(101/4)", "--format", "csv")
    assert run.code == 0
    assert run.out.splitlines()[1].startswith("1,certified,true,")


def test_bad_input(gsp: Callable, files: Files) -> None:
    spec, result = files('[{"T": 1}]')
    assert gsp("certify", "-", "-").code == 2
    missing = gsp("certify", spec, "nowhere.json")
    assert (missing.code, missing.err) == (
        2,
        "error: nowhere.json: cannot be read: No such file or directory\n",
    )
    wrong = gsp("certify", spec, result)
    assert (wrong.code, wrong.out) == (2, "")
    assert wrong.err == f"error: {result}: [0]: T is not 3 finite numbers\n"


def test_help_names_the_exit_codes(gsp: Callable) -> None:
    text = gsp("certify", "--help").out
    assert "Examples:" in text
    assert "gsp certify platform.yaml poses.csv --max-deviation 1e-3" in text


@pytest.mark.parametrize("digits", [400, 5000])
def test_integers_of_any_length_are_numbers_that_are_too_large(
    gsp: Callable, files: Files, digits: int
) -> None:
    text = json.dumps({"solutions": [pose(3, 4, 12)]}).replace("12", "9" * digits)
    spec, result = files(text)
    for run in (gsp("certify", spec, result), gsp("measure", spec, result)):
        assert run.code == 2
        assert "3 finite numbers" in run.err


def test_lists_in_lists_without_end(gsp: Callable, files: Files) -> None:
    spec, result = files("[" * 100_000)
    assert gsp("certify", spec, result).code == 2
