from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import gspcli
from gspcli.calibration import planning

ROOT = Path(__file__).parents[2]
MEASURED = ROOT / "docs" / "calibration" / "measured.csv"
LEVEL = ROOT / "docs" / "calibration" / "level.csv"
MACHINE = "@workspace-study-cones"
SIGMA = ("--sigma", "value=0.002", "--sigma", "position=0.005", "--sigma", "rotation=0.001")


def test_table(gsp):
    run = gsp("calibrate", MACHINE, MEASURED, *SIGMA, "--robust")
    assert (run.code, run.err) == (0, "")
    lines = run.out.splitlines()
    assert lines[0].startswith("Hexapod of a workspace study with joint cones: DPP")
    assert lines[2] == "24 rows, 42 numbers found"
    assert "of 101 degrees of freedom, between 75.08 and 130.7 in 95 %" in lines[3]
    assert lines[4] == "1 number left out, more than 5 sigma away: in row 8"
    assert lines[5].startswith("worst row: ")
    assert re.split(r"\s{2,}", lines[7]) == ["number", "stated", "found", "sigma", "change/sigma"]
    assert len([line for line in lines if line.startswith(("platform.", "base.", "offset."))]) == 42


def test_csv_and_json_have_the_same_numbers(gsp):
    csv = gsp("calibrate", MACHINE, MEASURED, *SIGMA, "--format", "csv")
    assert csv.code == 1
    assert "chi-squared" in csv.err
    head, *rows = csv.out.splitlines()
    assert head == "number,stated,found,sigma,change/sigma"
    document = json.loads(gsp("calibrate", MACHINE, MEASURED, *SIGMA, "--format", "json").out)
    assert document["schema"] == "gsp.calibrate/1"
    assert [row.split(",")[0] for row in rows] == [one["name"] for one in document["numbers"]]
    covariance = document["covariance"]
    for k, one in enumerate(document["numbers"]):
        assert covariance[k][k] ** 0.5 == pytest.approx(one["sigma"])
        assert float(rows[k].split(",")[2]) == pytest.approx(one["found"], abs=1e-12)
    assert document["worst"]["row"] == "8"


def test_the_instance_file(gsp, tmp_path):
    path = tmp_path / "calibrated.yaml"
    run = gsp("calibrate", MACHINE, MEASURED, *SIGMA, "--robust", "-o", path)
    assert (run.code, run.out, run.err) == (0, "", "")
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# calibrated by gsp calibrate from 24 rows: chi-squared ")
    line = next(line for line in text.splitlines() if line.startswith("  P1: "))
    assert re.search(r"\]\S*.*  # ± 0\.\d+, 0\.\d+, 0\.\d+$", line)
    assert len(re.findall(r"offset: -?[\d.]+\}  # offset ± 0\.\d+$", text, re.MULTILINE)) == 6
    found = gspcli.load(path)
    assert [row.reading_of(row.value) for row in found.constraints] == [
        row.value
        for row in gspcli.load(ROOT / "data/platforms/workspace-study-cones.yaml").constraints
    ]
    # What is read and measured agrees with the file to what was measured, but for the wrong one.
    poses = gsp("measure", path, MEASURED, "--format", "csv").out.splitlines()[1:]
    read = MEASURED.read_text(encoding="utf-8").splitlines()[2:]
    differences = [
        abs(float(a) - float(b))
        for ours, theirs in zip(poses, read, strict=True)
        for a, b in zip(ours.split(",")[1:7], theirs.split(",")[1:7], strict=True)
    ]
    assert sorted(differences)[-2] < 0.05 < sorted(differences)[-1]


def test_a_picture(gsp, tmp_path):
    path = tmp_path / "residuals.svg"
    assert gsp("calibrate", MACHINE, MEASURED, *SIGMA, "-o", path, "--accept").code == 0
    assert path.read_text(encoding="utf-8").startswith("<?xml")


def test_data_that_do_not_fit(gsp, tmp_path):
    """Two columns exchanged: chi-squared is right, and the file would be valid."""
    text = MEASURED.read_text(encoding="utf-8").replace("t,1,2,3", "t,2,1,3")
    data, path = tmp_path / "exchanged.csv", tmp_path / "calibrated.yaml"
    data.write_text(text, encoding="utf-8")
    words = ("calibrate", MACHINE, data, *SIGMA, "--robust", "--hold-unknown")
    table = gsp(*words)
    assert table.code == 1
    assert table.out.splitlines()[2].startswith("the data do not fit: ")
    assert "probably the readings 1 and 2 are exchanged" in table.out
    file = gsp(*words, "-o", path)
    assert (file.code, file.out) == (1, "")
    assert not path.exists()
    assert len(file.err.splitlines()) <= 3
    assert "probably the readings 1 and 2 are exchanged" in file.err
    assert "--accept takes the result unchanged" in file.err
    assert gsp(*words, "-o", path, "--accept").code == 0
    assert path.exists()


