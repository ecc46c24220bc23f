"""Files without mistakes are read with the same result as by the models."""

from __future__ import annotations

import random
import re
import subprocess
import sys
from copy import deepcopy
from pathlib import Path

import pytest

from gspcli.resources import instance_files
from gspcli.spec.document import Mapping, Scalar, Sequence, locate
from gspcli.spec.models import InstanceModel
from gspcli.spec.ordinary import read_ordinary
from gspcli.spec.plain import InstanceFields, read_plainly

FILES = instance_files()
#: Texts that are right somewhere, or nowhere.
TEXTS = ["", "0", "1", "-2.5", "sqrt(2)", "sqrt(", "deg", "both", "P1", "a b", "x" * 2000, "\x01"]
TEXTS += ["dynamics", "legs", "rod", "mass", "centre", "inertia", "drives", "universal"]
TEXTS += ["point", "line", "plane", "value", "crank", "cone", "range", "angle", "distance"]


def fields(part):
    """Return the fields of models or of what is read plainly as plain data."""
    if isinstance(part, dict):
        return {str(key): fields(value) for key, value in part.items()}
    if hasattr(part, "_fields"):
        return {key: fields(getattr(part, key)) for key in part._fields}
    return [fields(value) for value in part] if isinstance(part, list) else part


def modelled(model, like):
    """Return those fields of a model that the plain reading has."""
    if isinstance(like, dict):
        return {key: modelled(model[key], value) for key, value in like.items()}
    if hasattr(like, "_fields"):
        return {key: modelled(getattr(model, key), getattr(like, key)) for key in like._fields}
    if isinstance(like, list):
        assert len(model) == len(like)
        return [modelled(*pair) for pair in zip(model, like, strict=True)]
    return model


def check(root, found: InstanceFields):
    mistakes = []
    model = InstanceModel.model_validate(root, context=mistakes)
    assert not mistakes
    assert set(model.platform) == set(found.platform)
    assert modelled(model, found) == fields(found)


PAGE = Path(__file__).resolve().parents[3] / "docs" / "dynamics.md"
#: With masses, which no shipped file has: one leg for all, and a list of legs.
WITH_MASSES = re.search(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
LEGS = "  legs:\n" + "    - {rod: {mass: 0.2, centre: 50}}\n" * 6
TEXTS_OF_FILES = {
    **{name: path.read_text(encoding="utf-8") for name, path in FILES.items()},
    "one-leg": WITH_MASSES,
    "thick": FILES["workspace-study"].read_text(encoding="utf-8") + "shapes: {diameter: 20}\n",
    "thick-legs": FILES["workspace-study"].read_text(encoding="utf-8")
    + "shapes: {diameter: [1, 2, 3, 4, 5, 6], platform: [[1, 2, 3]], near_joint: 1/2}\n",
    "six-legs": re.sub(r"  legs:.*?(?=  drives)", LEGS, WITH_MASSES, flags=re.DOTALL),
}


def roots():
    return [read_ordinary(text, name) for name, text in TEXTS_OF_FILES.items()]


@pytest.mark.parametrize("root", roots(), ids=TEXTS_OF_FILES)
def test_shipped_files_are_read_plainly(root):
    found = read_plainly(root)
    assert found is not None
    check(root, found)


def parts(value):
    """Return all mappings and lists of a document."""
    inside = value.values() if isinstance(value, Mapping) else value
    below = [part for entry in inside if not isinstance(entry, Scalar) for part in parts(entry)]
    return [value, *below]


def changed(root, rng):
    """Return a document with something put in, taken out or replaced."""
    root = deepcopy(root)
    part = rng.choice(parts(root))
    place = part.location, part.path
    new = rng.choice(
        [Scalar(rng.choice(TEXTS)), Sequence(), Mapping(), Sequence(map(Scalar, "123"))]
    )
    for entry in (new, *(new if isinstance(new, Sequence) else ())):
        locate(entry, *place)
    if isinstance(part, Sequence):
        at = rng.randrange(len(part) + 1)
        part[at : at + rng.randrange(2)] = [new] * rng.randrange(2)
    else:
        keys = list(part)
        if keys and rng.random() < 0.7:
            kept = part.pop(old := rng.choice(keys))
            new, key = rng.choice([(kept, None), (new, old)])
        else:
            key = None
        if rng.random() < 0.7:
            part[key or locate(Scalar(rng.choice(TEXTS)), *place)] = new
    return root


def test_what_is_accepted_plainly_is_accepted_by_the_models():
    rng, known = random.Random(1), roots()
    accepted = 0
    for _ in range(300):
        root = changed(rng.choice(known), rng)
        found = read_plainly(root)
        if found is not None:
            check(root, found)
            accepted += 1
    assert 10 < accepted < 200


def test_files_without_mistakes_need_no_pydantic():
    name = str(FILES["dietmaier"])
    code = f"import sys, gspcli; gspcli.load({name!r}); sys.exit('pydantic' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
