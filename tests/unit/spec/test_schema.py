"""The published JSON Schema: up to date, true of the examples, false of wrong files."""

import copy
import json
from pathlib import Path

import jsonschema
import pytest
import yaml

from gspcli.resources import data_directory
from gspcli.spec.schema import json_schema

PUBLISHED = Path(__file__).resolve().parents[3] / "docs" / "instance.schema.json"
EXAMPLES = sorted((data_directory() / "examples").glob("*.yaml"))
VALIDATOR = jsonschema.Draft202012Validator(json_schema())


def test_the_published_schema_is_up_to_date():
    recorded = json.loads(PUBLISHED.read_text(encoding="utf-8"))
    assert recorded == json_schema(), "run python -m tools.build.schema"
    jsonschema.Draft202012Validator.check_schema(recorded)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_conform(path):
    VALIDATOR.validate(yaml.safe_load(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("units"), "'units' is a required property"),
        (lambda d: d.update(nmae="x"), "Additional properties are not allowed"),
        (lambda d: d["constraints"].pop(), "is too short"),
        (lambda d: d["platform"]["P1"].update(point=[0, 0]), "is too short"),
        (lambda d: d["platform"]["P1"].clear(), "is not valid under any of the given schemas"),
        (lambda d: d["constraints"][0].update(side="up"), "'up' is not one of"),
        (lambda d: d["constraints"][0].pop("value"), "'value' is a required property"),
        (lambda d: d["platform"].update({"a b": {"point": [0, 0, 0]}}), "does not match"),
        (lambda d: d.update(gsp=2), "1 was expected"),
    ],
)
def test_wrong_files_do_not_conform(change, message):
    document = copy.deepcopy(
        yaml.safe_load((EXAMPLES[0].parent / "example-6.8.yaml").read_text(encoding="utf-8"))
    )
    change(document)
    errors = [error.message for error in VALIDATOR.iter_errors(document)]
    assert len(errors) == 1
    assert message in errors[0]