def test_what_is_not_told_is_refused_and_nothing_is_written(gsp, tmp_path):
    path = tmp_path / "calibrated.yaml"
    run = gsp("calibrate", MACHINE, LEVEL, *SIGMA, "-o", path)
    assert run.code == 4
    assert not path.exists()
    lines = run.err.splitlines()
    assert len(lines) <= 5
    assert lines[0] == "error: the data determine 21 of 42 numbers; they do not determine"
    assert lines[1].startswith("  a combination of ")
    assert "measure poses that turn the platform" in lines[-1]
    held = gsp("calibrate", MACHINE, LEVEL, *SIGMA, "--hold-unknown", "-o", path)
    assert held.code == 0
    assert "directions that the data do not determine are as stated" in path.read_text(
        encoding="utf-8"
    )


def test_a_plan_can_be_measured_and_gone_on_from(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    run = gsp("calibrate", MACHINE, "--plan", "12", *SIGMA, "-o", path)
    assert run.code == 0
    assert "12 of 3000 poses within ranges and cones" in run.err
    assert len(path.read_text(encoding="utf-8").splitlines()) == 13
    # As planned they are a perfect machine.
    same = gsp("calibrate", MACHINE, path, *SIGMA, "--format", "json")
    assert same.code == 0
    found = json.loads(same.out)
    assert all(abs(one["found"] - one["stated"]) < 1e-5 for one in found["numbers"])
    expected = json.loads(gsp("calibrate", MACHINE, "--plan", "12", *SIGMA, "--format", "json").out)
    sigma = {one["name"]: one["sigma"] for one in expected["expected"]}
    for one in found["numbers"]:
        assert one["sigma"] == pytest.approx(sigma[one["name"]], rel=0.05)
    more = gsp("calibrate", MACHINE, LEVEL, "--plan", "4", *SIGMA, "--format", "json")
    assert more.code == 0
    assert all(one["sigma"] < one["before"] for one in json.loads(more.out)["expected"])


def test_planned_poses_keep_what_is_required(gsp, tmp_path, monkeypatch):
    """Without it the most telling poses are next to singular ones."""
    monkeypatch.setattr(planning, "_CANDIDATES", 200)
    path, free = tmp_path / "poses.csv", tmp_path / "free.csv"
    required = "condition<=22, clearance>=0.01"
    plan = ("calibrate", "@workspace-study", "--plan", "6", "--seed", "3")
    assert gsp(*plan, "--require", required, "-o", path).code == 0
    assert len(path.read_text(encoding="utf-8").splitlines()) == 7
    words = ("--ignore", "1,2,3,4,5,6", "--require", required)
    assert gsp("measure", "@workspace-study", path, *words).code == 0
    assert gsp(*plan, "-o", free).code == 0
    assert gsp("measure", "@workspace-study", free, *words).code == 1
    wild = gsp(*plan, "--require", "condition<=1")
    assert wild.code == 2
    assert "home does not keep what is required of planned poses: require less" in wild.err
    alone = gsp("calibrate", "@workspace-study", MEASURED, "--require", required)
    assert "--require is for --plan: give it, too" in alone.err


HEAD = "t,1,2,3,4,5,6,x,y,z,qw,qx,qy,qz\n"
ROW = "1,120,120,120,120,120,120,0,0,100,1,0,0,0\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + ROW.replace("120", "12o", 1), "data.csv:2:3: 1: found '12o', expected a finite"),
        (HEAD + ROW.replace(",1,0,0,0", ",1,,0,0"), "data.csv:2:37: found nothing, expected a num"),
        (HEAD + ROW.replace(",1,0,0,0", ",0,0,0,0"), "found a quaternion of length zero"),
        (HEAD + ROW.replace("1,0,0,0\n", "1,0,0\n"), "data.csv:2:1: found 13 cells, expected 14"),
        (HEAD.replace("qw", "qq") + ROW, "qw is missing"),
        (HEAD.replace("6", "7") + ROW, "data.csv:1:13: found 7, expected a constraint from 1 to 6"),
        (HEAD.replace("t", "P9.x") + ROW, "found the unknown point 'P9', expected a point of"),
        (HEAD.replace("t", "P1.x") + ROW, "the columns of P1 lack y and z"),
        (HEAD.replace("t", "crank.B1") + ROW, "found 'crank.B1', expected no cranks"),
        (HEAD.replace("t", "incl.x") + ROW, "found one of incl.x and incl.y, expected both"),
        ("x,y,z\n1,2,3\n", "found no readings, expected some of the columns 1 2 3 4 5 6"),
        ("1,2,3,rx,ry,rz\n1,2,3,4,5,6\n", "without the order of the axes: say it with --euler"),
        ("", "found nothing, expected a heading and rows"),
    ],
)
def test_mistakes_have_their_place(gsp, tmp_path, monkeypatch, text, message):
    monkeypatch.chdir(tmp_path)
    Path("data.csv").write_text(text, encoding="utf-8")
    run = gsp("calibrate", MACHINE, "data.csv", "-o", "out.yaml")
    assert run.code == 2
    assert message in run.err
    assert not Path("out.yaml").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "give DATA, or --plan N"),
        ((MEASURED, "--sigma", "value"), "--sigma: found 'value', expected WHAT=NUMBER"),
        ((MEASURED, "--sigma", "value=x"), "--sigma: found 'x', expected a finite number"),
        ((MEASURED, "--sigma", "valu=1"), "found 'valu', expected value, angle, position"),
        ((MEASURED, "--hold", "P1"), "found 'P1', expected offsets, scales, frames"),
        ((MEASURED, "--target", "Q=1,2"), "--target: found 'Q=1,2', expected NAME=X,Y,Z"),
        ((MEASURED, "--mode", "1"), "--mode is for --plan: give it, too"),
        (("--plan", "3", "-o", "plan.yaml"), "a plan cannot be written as yaml"),
    ],
)
def test_wrong_options(gsp, words, message):
    run = gsp("calibrate", MACHINE, *words)
    assert run.code == 2
    assert message in run.err


