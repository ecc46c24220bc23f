import pytest

from gspcli.atlas.platform_counts import CLASSES, random_geometry
from gspcli.catalogue.names import parse_name
from gspcli.certification.counting import count_geometry
from gspcli.errors import GspError

SIX_LEGS = parse_name("DPP DPP DPP DPP DPP DPP")
#: Counts known from the literature or from Gröbner bases of the examples.
KNOWN = {
    "generic": 40,
    "planar": 40,
    "mirror": 36,
    "hexagons": 28,
    "6-4": 32,
    "6-3": 16,
    "3-3": 16,
    "congruent": 24,
    "planar-congruent": 16,
    "regular-hexagons": 0,
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("seed", [1, 2])
def test_counts_of_special_geometries(name, seed):
    count = count_geometry(random_geometry(SIX_LEGS, CLASSES[name], seed))
    assert (count.finite, count.solutions, count.distinct) == (True, KNOWN[name], KNOWN[name])


def test_planar_geometries_of_other_types():
    gsp_type = parse_name("DPP DPP DPL DPH ALL ALL")
    for name in ("generic", "planar", "planar-base", "planar-platform"):
        instance = random_geometry(gsp_type, CLASSES[name], 1)
        assert instance.type == gsp_type
        heights = [float(row.base.position[2]) for row in instance.constraints]
        assert (set(heights) == {0.0}) == (name in ("planar", "planar-base"))


def test_classes_of_joints_are_for_six_legs():
    with pytest.raises(GspError, match="expected 6PP"):
        random_geometry(parse_name("DPP DPP DPL DPH ALL ALL"), CLASSES["3-3"], 1)
