"""Tables 1 and 2: what is printed against what is derived."""

from gspcli.paper import table1, table2
from gspcli.paper.printed import differences_from


def test_table_1_has_one_wrong_sign():
    (difference,) = table1.differences()
    assert (difference.row, difference.column) == ("solution 8", "r21")
    assert difference.printed == "(3-sqrt(5))/(2*(-1+sqrt(5)))"
    assert difference.computed == "(1 - sqrt(5))/4"


def test_the_print_of_table_1_is_no_rotation_in_row_8():
    """The proof that needs no derivation: its first two columns are not perpendicular."""
    from sympy import radsimp, sympify

    row = {name: sympify(text) for name, text in table1.printed()[7].items()}
    product = sum(row[f"r{i}1"] * row[f"r{i}2"] for i in (1, 2, 3))
    assert radsimp(product).expand() != 0
    row["r21"] = -row["r21"]
    product = sum(row[f"r{i}1"] * row[f"r{i}2"] for i in (1, 2, 3))
    assert radsimp(product).expand() == 0


def test_table_2_is_that_of_exchanged_distances():
    found = list(table2.differences())
    places = {(f"solution {i}", unknown) for i in range(1, 9) for unknown in "xy"}
    assert {(d.row, d.column) for d in found} == places
    assert not list(differences_from(2, table2.compute(6, 5, 4)))


def test_the_print_of_table_2_is_not_on_the_cylinders():
    from sympy import sympify

    for row in table2.printed():
        x, y, z = (sympify(row[name]) for name in "xyz")
        assert (x**2 + y**2, x**2 + z**2, y**2 + z**2) == (36, 25, 16)


def test_sizes():
    assert [len(row) for row in table1.printed()] == [9] * 8
    assert [len(row) for row in table2.printed()] == [3] * 8