def test_blank_cells_points_and_standard_input(gsp, tmp_path):
    """Readings and positions in tables of their own; a point instead of the pose."""
    head, *rows = MEASURED.read_text(encoding="utf-8").splitlines()[1:]
    cells = [row.split(",") for row in rows]
    cells[2][4] = cells[3][1] = ""
    cells[5][10:] = [""] * 4
    path = tmp_path / "some.csv"
    path.write_text("\n".join([head, *map(",".join, cells)]) + "\n", encoding="utf-8")
    run = gsp("calibrate", MACHINE, path, *SIGMA, "--robust", "--format", "json")
    assert run.code == 0
    assert json.loads(run.out)["freedom"] == 101 - 2 - 3


def test_coordinates_of_track_are_no_measured_points(gsp, tmp_path):
    """base.B1.z moved a joint in one command and was a measured target in the other."""
    path = tmp_path / "rows.csv"
    path.write_text("1,2,3,4,5,6,base.B1.x,base.B1.y,base.B1.z\n" + ",".join("9" * 9) + "\n")
    run = gsp("calibrate", "@workspace-study-cones", path)
    assert run.code == 2
    assert "found 'base.B1.x', which is a coordinate that moves in gsp track" in run.err
    run = gsp("calibrate", "@workspace-study-cones", path, "--target", "base.B1=0,0,0")
    assert run.code == 2
    assert "--target: found 'base.B1', expected a name that is no coordinate" in run.err


LOG = ROOT / "docs" / "calibration" / "controller-log.csv"


def test_a_machine_from_its_log(gsp, tmp_path):
    path = tmp_path / "machine.yaml"
    run = gsp("calibrate", "--from", LOG, "-o", path)
    assert (run.code, run.out) == (0, "")
    said = run.err.splitlines()
    assert said[1].startswith("--euler XYZ, degrees, rz left-handed: the lengths fit to 0.0021 mm;")
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# calibrated by gsp calibrate from 60 rows: ")
    assert all(f"# {sentence}\n" in text for sentence in said)
    assert text.count("# ± ") == 12
    home = gsp("solve", path, "--format", "csv").out.splitlines()
    stated = LOG.read_text(encoding="utf-8").splitlines()[2].split(",")[6:9]
    tx = [row.split(",") for row in home]
    column = tx[0].index("Tx")
    assert any(abs(float(row[column]) - 1000 * float(stated[0])) < 0.05 for row in tx[1:])


def test_the_table_and_the_document_of_a_log(gsp):
    table = gsp("calibrate", "--from", LOG)
    assert table.code == 0
    assert re.split(r"\s{2,}", table.out.splitlines()[8].strip()) == ["number", "found", "sigma"]
    document = json.loads(gsp("calibrate", "--from", LOG, "--format", "json").out)
    assert document["log"]["euler"] == "XYZ"
    assert document["log"]["senses"] == [1, 1, -1]
    assert (document["log"]["leg_unit"], document["log"]["position_unit"]) == ("mm", "m")
    assert document["doubts"] == []
    assert not any(one["as_good"] for one in document["log"]["others"])
    held = json.loads(
        gsp("calibrate", "--from", LOG, "--estimate", "offsets", "--format", "json").out
    )
    assert len(held["numbers"]) == 42
    assert len(document["numbers"]) == 36


