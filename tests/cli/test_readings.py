"""Requirements and sensors of a platform by its readings are those of the corrected platform."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.readings import readings_of
from gspcli.resources import data_path

MASSES = gspcli.Dynamics(gspcli.RigidBody(12, [0, 0, 0], [1, 1, 1, 0, 0, 0]))
#: Offsets are larger than the ranges (28 mm) are wide, and scales move values by as much.
OFFSETS = {0: "0.04", 1: "0.4", 3: "-sqrt(2)/10"}
SCALES = {1: "-0.2", 4: "0.1"}
HOME = np.eye(3)[None], np.array([[0.0, 0.0, 0.002]])


def corrected() -> Instance:
    instance = gspcli.load(data_path("platforms", "rubin-m2.yaml"))
    return replace(instance, dynamics=MASSES)


def by_readings() -> Instance:
    rows = list(corrected().constraints)
    for k, text in OFFSETS.items():
        rows[k] = replace(rows[k], offset=Number.of(text))
    for k, text in SCALES.items():
        rows[k] = replace(rows[k], scale=Number.of(text))
    return replace(corrected(), constraints=tuple(rows))


def _poses(instance: Instance) -> str:
    del instance
    return "t,x,y,z,qw,qx,qy,qz\n" + "".join(f"{k},0,0,{k / 1e3},1,0,0,0\n" for k in range(8))


def _values(instance: Instance) -> str:
    T = np.linspace((0, 0, 0), (0, 0, 0.007), 8)
    rows = gspcli.measure(instance, np.tile(np.eye(3), (8, 1, 1)), T)
    lines = [",".join(map(repr, [float(k), *row])) for k, row in enumerate(rows.tolist())]
    return "\n".join(["t,1,2,3,4,5,6", *lines])


@pytest.mark.parametrize(
    ("rows", "arguments"),
    [
        (_poses, ["measure"]),
        (_poses, ["analyze"]),
        (_poses, ["dynamics"]),
        (_values, ["track", "--mode", "1"]),
        (_values, ["dynamics", "--mode", "1"]),
    ],
)
@pytest.mark.parametrize("most", ["0.3", "0.6"])
def test_ranges_are_required_of_values(gsp, tmp_path, rows, arguments, most):
    found = []
    for instance in (by_readings(), corrected()):
        spec, path = tmp_path / "spec.yaml", tmp_path / "rows.csv"
        spec.write_text(gspcli.dumps(instance))
        path.write_text(rows(instance))
        command, *more = arguments
        asked = ("--require", f"range<={most}", "--format", "json")
        run = gsp(command, spec, path, *more, *asked)
        (told,) = json.loads(run.out)["requirements"]
        found.append((run.code, told["met"], told["worst"]))
    (code, met, worst), (same_code, same_met, same_worst) = found
    assert (code, met) == (same_code, same_met) == (0 if same_met else 1, same_met)
    assert worst == pytest.approx(same_worst, abs=1e-9)
    # 7 mm along z use half of the 14 mm on either side: one bar is kept, one is not.
    assert met is (most == "0.6")


@pytest.mark.parametrize("ranged", [True, False])
@pytest.mark.parametrize("arguments", [{}, {"random": 12}, {"within": {1: (0.47, 0.5)}}])
def test_sensors_see_the_same_modes(ranged, arguments):
    found = []
    for instance in (by_readings(), corrected()):
        if not ranged:
            rows = tuple(replace(row, limits=None) for row in instance.constraints)
            instance = replace(instance, constraints=rows)
        given = dict(arguments)
        if "within" in given:
            ends = np.tile([[0.0] * 6], (2, 1))
            ends[:, 0] = given["within"][1]
            given["within"] = {1: tuple(readings_of(instance, ends)[:, 0].tolist())}
        found.append(gspcli.sensors(instance, sensors=["leg P1 B2", "inclinometer"], **given))
    one, other = found
    assert one.drawn == other.drawn
    assert one.separations.modes.tolist() == other.separations.modes.tolist()
    assert other.separations.modes.max() > 1
    assert one.separations.least == pytest.approx(other.separations.least, rel=1e-6, abs=1e-6)
    assert np.abs(one.values - other.values).max() > 0.03


def test_sensors_at_rows_of_readings():
    R, T = np.tile(HOME[0], (3, 1, 1)), np.linspace((0, 0, 0), (0.001, 0.002, 0.003), 3)
    found = [
        gspcli.sensors(instance, gspcli.measure(instance, R, T), sensors=["leg P1 B2"])
        for instance in (by_readings(), corrected())
    ]
    assert found[0].separations.modes.tolist() == found[1].separations.modes.tolist()
    assert found[0].separations.least == pytest.approx(found[1].separations.least, rel=1e-6)
    assert found[1].separations.modes.min() > 1


FIT = ("solve", "@rubin-m2", "--fit", "--sigma", "value=0.001", "--reading")


def test_a_fit_of_more_than_six(gsp):
    run = gsp(*FIT, "leg P1 B2 = 2.913 ± 0.002")
    assert run.code == 0
    assert run.out.splitlines()[2].startswith("one pose fits the 7 numbers: chi-squared 0.0")
    assert "it is not proved that there are no others" in run.out
    assert "leg P1 B2" in run.out
    document = json.loads(gsp(*FIT, "leg P1 B2 = 2.913 ± 0.002", "--format", "json").out)
    assert document["fit"]["fitting"] == [1]
    assert np.shape(document["fit"]["poses"][0]["covariance"]) == (6, 6)
    rows = gsp(*FIT, "leg P1 B2 = 2.913 ± 0.002", "--format", "csv").out.splitlines()
    assert rows[0].startswith("number,Tx,Ty,Tz,qw,qx,qy,qz,chi_squared,probability,")


def test_a_fit_that_fails(gsp):
    run = gsp(*FIT, "leg P1 B2 = 2.953 ± 0.002")
    assert run.code == 1
    assert "the data do not show which" in run.err


def test_wrong_use_of_fit(gsp):
    for words, message in (
        (("solve", "@rubin-m2", "--fit"), "--fit needs readings besides the six values"),
        (("solve", "@rubin-m2", "--sigma", "value=1"), "give it with --fit"),
        ((*FIT, "leg P1 B2 = 3 ± 1", "--all"), "--all: not with --fit"),
        ((*FIT, "leg P1 B2 = 3 ± 1", "@dietmaier"), "for one SPEC"),
        ((*FIT, "leg P1 B2 = 3 ± 1", "--sigma", "value"), "expected WHAT=NUMBER"),
        (("solve", "@rubin-m2", "--fit", "--reading", "leg P1 B2 = 3 ± 1"), "give --sigma value="),
    ):
        run = gsp(*words)
        assert run.code == 2, words
        assert message in run.err
