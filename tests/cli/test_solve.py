"""`gsp solve`."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest
import yaml
from scipy.spatial.transform import Rotation

from gspcli.resources import instance_files

EXAMPLE = str(Path(__file__).parents[2] / "data" / "examples" / "example-6.8.yaml")

SMALL = """\
gsp: 1
name: three planes
units: {length: m, angle: deg}
platform:
  P: {point: [0, 0, 0]}
  X: {line: {point: [0, 0, 0], direction: [1, 0, 0]}}
  Y: {line: {point: [0, 0, 0], direction: [0, 1, 0]}}
  Z: {line: {point: [0, 0, 0], direction: [0, 0, 1]}}
base:
  x: {line: {point: [0, 0, 0], direction: [1, 0, 0]}}
  y: {line: {point: [0, 0, 0], direction: [0, 1, 0]}}
  z: {line: {point: [0, 0, 0], direction: [0, 0, 1]}}
  H: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}
  K: {plane: {point: [0, 0, 0], normal: [0, 1, 0]}}
  M: {plane: {point: [0, 0, 0], normal: [NORMAL]}}
constraints:
  - {distance: [P, H], value: 1, side: positive}
  - {distance: [P, K], value: 2, side: negative}
  - {distance: [P, M], value: 3, side: SIDE}
  - {angle: [X, x], value: 60}
  - {angle: [Y, y], value: 60}
  - {angle: [Z, z], value: ANGLE}
