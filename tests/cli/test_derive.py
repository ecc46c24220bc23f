"""The command `gsp derive`."""

import json


def test_list_of_cases(gsp):
    outcome = gsp("derive")
    assert (outcome.code, outcome.err) == (0, "")
    assert "PSC   a plane, a sphere and a cylinder" in outcome.out
    assert "8·1·1·1·1·1·1·1·1" in outcome.out
    rows = json.loads(gsp("derive", "--format", "json").out)["cases"]
    assert {row["case"]: row["solutions"] for row in rows} == {
        "PPP": 1, "PPC": 2, "PPS": 2, "SSS": 2, "PSS": 2, "PCC": 4, "SSC": 4, "PSC": 4,
        "CCC": 8, "SCC": 8, "AAA": 8, "6.2": 8, "6.8": 8,
    }  # fmt: skip


def test_text(gsp):
    outcome = gsp("derive", "ppp")
    assert outcome.code == 0
    assert outcome.err == ""
    assert outcome.out == (
        "PPP: three planes\n"
        "Proposition 6.7. Unknowns x < y < z.\n"
        "\n"
        "System\n"
        "  P1: d3*z + d2*y + d1*x + d4 = 0\n"
        "  P2: d7*z + d6*y + d5*x + d8 = 0\n"
        "  P3: d11*z + d10*y + d9*x + d12 = 0\n"
        "\n"
        "Triangular set, 1·1·1 = 1 solution\n"
        "  h1, degree 1 in x: z1*x + z2 = 0\n"
        "  h2, degree 1 in y: z1*y + z3 = 0\n"
        "  h3, degree 1 in z: z1*z + z4 = 0\n"
        "\n"
        "Coefficients\n"
        "  z1 = d1*d6*d11 - d1*d7*d10 - d2*d5*d11 + d2*d7*d9 + d3*d5*d10 - d3*d6*d9\n"
        "  z2 = d2*d7*d12 - d2*d8*d11 - d3*d6*d12 + d3*d8*d10 + d4*d6*d11 - d4*d7*d10\n"
        "  z3 = d1*d8*d11 - d1*d7*d12 + d3*d5*d12 - d3*d8*d9 - d4*d5*d11 + d4*d7*d9\n"
        "  z4 = d1*d6*d12 - d1*d8*d10 - d2*d5*d12 + d2*d8*d9 + d4*d5*d10 - d4*d6*d9\n"
        "\n"
        "Must not vanish\n"
        "  z1 (initials of h1, h2, h3); else the normals of the planes are linearly dependent\n"
    )


def test_json(gsp):
    document = json.loads(gsp("derive", "AAA", "--format", "json").out)
    assert document["schema"] == "gsp.derive/1"
    assert document["solutions"] == 8
    assert [item["degree"] for item in document["set"]] == [8, 1, 1, 1, 1, 1, 1, 1, 1]
    assert [item["leading"] for item in document["set"]] == document["unknowns"]
    assert document["coefficients"][0] == {"symbol": "q1", "value": "m0*m2", "terms": 1}


def test_file_and_expansion(gsp, tmp_path):
    path = tmp_path / "psc.tex"
    outcome = gsp("derive", "PSC", "--expand", "-o", path)
    assert (outcome.code, outcome.out, outcome.err) == (0, "", "")
    assert r"z_{10} &=" in path.read_text()
    assert "k_{" not in path.read_text()


def test_no_case(gsp):
    outcome = gsp("derive", "XYZ")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == (
        "error: 'XYZ' is not a case; the cases are PPP, PPC, PPS, SSS, PSS, PCC, SSC, PSC, "
        "CCC, SCC, AAA, 6.2, 6.8\n"
    )


def test_no_expansion(gsp):
    outcome = gsp("derive", "SCC", "--expand")
    assert outcome.code == 2
    assert "hierarchical form" in outcome.err
    assert outcome.out == ""


def test_help_has_examples(gsp):
    assert "gsp derive PSC --expand" in gsp("derive", "--help").out
