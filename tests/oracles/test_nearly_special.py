"""Special and nearly special platforms against exact counts (`tools/verify_special.py`)."""

from __future__ import annotations

from collections.abc import Callable

import pytest

SAMPLE = {
    "hexagons": ["shape-1/straight/6-places", "shape-2/turned/9-places"],
    "plates": ["hexagon/1e-2/1", "hexagon/1e-9/2"],
    "joints": ["3-3/spatial/1e-2", "3-3/planar/1e-7", "6-4/spatial/1e-12", "6-3/planar/exact"],
    "bodies": ["congruent/1e-5", "similar-plates/1e-7", "congruent/exact"],
    "double": ["axis-1/exact", "axis-1/+1e-14", "axis-2/-1e-14"],
    # Poses at 1e12 and at 1e25 lengths: 64 digits.
    "parallels": ["DPH-1/1e-8", "DLL-2/1e-12", "DPL-1/1e-12"],
    "line-pairs": ["1/parallel", "1/1e-9", "2/1e-12"],
    "couplings": ["vees-1/one/1e-9", "vees-2/one/exact"],
    "dependent": ["1/1e-12"],
    "tangent": ["cylinders-52/-1e-10", "cylinders-52/+1e-12", "cylinders-41/+1e-12"],
}


@pytest.mark.parametrize("group", SAMPLE)
def test_nearly_special_platforms_are_what_they_are(group: str, load_tool: Callable) -> None:
    made = load_tool("special_platforms")
    judge = load_tool("special_answers")
    wanted = {f"{group}/{name}" for name in SAMPLE[group]}
    chosen = [platform for platform in made.platforms([group]) if platform.id in wanted]
    assert len(chosen) == len(wanted)
    exact = made.recorded()
    for platform in chosen:
        _, found, failure = judge.answers(platform, 1)
        assert not failure
        assert [judge.judged(answer, exact[platform.id]) for answer in found] == ["right"]
        assert found[0].proof != "none"


def test_nothing_said_depends_on_the_seed(load_tool: Callable) -> None:
    made = load_tool("special_platforms")
    judge = load_tool("special_answers")
    wanted = {"double/axis-2/-1e-14", "line-pairs/1/1e-9", "joints/6-4/spatial/1e-12"}
    groups = sorted({name.partition("/")[0] for name in wanted})
    chosen = [platform for platform in made.platforms(groups) if platform.id in wanted]
    assert len(chosen) == len(wanted)
    for platform in chosen:
        _, found, failure = judge.answers(platform, 4)
        assert not failure
        said = {(a.verdict, a.found, a.multiple, a.real, a.certified) for a in found}
        assert len(said) == 1