def test_a_log_that_tells_no_machine(gsp, tmp_path):
    """Nothing is written, and the page shows the message."""
    lines = LOG.read_text(encoding="utf-8").splitlines()
    rows = [line.split(",") for line in lines[2:]]
    for row in rows[:5]:
        row[0] = f"{float(row[0]) + 30:.3f}"
    log, path = tmp_path / "wrong.csv", tmp_path / "machine.yaml"
    log.write_text("\n".join([lines[1], *map(",".join, rows)]) + "\n", encoding="utf-8")
    run = gsp("calibrate", "--from", log, "-o", path)
    assert (run.code, run.out) == (4, "")
    assert not path.exists()
    assert "no machine with six legs explains the log" in run.err
    assert gsp("calibrate", "--from", log, "--robust", "-o", path).code == 0


def test_wrong_use_of_from(gsp):
    for words, message in (
        (("calibrate", MACHINE, "--from", LOG), "give either SPEC or --from"),
        (("calibrate", "--from", LOG, "--plan", "3"), "--plan: not with --from"),
        (("calibrate",), "give SPEC and DATA, or --from LOG"),
        (("calibrate", "--from", LOG, "--mode", "1"), "--mode is for --plan: give it, too"),
    ):
        run = gsp(*words)
        assert run.code == 2
        assert message in run.err


@pytest.mark.parametrize(
    ("words", "columns"),
    [
        (("base=200,10", "platform=60,15", "rod=250", "tilt=20", "range=-100:100"), 6),
        (("base=200,0", "platform=50,30", "rod=250", "rails=3", "range=-150:150"), 3),
    ],
)
def test_a_plan_of_rails_is_measured_and_fitted(gsp, tmp_path, monkeypatch, words, columns):
    """The plan has the readings of the carriages; a file with a wrong rail is found from it."""
    monkeypatch.setattr(planning, "_CANDIDATES", 300)
    monkeypatch.chdir(tmp_path)
    assert gsp("new", "--linear", *words, "-o", "rails.yaml").code == 0
    hold = () if columns == 6 else ("--hold", "platform")
    run = gsp("calibrate", "rails.yaml", "--plan", "16", *hold, "-o", "plan.csv")
    assert run.code == 0
    assert "poses within ranges and cones\n" in run.err
    head, *rows = Path("plan.csv").read_text(encoding="utf-8").splitlines()
    names = head.split(",")[8:]
    assert len(names) == columns
    assert all(name.startswith("slide.B") for name in names)
    reach = 100 if columns == 6 else 150
    places = [list(map(float, row.split(",")[8:])) for row in rows]
    assert all(abs(x) <= reach for row in places for x in row)
    assert len(rows) == 16
    # The first rail reads from 0.2 mm beside where it is stated.
    wrong = [",".join((*row.split(",")[:8], str(p[0] + 0.2), *map(str, p[1:]))) for row, p in
             zip(rows, places, strict=True)]  # fmt: skip
    Path("data.csv").write_text("\n".join([head, *wrong, ""]), encoding="utf-8")
    zero = ("--estimate", "base.B1.slide.offset")
    sigma = ("--sigma", "slide=0.001", "--sigma", "position=0.001", "--sigma", "rotation=0.001")
    run = gsp("calibrate", "rails.yaml", "data.csv", *hold, *zero, *sigma, "-o", "found.yaml")
    assert (run.code, run.err) == (0, "")
    found = gspcli.load("found.yaml")
    slide = found.constraints[0].base.slide
    assert slide.offset.value == pytest.approx(-0.2, abs=2e-6)
    assert slide.reading_of(slide.limits[1]).value == pytest.approx(reach)
    text = Path("found.yaml").read_text(encoding="utf-8")
    assert ("with: " in text) == (columns == 3)
    document = json.loads(gsp("calibrate", "rails.yaml", "--plan", "8", "--format", "json").out)
    assert list(document["plan"][0]["drives"]) == names


def test_columns_of_drives_that_do_not_fit(gsp, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("data.csv").write_text("x,y,z,slide.B1,crank.B2\n0,0,0,0,0\n", encoding="utf-8")
    run = gsp("calibrate", "@modified-paradex", "data.csv")
    assert run.code == 2
    assert "1:16: found 'crank.B2', expected slide." in run.err
    assert "the columns of slides lack slide." in run.err
    run = gsp("calibrate", MACHINE, "data.csv")
    assert "found 'slide.B1', expected no slides, for SPEC has none" in run.err
