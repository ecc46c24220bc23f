"""One small machine in each format: the same hexapod is read, or a message has the reason."""

from __future__ import annotations

import re

import machine_models as models
import numpy as np
import pytest
from one_hexapod import BASE, LENGTHS, PLATFORM, Write, same

import gspcli
from gspcli.errors import GspError, SpecError
from gspcli.machines.api import import_machine
from gspcli.machines.graph import NoPlatform

# -- Tables -----------------------------------------------------------------------------------


def table(heading: str, delimiter: str = ",", comma: bool = False) -> str:
    rows = [heading]
    for i, (b, p, length) in enumerate(zip(BASE, PLATFORM, LENGTHS, strict=True), 1):
        cells = [f"leg {i}", *(repr(float(x)) for x in (*b, *p, length))]
        rows.append(
            delimiter.join(c.replace(".", ",") if comma and "leg" not in c else c for c in cells)
        )
    return "# joints\n\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("heading", "delimiter", "comma"),
    [
        ("name,bx,by,bz,px,py,pz,length", ",", False),
        ("leg;base_x [mm];base_y;base_z;platform_x;platform_y;platform_z;length", ";", True),
        ("Leg\tBase X\tBase Y\tBase Z\tTop X\tTop Y\tTop Z\tLeg length", "\t", True),
        ("no.,x_base (mm),y_base,z_base,x_platform,y_platform,z_platform,L", ",", False),
        ("strut,XB,YB,ZB,XP,YP,ZP,value", ",", False),
        ("id,bottom.x,bottom.y,bottom.z,moving.x,moving.y,moving.z,distance", ",", False),
    ],
)
def test_tables_with_headings_that_have_one_meaning(
    read: Write, heading: str, delimiter: str, comma: bool
) -> None:
    found = read("joints.csv", table(heading, delimiter, comma))
    same(found, home=False)
    assert found.instance.units.length == "mm"
    assert ("taken for mm" in " ".join(found.notes)) == ("mm" not in heading)
    assert found.chains[0].startswith("1 leg 1: S-P*-S: DPP = ")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("by", "note"), "expected also by"),
        (("by", "bx"), "found 'bx' and 'bx', expected one column for bx"),
        (("bx", "bx [deg]"), "found the unit 'deg'"),
        (("bx,by", "bx [mm],by [m]"), "found columns in m and mm, expected one unit"),
        (("length", "weight"), "found no length of each leg"),
        (("120.0", "12O"), "joints.csv:4:3: found '12O', expected a number"),
        (("120.0", ""), "joints.csv:4:1: found no number for by"),
        (("120.0", "120.0,1"), "joints.csv:4:1: found 9 cells, expected 8"),
        (("120.0", "1e99"), "expected a number below 1e+15"),
        (("120.0", "nan"), "found 'nan', expected a number"),
    ],
)
def test_tables_with_mistakes(read: Write, change: tuple[str, str], says: str) -> None:
    text = table("name,bx,by,bz,px,py,pz,length")
    assert change[0] in text
    with pytest.raises(SpecError, match=re.escape(says)):
        read("joints.csv", text.replace(change[0], change[1], 1))


def test_a_table_with_ranges_has_lengths_in_the_middle(read: Write) -> None:
    rows = [f"{i};" + ";".join(f"{x:g}" for x in (*b, *p)) + ";100;200"
            for i, (b, p) in enumerate(zip(BASE, PLATFORM, strict=True))]  # fmt: skip
    found = read(
        "joints.tsv",
        "\n".join(["leg;bx;by;bz;px;py;pz;min;max;colour", *(r + ";red" for r in rows)]),
    )
    for row in found.instance.constraints:
        assert (row.value.value, *(x.value for x in row.limits)) == (150, 100, 200)
    assert any("middle of min and max" in note for note in found.notes)
    assert any("not read: 'colour'" in note for note in found.notes)


def test_seven_legs_are_refused(read: Write) -> None:
    text = table("name,bx,by,bz,px,py,pz,length") + "leg 7,1,2,3,4,5,6,100\n"
    with pytest.raises(NoPlatform, match=r"7 chains .* hold 7 constraints.*1 constraint too many"):
        read("joints.csv", text)


def test_the_sample_of_a_spreadsheet() -> None:
    found = import_machine(models.public("hexapod_sample.csv"))
    assert found.instance.constraints[2].base.position[0].fraction == 62.5
    assert gspcli.solve(found.instance).counts.real == 16


# -- LinuxCNC ---------------------------------------------------------------------------------


def hal() -> str:
    return "loadrt genhexkins\n" + "".join(
        f"setp genhexkins.{body}.{i}.{axis} {point[k]!r}\n"
        for body, points in (("base", BASE.tolist()), ("platform", PLATFORM.tolist()))
        for i, point in enumerate(points)
        for k, axis in enumerate("xyz")
    )


INI = (
    "[KINS]\nKINEMATICS = genhexkins  # six struts\n[TRAJ]\nLINEAR_UNITS = mm\n"
    "HOME = 0 0 100 0 0 0\n"
)


