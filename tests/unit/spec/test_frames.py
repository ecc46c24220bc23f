"""Frames in instance files: read, written, and every mistake in its place."""

import pytest

import gspcli

GOOD = gspcli.dumps(gspcli.example("workspace-study"))
STATED = (
    "frames: {tool: {point: [0, 0, 1/3], rx: 1, ry: 0, rz: sqrt(2), euler: ZYX}, "
    "work: {point: [1, 2, 3], quaternion: [1, 0, 0, 1]}}"
)


def test_frames_are_written_as_they_are_read():
    found = gspcli.loads(GOOD + STATED)
    assert str(found.frames.tool.position[2]) == "1/3"
    assert found.frames.tool.euler == "ZYX"
    assert gspcli.dumps(found).splitlines()[-1] == STATED
    assert gspcli.loads(gspcli.dumps(found)) == found


@pytest.mark.parametrize(
    "text", ["frames: {tool: {point: [0, 0, 5]}}", "frames: {work: {point: [0, 0, 5]}}"]
)
def test_one_frame_alone(text):
    found = gspcli.loads(GOOD + text)
    assert None in (found.frames.tool, found.frames.work)
    assert gspcli.dumps(found).splitlines()[-1] == text.replace(
        "]}", "], quaternion: [1, 0, 0, 0]}"
    )
    assert gspcli.loads(gspcli.dumps(found)) == found
    assert gspcli.loads(GOOD + "frames: {}").frames is None


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("frames: {tol: {point: [0, 0, 0]}}", "10", "found the unknown key 'tol'"),
        ("frames: {tool: {pont: [0, 0, 0]}}", "17", "did you mean point?"),
        ("frames: {tool: {quaternion: [1, 0, 0, 0]}}", "16", "the key point is missing"),
        ("frames: {tool: {point: [0, 0]}}", "24", "expected three numbers"),
        ("frames: {work: {point: [0, 0, 0], rx: 3}}", "39", "found rx without euler"),
        ("frames: {work: {point: [0, 0, 0], rx: 3, euler: XZX}}", "49", "three different axes"),
        ("frames: {work: {point: [0, 0, 0], quaternion: [0, 0, 0, 0]}}", "47", "any but zero"),
        ("frames: 3", "9", "expected a mapping with tool and work"),
    ],
)
def test_mistakes_have_line_and_column(text, place, message):
    with pytest.raises(gspcli.SpecError) as error:
        gspcli.loads(GOOD + text, name="f")
    line = GOOD.count("\n") + 1
    assert f"f:{line}:{place}: frames" in str(error.value)
    assert message in str(error.value)
