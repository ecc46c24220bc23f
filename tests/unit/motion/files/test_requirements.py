"""Requirements in words, and the worst of many rows."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.errors import GspError
from gspcli.motion.files.requirements import QuantityParts, judge, parse_requirements


def test_names_numbers_and_signs():
    found = parse_requirements(" range,Cone , clearance >= .5, condition≤5e1,pose_clearance>=2")
    assert list(map(str, found)) == [
        "range <= 1",
        "cone <= 1",
        "clearance >= 0.5",
        "condition <= 50",
        "pose-clearance >= 2",
    ]
    assert str(*parse_requirements("range<=0.9")) == "range <= 0.9"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("clearence>=1", "found 'clearence>=1', expected range, .* or error: did you mean clear"),
        ("clearance<=1", "found 'clearance<=1', expected clearance>=NUMBER"),
        ("condition", "found 'condition', expected condition<=NUMBER"),
        ("condition=5", "found 'condition=5', expected range, "),
        ("range>=1", "found 'range>=1', expected range<=NUMBER"),
        ("force<=x", "force: found 'x', expected a finite number"),
        ("force<=", "force: found nothing, expected a finite number"),
        ("force<=1e999", "force: found '1e999', expected a finite number"),
        ("range, range<=1", "found range twice, expected each quantity once"),
        ("", "found '', expected range, "),
        ("range,", "found '', expected range, "),
    ],
)
def test_mistakes_are_named(text, message):
    with pytest.raises(GspError, match=f"^--require: {message}"):
        parse_requirements(text)


def test_the_worst_row_of_each():
    requirements = parse_requirements("condition<=50, clearance>=0.5, force<=200")
    numbers = {
        "condition": np.array([3.0, 50.0, 7.0]),
        "clearance": np.array([0.7, 0.6, 0.4]),
        "force": QuantityParts(
            np.array([[1.0, 2.0], [3.0, 201.0], [0.0, 4.0]]), ["leg 1", "leg 2"]
        ),
    }
    condition, clearance, force = judge(requirements, numbers)
    assert (condition.met, condition.worst, condition.row) == (True, 50.0, 1)
    assert (clearance.met, clearance.worst, clearance.row) == (False, 0.4, 2)
    assert (force.met, force.worst, force.row, force.part) == (False, 201.0, 1, "leg 2")


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_what_could_not_be_computed_is_the_worst(number):
    (verdict,) = judge(parse_requirements("error<=9"), {"error": np.array([1.0, number, 8.0])})
    assert (verdict.met, verdict.row) == (False, 1)
    (verdict,) = judge(
        parse_requirements("stiffness>=9"), {"stiffness": np.array([10.0, np.nan, 20.0])}
    )
    assert (verdict.met, verdict.row) == (False, 1)


def test_nothing_is_not_kept_by_no_pose():
    with pytest.raises(GspError, match="no pose of which condition <= 9 could be required"):
        judge(parse_requirements("condition<=9"), {"condition": np.zeros(0)})