"""


@pytest.fixture
def spec(tmp_path):
    def write(normal="0, 0, 1", side="positive", angle="60"):
        text = SMALL.replace("NORMAL", normal).replace("SIDE", side).replace("ANGLE", angle)
        path = tmp_path / "spec.yaml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def test_example_6_8_prints_all_64_poses(gsp):
    run = gsp("solve", EXAMPLE)
    assert run.code == 0
    assert run.err == ""
    lines = run.out.splitlines()
    assert lines[:4] == [
        "Example 6.8: DPL DPL DPL ALL ALL ALL",
        "",
        "64 real poses, each proved, all different",
        "complete, proved: all 64 solutions of the type found, all real",
    ]
    # The orientations, eight, and the positions in each.
    assert lines[5].split() == ["orientation", "qw", "qx", "qy", "qz", "positions"]
    assert [line.split()[0] for line in lines[7:15]] == list("ABCDEFGH")
    assert {line.split()[-1] for line in lines[7:15]} == {"8"}
    assert [line.split()[:2] for line in lines[18:-3]] == [
        [str(n), "ABCDEFGH"[(n - 1) // 8]] for n in range(1, 65)
    ]
    assert "; condition 4.09 at every pose" in lines[-2]
    home = "home is mode 2: the least turned of 64 real poses (no home is stated)"
    assert lines[-1] == f"{home}, the highest of 64 alike"


def test_table_of_a_small_platform(gsp, spec):
    run = gsp("solve", spec())
    lines = [" ".join(line.split()) for line in run.out.splitlines()]
    assert lines[3] == "complete, proved: all 8 solutions of the type found, all real"
    assert lines[5] == "no. Tx [m] Ty [m] Tz [m] qw qx qy qz condition remarks"
    row = lines[7].split()
    assert row[:4] == ["1", "1.00000", "-2.00000", "3.00000"]
    assert row[4:8] == ["0.790569", "-0.353553", "-0.353553", "-0.353553"]


def test_sides_that_are_left_open_are_shown_as_signs(gsp, spec):
    lines = gsp("solve", spec(side="both")).out.splitlines()
    assert "sides 1,2,3" in lines[2 + 3 + 2 + 8 + 1]
    shown = {line.split()[5] for line in lines[18:] if line[:3].strip().isdigit()}
    assert shown == {"+-+", "+--"}


def test_csv_has_full_precision(gsp):
    run = gsp("solve", EXAMPLE, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(run.out)))
    assert len(rows) == 64
    for row in rows:
        assert float(row["Tx"]) ** 2 + float(row["Ty"]) ** 2 == pytest.approx(36, rel=1e-14)
        assert float(row["residual"]) < 1e-12
        # Three angles are proved where that costs nothing to speak of.
        assert row["certified"] == "true"
        assert row["multiplicity"] == "1"


def test_json_document(gsp):
    document = json.loads(gsp("solve", EXAMPLE, "--format", "json").out)
    assert document["schema"] == "gsp.solve/1"
    assert document["verdict"] == "complete"
    assert document["counts"]["real"] == document["counts"]["certified"] == 64
    assert len(document["solutions"]) == 64


def test_set_changes_values(gsp):
    run = gsp("solve", EXAMPLE, "--set", "4=sqrt(50)", "--set", "5=1", "--format", "json")
    assert run.code == 0
    document = json.loads(run.out)
    assert document["counts"]["found"] == 64
    assert document["solutions"] == []


def test_all_shows_poses_that_are_not_real(gsp):
    run = gsp("solve", EXAMPLE, "--set", "4=sqrt(50)", "--all", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(run.out)))
    assert len(rows) == 64
    assert {row["real"] for row in rows} == {"false"}
    assert any(abs(float(row["Tx_imag"])) + abs(float(row["Tz_imag"])) > 1 for row in rows)


def test_standard_input(gsp, spec, monkeypatch):
    text = Path(spec()).read_bytes()
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text)))
    run = gsp("solve", "-", "--format", "csv")
    assert run.code == 0
    assert len(run.out.splitlines()) == 9


def test_an_infinite_set_has_exit_code_3(gsp, spec):
    run = gsp("solve", spec(normal="1, 0, 0").replace("value: 3", "value: 1"), "--set", "3=1")
    assert run.code == 3
    assert "no isolated real pose\ninfinite, proved: infinitely many solutions" in run.out
    assert run.err.startswith("error: the poses are infinitely many: the platform can move")


def test_a_coupling_that_holds_though_the_poses_are_infinitely_many(gsp):
    run = gsp("solve", "@three-vee-250mm")
    assert run.code == 3
    assert (
        "\nthe platform cannot move from these real poses: the infinitely many others are another "
        "component, apart from them\n"
    ) in run.out
    assert run.err == (
        "error: the poses are infinitely many in another component; from the isolated real ones "
        "the platform cannot move\n"
        "(numerical evidence: that component has local dimension 1; --format json has a sample)\n"
    )


def test_solutions_have_numbers(gsp):
    document = json.loads(gsp("solve", "@figure-3", "--all", "--format", "json").out)
    assert [one["number"] for one in document["solutions"]] == [1, 2, 3, 4]
    T = document["solutions"][2]["T"]
    near = ",".join(map(repr, [*T, *document["solutions"][2]["quaternion"]]))
    document = json.loads(gsp("solve", "@figure-3", "--near", near, "--format", "json").out)
    assert document["solutions"][0]["number"] == 3


def test_json_of_an_infinite_set_has_sample_motions(gsp, spec):
    run = gsp("solve", spec(normal="1, 0, 0"), "--set", "3=1", "--format", "json")
    motion = json.loads(run.out)["motions"][0]
    assert motion["dimension"] == 1
    assert motion["real"] is True
    assert len(motion["T"]) > 2


def test_parallel_planes_without_a_pose_are_an_answer(gsp, spec):
    run = gsp("solve", spec(normal="1, 0, 0"))
    assert run.code == 0
    assert run.out.splitlines()[2:5] == [
        "no real pose",
        "complete, proved (wrong at most once in 10^15): no solution "
        "(most platforms of this type with these sides have 8)",
        "distances 1 and 3 contradict each other: no pose was found for them without the others",
    ]


def test_multiple_poses_are_proved_by_their_counts(gsp, spec):
    path = spec(angle="0")
    settings = ("--set", "4=0", "--set", "5=0")
    run = gsp("solve", path, *settings)
    assert run.code == 0
    assert "1 solution found, 1 real, 8 with multiplicity, all of the type's 8" in run.out
    assert "the random prime of the exact count" in run.out
    run = gsp("solve", path, *settings, "--no-prove")
    assert run.code == 4
    assert "try --prove" in run.err


def test_both_sides_double_the_paths(gsp, spec):
    document = json.loads(gsp("solve", spec(side="both"), "--format", "json").out)
    assert document["expected"] == 16
    sides = [solution["sides"]["3"] for solution in document["solutions"]]
    assert sorted(set(sides)) == ["negative", "positive"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.yaml"], "cannot be read"),
        ([EXAMPLE, "--set", "7=1"], "expected a number from 1 to 6"),
        ([EXAMPLE, "--set", "4=-1"], "--set"),
        ([EXAMPLE, "--format", "pdf"], "pdf"),
    ],
)
def test_mistakes_have_exit_code_2(gsp, arguments, message):
    run = gsp("solve", *arguments)
    assert run.code == 2
    assert run.out == ""
    assert message in run.err


def test_output_file(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    run = gsp("solve", EXAMPLE, "-o", str(path))
    assert run.out == ""
    assert len(path.read_text(encoding="utf-8").splitlines()) == 65


def test_the_same_command_gives_the_same_bytes(gsp):
    first, second = (gsp("solve", EXAMPLE, "--format", "json", "--seed", s).out for s in "12")
    assert first.replace('"seed": 1', '"seed": 2') == second


def test_the_constraints_that_contradict_each_other_are_named(gsp):
    run = gsp("solve", EXAMPLE, "--set", "4=sqrt(50)", "--set", "5=1")
    assert "distances 4, 5 and 6 contradict each other" in run.out
    assert "--all shows the 64 complex solutions, too" in run.out
    document = json.loads(
        gsp("solve", EXAMPLE, "--set", "4=sqrt(50)", "--set", "5=1", "--format", "json").out
    )
    assert document["contradicting"] == [4, 5, 6]


def test_the_verdict_of_a_csv_goes_to_stderr(gsp):
    run = gsp("solve", EXAMPLE, "--format", "csv")
    assert run.err == (
        "64 real poses, each proved, all different\n"
        "complete, proved: all 64 solutions of the type found, all real\n"
    )


@pytest.mark.parametrize("form", ["matrix", "rotvec", "ZYX", "xyz", "yxz"])
def test_rotations_in_other_forms_are_those_of_the_quaternions(gsp, form):
    quaternions = csv.DictReader(io.StringIO(gsp("solve", "@dietmaier", "--format", "csv").out))
    run = gsp("solve", "@dietmaier", "--rotation", form, "--format", "csv")
    for row, other in zip(csv.DictReader(io.StringIO(run.out)), quaternions, strict=True):
        q = [float(other[key]) for key in ("qw", "qx", "qy", "qz")]
        expected = Rotation.from_quat(q, scalar_first=True)
        if form == "matrix":
            R = [[float(row[f"r{i}{j}"]) for j in "123"] for i in "123"]
            found = Rotation.from_matrix(R)
        elif form == "rotvec":
            vector = [float(row[f"rotvec_{axis}"]) for axis in "xyz"]
            found = Rotation.from_rotvec(vector, degrees=True)
        else:
            angles = [float(row[f"r{axis}"]) for axis in form.lower()]
            found = Rotation.from_euler(form, angles, degrees=True)
        assert (found * expected.inv()).magnitude() < 1e-9


def test_near_sorts_by_distance_and_marks_the_nearest(gsp, tmp_path):
    rows = list(csv.DictReader(io.StringIO(gsp("solve", "@dietmaier", "--format", "csv").out)))
    keys = ("Tx", "Ty", "Tz", "qw", "qx", "qy", "qz")
    goal = ",".join(rows[6][key] for key in keys)
    run = gsp("solve", "@dietmaier", "--near", goal, "--format", "csv")
    near = list(csv.DictReader(io.StringIO(run.out)))
    assert near[0]["number"] == "7"
    assert float(near[0]["distance"]) == pytest.approx(0, abs=1e-12)
    assert float(near[0]["turn"]) == pytest.approx(0, abs=1e-6)
    assert len(near) == 40
    file = tmp_path / "pose.csv"
    file.write_text(",".join(keys) + "\n" + goal + "\n")
    lines = gsp("solve", "@dietmaier", "--near", f"@{file}").out.splitlines()
    assert [line.split()[0] for line in lines if line.endswith("nearest")] == ["7"]


def test_decimals(gsp):
    out = gsp("solve", "@dietmaier", "--decimals", "3").out
    assert all(len(word.partition(".")[2]) == 3 for word in out.splitlines()[7].split()[1:8])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rotation", "zzz"], "expected three different axes"),
        (["--rotation", "ZYX", "--all"], "leave out --all"),
        (["--near", "0,0,0,0,0,0"], "say it with --euler, such as ZYX"),
        (["--euler", "ZYX"], "--euler is for --near or --where"),
        (["--near", "0,0"], "--near: found 2 numbers"),
    ],
)
def test_rotations_and_poses_that_cannot_be_read(gsp, arguments, message):
    run = gsp("solve", EXAMPLE, *arguments)
    assert (run.code, run.out) == (2, "")
    assert message in run.err


def test_poses_that_the_machine_cannot_take_are_told(gsp):
    run = gsp("solve", "@workspace-study-cones")
    assert run.code == 0
    assert "a leg leaves the cone of a joint in poses" in run.out
    assert "outside its range" not in run.out
    run = gsp("solve", "@workspace-study", "--set", "2=521")
    assert "constraint 2 is outside its range: the machine can take none of these" in run.out
    run = gsp("solve", "@workspace-study-cones", "--set", "6=79", "--format", "json")
    poses = json.loads(run.out)["solutions"]
    beyond = {"kind": "range", "constraint": 6, "body": None}
    assert all(pose["limits"][0] == beyond for pose in poses)
    (kept,) = (pose for pose in poses if pose["limits"] == [beyond])
    assert kept["T"] == pytest.approx([-3.218, -5.895, 56.166], abs=1e-3)
    assert {one["body"] for pose in poses for one in pose["limits"][1:]} == {"base", "platform"}
    assert "limits" not in gsp("solve", "@dietmaier", "--format", "json").out


def test_lines_that_touch_are_counted_once_in_both_numbers(gsp):
    """Each solution was counted twice for each of them in the geometry's number only."""
    words = [word for k in (4, 5, 6) for word in ("--set", f"{k}=0")]
    run = gsp("solve", "@parallel-edges", *words)
    assert (
        "all 32 solutions of this geometry found, 6 real and 26 complex (most platforms of this"
        in run.out
    )
    document = json.loads(gsp("solve", "@parallel-edges", *words, "--format", "json").out)
    assert document["geometry_count"] == 32


