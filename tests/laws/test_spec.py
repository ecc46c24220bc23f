"""Laws of the instance file: reading never fails otherwise than by SpecError; writing is exact."""

import random
import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.errors import SpecError
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number, parse_number
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.resources import data_directory
from gspcli.spec import dumps, loads, read_text

EXAMPLES = sorted((data_directory() / "examples").glob("*.yaml"))
TEXT = (data_directory() / "examples" / "example-6.8.yaml").read_text(encoding="utf-8")
QUICK = settings(derandomize=True, deadline=None, max_examples=150)

decimals = st.decimals(-1000, 1000, places=4, allow_nan=False).map(str).map(parse_number)
atoms = st.one_of(decimals, st.just(Number("pi")))


def _combined(children):
    return st.one_of(
        st.tuples(st.sampled_from("+-*"), children, children).map(
            lambda t: f"({t[1]}) {t[0]} ({t[2]})"
        ),
        st.tuples(st.sampled_from(["sin", "cos", "atan", "-"]), children).map(
            lambda t: f"{t[0]}({t[1]})"
        ),
        children.map(lambda c: f"sqrt(2 + sin({c})) / 3"),
    )


expressions = st.recursive(atoms.map(str), _combined, max_leaves=3)


def _readable(text):
    try:
        return parse_number(text)
    except ValueError:
        return None


numbers = expressions.map(_readable).filter(lambda number: number is not None)
positive = st.decimals("0.01", 100, places=3).map(str).map(parse_number)
vectors = st.tuples(numbers, numbers, numbers)
directions = st.tuples(numbers, numbers, positive)
names = st.text(st.characters(exclude_categories=["Z", "C"]), min_size=1, max_size=8)
texts = st.text(st.sampled_from(string.printable[:95] + "äµ√😀\n\t"), min_size=1, max_size=30)


@st.composite
def instances(draw):
    """Instances with distinct names and values in range."""
    makers = {
        "P": lambda: Point(draw(vectors)),
        "L": lambda: Line(draw(vectors), draw(directions)),
        "H": lambda: Plane(draw(vectors), draw(directions)),
    }
    distances = st.sampled_from(["DPP", "DPL", "DLP", "DPH", "DHP", "DLL"])
    kinds = draw(st.lists(distances, min_size=3, max_size=3))
    angles = st.sampled_from(["DPP", "DHP", "ALL", "ALH", "AHL", "AHH"])
    kinds += draw(st.lists(angles, min_size=3, max_size=3))
    pairs = draw(
        st.lists(
            st.tuples(names, names),
            min_size=6,
            max_size=6,
            unique_by=(lambda p: p[0], lambda p: p[1]),
        )
    )
    constraints = []
    for kind, (platform, base) in zip(kinds, pairs, strict=True):
        side = draw(st.sampled_from(Side)) if kind in ("DPH", "DHP") else Side.BOTH
        value = draw(positive if kind[0] == "D" else st.just(parse_number("acos(1/3)")))
        constraints.append(
            Constraint(
                KINDS_BY_NAME[kind],
                makers[kind[1]](),
                makers[kind[2]](),
                value,
                side,
                platform,
                base,
            )
        )
    name = draw(st.none() | texts)
    return Instance(tuple(constraints), Units(draw(texts), draw(st.sampled_from(AngleUnit))), name)


def never_anything_but_a_spec_error(text):
    mistakes = ()
    try:
        read_text(text)
    except SpecError as error:
        mistakes = error.mistakes or (None,)
    assert all(mistake.message for mistake in mistakes)
    assert all(line.isprintable() for mistake in mistakes for line in str(mistake).split("\n"))


@QUICK
@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text):
    never_anything_but_a_spec_error(text)


@QUICK
@given(st.text(st.sampled_from("[]{}:,-?&*!|>'\"%@`#\\x0\n\t ~.aP1"), max_size=60))
def test_any_punctuation_is_read_or_refused(text):
    never_anything_but_a_spec_error(text)


@QUICK
@given(st.randoms(use_true_random=False))
def test_a_damaged_file_is_read_or_refused(rng: random.Random):
    text = TEXT
    for _ in range(rng.randint(1, 4)):
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.choice([0, 1, 1, 2, 20]))
        new = rng.choice(
            ["", "-", ":", "[", "}", "\t", "\n", "\0", "*a", "&a ", "!x ", "1e9", "'", "null", "²"]
        )
        text = text[:start] + new + text[end:]
    never_anything_but_a_spec_error(text)


@QUICK
@given(st.text("0123456789.+-*/()episqrtcoan ", max_size=25))
def test_any_expression_is_a_number_or_a_value_error(text):
    number = _readable(text)
    if number is not None:
        assert parse_number(str(number)) == number


@QUICK
@given(expressions)
def test_an_expression_has_the_value_of_its_text(text):
    number = _readable(text)
    if number is not None:
        assert number.value == pytest.approx(float(_python(text)), rel=1e-9, abs=1e-9)
        assert parse_number(str(number)) == number


def _python(text):
    import math

    return eval(text, {"__builtins__": {}}, vars(math))


@settings(QUICK, max_examples=10)
@given(instances())
def test_what_is_written_reads_back(instance):
    assert loads(dumps(instance)) == instance


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_written_exactly(path):
    instance = loads(path.read_text(encoding="utf-8"))
    assert loads(dumps(instance)) == instance
