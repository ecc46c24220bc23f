"""What a live page needs of a platform."""

from __future__ import annotations

import gzip
import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import gspcli
from gspcli.geometry.numbers import Number
from gspcli.pictures.live_numbers import live_numbers
from gspcli.resources import data_json, data_path, instance_files
from tools.recording import sha256
from viewer import kernel as live_module


def numbers_of(name: str) -> dict:
    return live_numbers(gspcli.solve(gspcli.load(instance_files()[name])))


def test_the_module_is_that_of_the_sources():
    manifest = data_json("live", "manifest.json")
    content = gzip.decompress(data_path("live", "kernel.wasm.gz").read_bytes())
    assert manifest["module"] == {"bytes": len(content), "sha256": sha256(content)}
    hint = "run python -m viewer.kernel"
    assert manifest["manifest"]["sources"]["sha256"] == live_module.digest(), hint


def test_numbers_are_plain_data():
    found = numbers_of("nano-hexapod")
    assert json.loads(json.dumps(found)) == found
    assert found["kinds"] == ["DPP"] * 6
    assert found["sides"] == [None] * 6
    assert found["quick"]
    assert found["proof"]["by"] == "geometry count"
    assert len(found["numbers"]) < 400_000
    assert (
        found["home"] == gspcli.solve(gspcli.load(instance_files()["nano-hexapod"])).home.number - 1
    )


def test_sliders_go_through_the_ranges_of_the_file():
    instance = gspcli.load(instance_files()["rubin-m2"])
    found = live_numbers(gspcli.solve(instance))
    limits = [[x.value for x in row.limits] for row in instance.constraints]
    np.testing.assert_allclose(found["ranges"], limits)


def test_sliders_are_readings_also_with_offsets_and_scales():
    instance = gspcli.load(instance_files()["rubin-m2"])
    rows = list(instance.constraints)
    rows[0] = replace(rows[0], offset=Number.of("0.001"), scale=Number.of("0.01"))
    found = live_numbers(gspcli.solve(replace(instance, constraints=tuple(rows))))
    low, high = ((x.value - 0.001) / 1.01 for x in rows[0].limits)
    np.testing.assert_allclose(found["ranges"][0], [low, high])
    assert low < found["values"][0] < high


def test_without_ranges_they_stay_within_what_values_can_be():
    found = numbers_of("surfaces-ppp")
    for value, (low, high), kind in zip(
        found["values"], found["ranges"], found["kinds"], strict=True
    ):
        assert low < value < high
        if kind[0] == "D":
            assert low > 0
        else:
            assert low > -90
            assert high < 180
    assert found["sides"][2] is None
    assert set(found["sides"][:2]) <= {1, -1, 0}


def test_a_value_of_zero_stays():
    found = numbers_of("point-on-line")
    zero = [k for k, value in enumerate(found["values"]) if value == 0]
    assert zero
    assert all(found["ranges"][k] == [0, 0] for k in zero)


def test_limits_are_what_values_can_be():
    found = numbers_of("surfaces-ppp")
    assert found["kinds"] == ["DPH", "DHP", "DLL", "ALL", "ALH", "AHH"]
    heights, angles = [None, None], ([0, 180], [-90, 90], [0, 180])
    assert found["limits"] == [heights, heights, [0, None], *angles]


def test_what_has_no_start_is_refused():
    with pytest.raises(gspcli.GspError, match="poses for special values alone"):
        numbers_of("griffis-duffy")


def test_offsets_are_part_of_the_platform():
    instance = gspcli.load(instance_files()["rubin-m2"])
    rows = list(instance.constraints)
    rows[0] = replace(rows[0], offset=Number.of(Fraction(1, 1000)))
    shifted = replace(instance, constraints=tuple(rows))
    found = live_numbers(gspcli.solve(shifted))
    assert found["values"][0] == pytest.approx(rows[0].value.value - 1e-3, abs=1e-12)