# `gsp solve --digits`: every printed digit is proved.


Run = Callable[..., object]
SPEC = "data/examples/octahedral-3-3.yaml"


def test_digits_in_every_format(gsp: Run) -> None:
    document = json.loads(gsp("solve", SPEC, "--digits", "40", "--format", "json").out)
    rows = list(csv.DictReader(io.StringIO(
        gsp("solve", SPEC, "--digits", "40", "--format", "csv").out
    )))  # fmt: skip
    for entry, row in zip(document["solutions"], rows, strict=True):
        assert [row[f"refined_T{axis}"] for axis in "xyz"] == entry["refined"]["T"]
        for digits, rounded in zip(entry["refined"]["T"], entry["T"], strict=True):
            assert abs(Fraction(digits) - Fraction(rounded)) < Fraction(1, 10**9)
    assert "Proved digits" in gsp("solve", SPEC, "--digits", "5").out


def test_refined_rotations_are_orthogonal_to_the_last_digit(gsp: Run) -> None:
    document = json.loads(gsp("solve", SPEC, "--digits", "60", "--format", "json").out)
    for entry in document["solutions"]:
        rows = [[Fraction(x) for x in row] for row in entry["refined"]["R"]]
        for i in range(3):
            for j in range(3):
                product = sum(a * b for a, b in zip(rows[i], rows[j], strict=True))
                assert abs(product - (i == j)) < Fraction(1, 10**58)


