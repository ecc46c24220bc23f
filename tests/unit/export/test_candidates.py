from __future__ import annotations

import json

import numpy as np
import pytest

from gspcli.errors import SpecError
from gspcli.export.answers import read_candidates
from gspcli.geometry.quaternions import rotation_from_quaternion

E = [0.5, 0.1, -0.7, 0.3]
R = rotation_from_quaternion(np.array(E))
T = [1.5, -2.0, 3e-3]
NAMES = [f"r{i}{j}" for i in "123" for j in "123"] + ["tx", "ty", "tz"]
NUMBERS = [*R.ravel().tolist(), *T]


def line(values: list[float], mark: str = ",") -> str:
    return mark.join(map(repr, values))


@pytest.mark.parametrize(
    "text",
    [
        json.dumps([{"R": R.tolist(), "T": T}]),
        json.dumps([{"quaternion": E, "T": T}]),
        json.dumps({"schema": "gsp.solve/1", "solutions": [{"R": R.tolist(), "T": T}]}),
        json.dumps([NUMBERS]),
        json.dumps([[*E, *T]]),
        line(NUMBERS),
        line([*E, *T], "\t"),
        line([*E, *T], "; "),
        line([*E, *T], "  "),
        "# poses\n\n" + line(NUMBERS) + "\n",
        "// ** Could not find dynamic library: p_Procs_FieldQ.so\n# poses\n" + line(NUMBERS),
        ",".join(NAMES) + "\n" + line(NUMBERS),
        "no.,tx,ty,tz,qw,qx,qy,qz,residual\n1," + line([*T, *E]) + ",1e-12",
        "T1,T2,T3,E0,E1,E2,E3\n" + line([*T, *E]),
    ],
)
def test_every_form_gives_the_pose(text: str) -> None:
    poses = read_candidates(text, "poses")
    np.testing.assert_allclose(poses.R, [R], atol=1e-15)
    np.testing.assert_array_equal(poses.T, [T])
    assert poses.claimed_real == (None,)


def test_imaginary_parts_and_claims() -> None:
    entry = {"R": R.tolist(), "T": T, "R_imag": (2 * R).tolist(), "T_imag": T, "real": False}
    poses = read_candidates(json.dumps({"solutions": [entry]}), "poses")
    np.testing.assert_allclose(poses.R, [R * (1 + 2j)])
    np.testing.assert_allclose(poses.T, [np.array(T) * (1 + 1j)])
    assert poses.claimed_real == (False,)
    heading = ",".join([*NAMES, *(name + "_imag" for name in NAMES), "real"])
    text = f"{heading}\n{line(NUMBERS)},{line([2 * x for x in NUMBERS])},true\n"
    poses = read_candidates(text, "poses")
    np.testing.assert_allclose(poses.R, [R * (1 + 2j)])
    assert poses.claimed_real == (True,)


def test_sides() -> None:
    entry = {"R": R.tolist(), "T": T, "sides": {"2": "negative", "5": "positive"}}
    poses = read_candidates(json.dumps([entry, [*E, *T]]), "poses")
    assert poses.claimed_sides.tolist() == [[0, -1, 0, 0, 1, 0], [0] * 6]
    text = f"{','.join(NAMES)},sides\n{line(NUMBERS)},2:negative 5:positive\n{line(NUMBERS)},\n"
    poses = read_candidates(text, "poses")
    assert poses.claimed_sides.tolist() == [[0, -1, 0, 0, 1, 0], [0] * 6]


@pytest.mark.parametrize("sides", ["up", [1], {"7": "positive"}, {"1": "both"}, {"1": [1]}])
def test_bad_sides_are_mistakes(sides: object) -> None:
    with pytest.raises(SpecError, match="expected positive or negative by numbers of constraints"):
        read_candidates(json.dumps([{"R": R.tolist(), "T": T, "sides": sides}]), "poses")


@pytest.mark.parametrize("text", ["", "[]", '{"solutions": []}', "# nothing\n"])
def test_an_empty_list_is_a_mistake(text: str) -> None:
    with pytest.raises(SpecError, match="poses: found no poses, expected at least one: R"):
        read_candidates(text, "poses")


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("{", ["poses:1:2: not JSON: Expecting property name enclosed in double quotes"]),
        ('{"poses": []}', ["poses: found no list under the key solutions, expected one of poses"]),
        (
            '[{"T": [1, 2, 3]}, 7, [1, 2]]',
            [
                "poses: [0]: found T, expected R (3x3) or quaternion (4 numbers, scalar first), "
                "and T (3 numbers)",
                "poses: [1]: found 7, expected a pose: R (3x3) or quaternion (4 numbers, scalar "
                "first), and T (3 numbers)",
                "poses: [2]: found 2 numbers, expected 12 (R by rows, T) or 7 (quaternion, T)",
            ],
        ),
        (
            '{"solutions": [{"R": [1, 2], "T": [1, 2, 3]}]}',
            ["poses: solutions[0]: R is not 3 x 3 finite numbers"],
        ),
        (
            '[{"quaternion": [1, 0, 0, 0], "T": [1, 2, NaN]}]',
            ["poses: [0]: T is not 3 finite numbers"],
        ),
        (
            '[{"quaternion": [true, 0, 0, 0], "T": [1, 2, 3]}, [1, 0, 0, 0, 1, 2, false]]',
            [
                "poses: [0]: quaternion is not 4 finite numbers",
                "poses: [1]: the list is not 7 finite numbers",
            ],
        ),
        (
            '[{"quaternion": [1, 0, 0, 0], "T": [1, 2, 3], "real": "false"}]',
            ["poses: [0]: real: found 'false', expected true or false, or nothing"],
        ),
        (
            "qw,qx,qy,qz,tx,ty,tz,real\n1,0,0,0,1,2,3,no",
            ["poses:2:1: real: found 'no', expected true or false, or nothing"],
        ),
        (
            "# heading\n0,0,0,0,1,1,1\n1,0,0,0,1,1,1\n1,0,0,x,1,1,1",
            [
                "poses:2:1: found a quaternion of norm zero, expected one of a rotation",
                "poses:4:1: the list is not 7 finite numbers",
            ],
        ),
        (
            "tx,ty,tz\n1,2,3",
            [
                "poses:2:1: found T, expected R (3x3) or quaternion (4 numbers, scalar first), "
                "and T (3 numbers)"
            ],
        ),
    ],
)
def test_all_mistakes_are_reported_at_once(text: str, messages: list[str]) -> None:
    with pytest.raises(SpecError) as caught:
        read_candidates(text, "poses")
    assert [str(mistake) for mistake in caught.value.mistakes] == messages
