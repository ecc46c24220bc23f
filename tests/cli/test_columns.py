"""Logs without a heading: the message, and `--columns` in every command that reads tables."""

import pytest

POSES = "0 0 0 400 1 0 0 0\n1 0 0 401 1 0 0 0\n2 0 0 402 1 0 0 0\n"
NAMES = "t,x,y,z,qw,qx,qy,qz"
COMMANDS = [
    ("measure", "@workspace-study", "LOG"),
    ("track", "@workspace-study", "LOG"),
    ("analyze", "@workspace-study", "LOG"),
    ("clearance", "@workspace-study", "LOG"),
    ("sensors", "@workspace-study", "LOG", "--sensor", "leg P1 B4"),
    ("view", "@workspace-study", "--track", "LOG"),
]


@pytest.mark.parametrize("words", COMMANDS, ids=[words[0] for words in COMMANDS])
def test_names_stand_for_the_heading(gsp, tmp_path, words):
    log, headed = tmp_path / "log.txt", tmp_path / "headed.csv"
    log.write_text(POSES, encoding="utf-8")
    headed.write_text(NAMES.replace(",", " ") + "\n" + POSES, encoding="utf-8")
    runs = [
        gsp(*(str(path) if word == "LOG" else word for word in words), *more)
        for path, more in ((log, ()), (log, ("--columns", NAMES)), (headed, ()))
    ]
    assert runs[0].code == 2
    assert runs[0].err.startswith(
        f"error: {log}:1:1: the first line has numbers: give names with --columns x,y,z,..."
    )
    assert runs[1].code == runs[2].code == 0
    assert runs[1].out == runs[2].out


def test_forces_and_measurements_have_names_too(gsp, tmp_path):
    log = tmp_path / "log.txt"
    log.write_text("0.5 2\n", encoding="utf-8")
    for words in (
        ("calibrate", "@workspace-study-cones", log),
        ("calibrate", "--from", log),
        ("dynamics", "@workspace-study", log),
    ):
        assert "give names with --columns" in gsp(*words).err
        assert "give names with --columns" not in gsp(*words, "--columns", "t,1").err


def test_one_pose_of_a_file_has_its_own_heading(gsp, tmp_path):
    pose = tmp_path / "pose.csv"
    pose.write_text("x,y,z,qw,qx,qy,qz\n0,0,400,1,0,0,0\n", encoding="utf-8")
    run = gsp("analyze", "@workspace-study", "--pose", f"@{pose}", "--columns", "a,b")
    assert run.code == 0
