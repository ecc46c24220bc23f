"""The shipped JSON Schema: up to date, true of all shipped files, false of wrong files."""

import copy
import json

import jsonschema
import pytest
import yaml

from gspcli.cli.main import run
from gspcli.resources import data_directory
from gspcli.spec import loads
from gspcli.spec.form_of_instance import EDITOR_LINE, FILE_NAME, json_schema

PUBLISHED = data_directory() / FILE_NAME
SHIPPED = sorted(data_directory().glob("*/*.yaml"))
EXAMPLE = data_directory() / "examples" / "example-6.8.yaml"
#: The keys that no shipped file has, and others.
ALL_KEYS = """\
gsp: 1
name: every key
source: a test
type: 6PP
units: {length: mm, angle: deg}
platform:
  P1: {point: [60, 0, 0], cone: {axis: [0, 0, -1], half_angle: 60}}
  P2: {point: [30, 50, 0]}
  P3: {point: [-30, 50, 0]}
  P4: {point: [-60, 0, 0]}
  P5: {point: [-30, -50, 0]}
  P6: {point: [30, -50, 0]}
  P7: {point: [0, 0, 10]}
base:
  B1:
    point: [100, 30, 0]
    crank: {centre: [100, 10, 0], axis: [1, 0, 0], range: [-60, 60], tolerance: 1, scale: 0.1}
  B2:
    point: [30, 100, 0]
    slide: {direction: [0, 0, 1], range: [-50, 50], tolerance: 1, offset: 1}
  B3: {point: [-30, 100, 0], with: B2}
  B4: {point: [-100, 30, 0]}
  B5: {point: [-40, -100, 0]}
  B6: {point: [40, -100, 0]}
  B7: {point: [0, 0, 0]}
constraints:
  - {distance: [P1, B1], value: home}
  - {distance: [P2, B2], value: home}
  - {distance: [P3, B3], value: home}
  - {distance: [P4, B4], value: home}
  - {distance: [P5, B5], value: home}
  - {distance: [P6, B6], value: 120, range: [80, 2*80], tolerance: 0.1, offset: 0.2, scale: 1/1000}
home: {position: [0, 0, 100], rx: 1, ry: 2, rz: 3, euler: PI}
frames:
  tool: {point: [0, 0, 10], rz: 30, euler: xyz}
  work: {point: [0, 0, 10], quaternion: [1, 0, 0, 1]}
readings: [leg P7 B7 = 110 ± 1, z = 100 ± 2]
shapes: {diameter: [1, 2, 3, 4, 5, 1/3], platform: [[0, 0, 1]], base: [[0, 0, 0]], near_joint: 1}
dynamics:
  gravity: [0, 0, -9.81]
  platform: {mass: 3, centre: [0, 0, 1], inertia: [1, 1, 1, 0, 0, 0]}
  legs:
    - {rod: {mass: 0.2, centre: 50, inertia: 200}}
    - {rod: {mass: 0.2, centre: 50, inertia: 200}}
    - {rod: {mass: 0.2, centre: 50, inertia: 200}}
    - {rod: {mass: 0.2, centre: 50, inertia: 200}}
    - {rod: {mass: 0.2, centre: 50, inertia: 200}}
    - {cylinder: {mass: 0.35, centre: 60, inertia: 450, axial: 40}, universal: [1, 0, 0]}
  arms: {mass: 0.1, centre: 10, inertia: 0.4}
  carriages: {mass: 0.2}
  drives: {inertia: [1, 1, 1, 1, 1], stiffness: 2.0e6}
"""
VALIDATOR = jsonschema.Draft202012Validator(json_schema())


def test_the_published_schema_is_up_to_date():
    recorded = json.loads(PUBLISHED.read_text(encoding="utf-8"))
    assert recorded == json_schema(), "run python -m tools.data.schema"
    jsonschema.Draft202012Validator.check_schema(recorded)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_files_conform(path):
    VALIDATOR.validate(yaml.safe_load(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_first_line_of_shipped_files_leads_editors_to_the_schema(path):
    first = path.read_text(encoding="utf-8").partition("\n")[0]
    address = first.removeprefix("# yaml-language-server: $schema=")
    assert address != first
    assert (path.parent / address).resolve() == PUBLISHED.resolve()


@pytest.mark.parametrize(
    "words",
    [
        ["new", "6PP", "--template"],
        ["new", "3D3A", "PL", "PL", "LP", "ALL", "ALH", "AHH", "--template"],
        ["new", "--rotary", "base=80,12", "platform=55,10", "horn=24", "rod=130", "--template"],
        ["new", "--linear", "base=200,0", "platform=50,30", "rod=250", "rails=3", "--template"],
        ["example", "delta"],
        ["example", "workspace-study-cones"],
    ],
    ids=lambda words: "-".join(words[:2]),
)
def test_what_commands_write_conforms_to_the_schema_beside_it(words, tmp_path):
    path = tmp_path / "machine.yaml"
    assert run([*words, "-o", str(path)]) == 0
    assert run(["check", "--schema", "-o", str(tmp_path / FILE_NAME)]) == 0
    text = path.read_text(encoding="utf-8")
    assert text.startswith(EDITOR_LINE)
    address = text.partition("\n")[0].partition("$schema=")[2]
    schema = json.loads((tmp_path / address).read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(yaml.safe_load(text))


def _keys(document):
    if isinstance(document, dict):
        for key, value in document.items():
            yield key
            yield from _keys(value)
    elif isinstance(document, list):
        for value in document:
            yield from _keys(value)


def test_a_file_with_every_key_conforms():
    """A key that is added to the format must be added here."""
    document = yaml.safe_load(ALL_KEYS)
    VALIDATOR.validate(document)
    assert loads(ALL_KEYS, name="keys").home.euler == "XYZ"
    schema = json_schema()
    sections = [schema, *schema["$defs"].values()]
    known = {key for section in sections for key in section.get("properties", {})}
    others = (yaml.safe_load(path.read_text(encoding="utf-8")) for path in SHIPPED)
    assert known <= {*_keys(document), *_keys(list(others))}


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
    document = copy.deepcopy(yaml.safe_load(EXAMPLE.read_text(encoding="utf-8")))
    change(document)
    errors = [error.message for error in VALIDATOR.iter_errors(document)]
    assert len(errors) == 1
    assert message in errors[0]


def test_a_quaternion_of_a_frame_has_four_numbers():
    document = yaml.safe_load(ALL_KEYS)
    document["frames"]["work"]["quaternion"] = [1, 0, 0]
    assert "is too short" in next(VALIDATOR.iter_errors(document)).message