def test_jobs_do_not_change_the_answer(gsp: Run) -> None:
    one = gsp("solve", SPEC, "--all", "--format", "csv").out
    for jobs in ("2", "256"):
        assert one == gsp("solve", SPEC, "--all", "--format", "csv", "--jobs", jobs).out


def test_more_digits_than_python_converts(gsp: Run, tmp_path: Path) -> None:
    """Python refuses to write integers of more than 4300 digits."""
    path = tmp_path / "poses.json"
    gsp("solve", SPEC, "--digits", "4310", "-o", str(path))
    (first, *_) = json.loads(path.read_text())["solutions"]
    assert all(len(text) > 4310 for row in first["refined"]["R"] for text in row)
    proved = gsp("certify", SPEC, str(path), "--digits", "4310", "--format", "json")
    assert proved.code == 0
    assert first["refined"]["T"][0] in proved.out


# `gsp solve` of many instances: an answer for each, in their order, even if one fails.


NAMES = ["octahedral-3-3", "griffis-duffy", "no-real-pose", "octahedral-3-3"]


def lines_of(names):
    texts = [instance_files()[name].read_text(encoding="utf-8") for name in names]
    return "".join(json.dumps(yaml.safe_load(text)) + "\n" for text in texts)


@pytest.fixture
def instances(tmp_path):
    path = tmp_path / "instances.jsonl"
    path.write_text(lines_of(NAMES), encoding="utf-8")
    return path


def answers(run):
    return [json.loads(line) for line in run.out.splitlines()]


def test_a_row_for_each_file(gsp):
    run = gsp("solve", *(f"@{name}" for name in NAMES), "--format", "csv")
    rows = [row[:1] + row[3:8] for row in csv.reader(run.out.splitlines())]
    assert run.code == 3
    assert [row[0] for row in rows[1:]] == [f"@{name}" for name in NAMES]
    assert rows[1] == rows[4] == ["@octahedral-3-3", "4", "16", "16", "complete", "0"]
    assert rows[2][4:] == ["infinite", "3"]
    assert rows[3][1:] == ["0", "40", "40", "complete", "0"]