def test_linuxcnc(read: Write) -> None:
    limits = "".join(f"[JOINT_{i}]\nMIN_LIMIT = 50\nMAX_LIMIT = 400\n" for i in range(6))
    found = read("kinematics.hal", hal(), machine__ini=INI + limits)
    same(found)
    assert [x.value for x in found.instance.constraints[0].limits] == [50, 400]
    wide = read("kinematics.hal", hal(), machine__ini=INI + limits.replace("50", "0"))
    assert all("range 0 to 400" in chain for chain in wide.chains)
    inch = read("kinematics.hal", hal(), machine__ini=INI.replace("mm", "inch"))
    assert inch.instance.units.length == "in"
    turned = read("kinematics.hal", hal(), machine__ini=INI.replace("100 0 0 0", "100 10 20 30"))
    x, y, z = np.radians([10, 20, 30])
    R = turned.instance.home.R(np.pi / 180)
    assert np.allclose(R[2], [-np.sin(y), np.sin(x) * np.cos(y), np.cos(x) * np.cos(y)])
    assert np.isclose(np.arctan2(R[1, 0], R[0, 0]), z)


@pytest.mark.parametrize(
    ("hal_change", "ini_change", "says"),
    [
        (("setp genhexkins.base.3.y", "#"), ("", ""), "found 35 of 36 pins"),
        (("85", "8S"), ("", ""), "kinematics.hal:2:1: found '8S.0'"),
        (("", ""), ("genhexkins", "trivkins"), "expected an INI file beside it"),
        (("", ""), ("0 0 100 0 0 0", "0 0 100"), "machine.ini:5:1: [TRAJ]HOME: found '0 0 100'"),
        (("", ""), ("= mm", "= furlong"), "found 'furlong'"),
        (("", ""), ("HOME = 0 0 100 0 0 0", ""), "found neither a home"),
    ],
)  # fmt: skip
def test_linuxcnc_with_mistakes(
    read: Write, hal_change: tuple[str, str], ini_change: tuple[str, str], says: str
) -> None:
    text, ini = hal().replace(*hal_change, 1), INI.replace(*ini_change, 1)
    with pytest.raises(SpecError, match=re.escape(says)):
        read("kinematics.hal", text, machine__ini=ini)


# -- CASPR ------------------------------------------------------------------------------------


def cables(count: int = 6) -> str:
    inner = "".join(
        f'<cable_ideal name="cable {i}" attachment_reference="joint"><properties><force_min>10'
        "</force_min><force_max>900</force_max></properties><attachments><attachment><link>0</link>"
        f"<location>{models.row(BASE[i % 6] + i // 6)}</location></attachment>"
        "<attachment><link>1</link>"
        f"<location>{models.row(PLATFORM[i % 6])}</location></attachment></attachments>"
        "</cable_ideal>"
        for i in range(count)
    )
    head = '<!DOCTYPE cables SYSTEM "../cables.dtd"><cables default_cable_set="a">'
    return f'{head}<cable_set id="b"/><cable_set id="a">{inner}</cable_set></cables>'


BODIES = (
    '<bodies_system><links><link_rigid num="1" name="crane"><joint type="SPATIAL_EULER_XYZ" '
    'q_initial="0 0 100 0 0 0"/><physical><mass>3</mass><com_location>1 2 3</com_location><inertia>'
    "<Ixx>1</Ixx><Iyy>1</Iyy><Izz>1</Izz></inertia></physical></link_rigid></links></bodies_system>"
)


def test_caspr(read: Write) -> None:
    for name, other in (("r_cables.xml", "r_bodies__xml"), ("r_bodies.xml", "r_cables__xml")):
        texts = {"r_cables.xml": cables(), "r_bodies.xml": BODIES}
        found = read(name, texts.pop(name), **{other: texts.popitem()[1]})
        same(found)
        assert found.instance.name == "crane"
        assert found.instance.dynamics.platform.mass.value == 3
        assert "tension 10 to 900 N" in found.chains[0]
        assert found.text.count("tension 10 to 900 N") == 6
        assert any("of 2 sets of cables this is 'a'" in note for note in found.notes)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("SPATIAL_EULER_XYZ", "R_Z"), "guided by the joint 'R_Z'"),
        (("</links>", '<link_rigid name="arm"/></links>'), "2 moving bodies ('crane' and 'arm')"),
        (("0 0 100 0 0 0", "0 0 100"), "expected 6 numbers"),
        (("<com_location>1 2 3</com_location>", ""), "found no <com_location>"),
    ],
)  # fmt: skip
def test_caspr_with_mistakes(read: Write, change: tuple[str, str], says: str) -> None:
    with pytest.raises(GspError, match=re.escape(says)):
        read("r_cables.xml", cables(), r_bodies__xml=BODIES.replace(*change))


def test_caspr_of_other_numbers_of_cables(read: Write) -> None:
    with pytest.raises(NoPlatform, match=r"8 chains .8 S-P.-S.*2 constraints too many"):
        read("r_cables.xml", cables(8), r_bodies__xml=BODIES)
    with pytest.raises(SpecError, match="found the bodies alone"):
        read("alone_bodies.xml", BODIES)


def test_equal_chains_are_no_six_constraints(read: Write) -> None:
    """An instance file refuses the same distance twice, so none is written."""
    lines = table("name,bx,by,bz,px,py,pz,length").splitlines()
    lines[-1] = lines[-2]
    with pytest.raises(NoPlatform, match="hold the same distance: these are at most five"):
        read("joints.csv", "\n".join(lines) + "\n")


@pytest.mark.parametrize(("name", "real"), [("FAST", 16), ("CoGiRo", None)])
def test_public_cable_robots(name: str, real: int | None) -> None:
    file = models.public(f"caspr_{name}_cables.xml")
    if real is None:
        with pytest.raises(NoPlatform, match="hold 8 constraints, expected six"):
            import_machine(file)
    else:
        assert gspcli.solve(import_machine(file).instance).counts.real == real