def test_a_document_in_each_line_is_that_of_one_instance(gsp, instances):
    run = gsp("solve", instances, "--format", "jsonl", "--all")
    documents = answers(run)
    assert run.code == 3
    assert "4 instances: 3 complete, 1 infinitely many poses" in run.err
    assert [one["instance"] for one in documents] == [
        f"{instances}, line {k}" for k in range(1, len(NAMES) + 1)
    ]
    assert [one["exit_code"] for one in documents] == [0, 3, 0, 0]
    for name, found in zip(NAMES, documents, strict=True):
        alone = json.loads(gsp("solve", f"@{name}", "--all", "--format", "json").out)
        assert {key: found[key] for key in alone} == alone
    assert "infinitely many" in documents[1]["message"]


def test_standard_input_and_processes_change_nothing(gsp, instances, monkeypatch, tmp_path):
    many = lines_of(["octahedral-3-3"] * 18 + ["no-real-pose"])
    instances.write_text(many, encoding="utf-8")
    one = gsp("solve", instances, "--format", "jsonl", "--jobs", "1")
    two = gsp("solve", instances, "--format", "jsonl", "--jobs", "2")
    assert (one.code, one.out, one.err) == (two.code, two.out, two.err)
    assert len(answers(one)) == 19
    path = tmp_path / "a.jsonl"
    gsp("solve", instances, "-o", path)
    assert path.read_text(encoding="utf-8") == one.out


def test_what_is_wrong_with_one_stops_no_other(gsp, instances):
    text = lines_of(["octahedral-3-3"])
    wrong = '{"gsp": 1, "units": 3}\nhello\n\n\x00\n'
    instances.write_bytes((text + wrong + text).encode() + b"\xff\n" + text.encode())
    run = gsp("solve", instances, "--format", "jsonl")
    assert run.code == 2
    documents = answers(run)
    assert [one["exit_code"] for one in documents] == [0, 2, 2, 2, 0, 2, 0]
    assert f"{instances}, line 2:1:21: units: found '3'" in documents[1]["message"]
    assert set(documents[1]) == {"instance", "exit_code", "message"}
    missing = gsp("solve", "@octahedral-3-3", "nothing-there.yaml", "--format", "csv")
    assert missing.code == 2
    assert "nothing-there.yaml" in missing.out.splitlines()[2]


def test_changes_and_options_are_for_all(gsp, instances):
    instances.write_text(lines_of(["octahedral-3-3"] * 2), encoding="utf-8")
    both = answers(gsp("solve", instances, "--set", "1=1.1", "--format", "jsonl"))
    alone = json.loads(gsp("solve", "@octahedral-3-3", "--set", "1=1.1", "--format", "json").out)
    assert all(one["solutions"] == alone["solutions"] for one in both)
    run = gsp("solve", instances, "--near", "0,0,1,1,0,0,0", "--reading", "leg P1 B3 = 2 ± 1")
    assert run.code == 2
    assert "--near and --reading: for one SPEC" in run.err
    assert gsp("solve", "-", "-").code == 2
    empty = instances.with_name("empty.jsonl")
    empty.write_text("\n", encoding="utf-8")
    assert "found no instance" in gsp("solve", empty).err
    assert gsp("solve", empty.with_name("none.jsonl")).code == 2


def test_standard_input_solve_many(gsp, monkeypatch):
    import subprocess
    import sys

    run = subprocess.run(
        [sys.executable, "-m", "gspcli", "solve", "--lines", "-", "--format", "jsonl"],
        input=lines_of(["octahedral-3-3"]), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert json.loads(run.stdout)["instance"] == "standard input, line 1"


@pytest.mark.parametrize(
    ("word", "meant"),
    [("figure-3", "@figure-3"), ("Dietmaier.yaml", "@dietmaier"), ("hexa.yml", "hexa.yaml"),
     ("hexas.yaml", "hexa.yaml")],
)  # fmt: skip
def test_what_was_perhaps_meant_by_a_missing_file(gsp, tmp_path, monkeypatch, word, meant):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hexa.yaml").write_text("gsp: 1\n")
    for command in ("solve", "check", "analyze"):
        run = gsp(command, word)
        assert run.code == 2
        assert run.err == f"error: {word}: there is no such file: did you mean {meant}?\n"
