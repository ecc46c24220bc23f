"""The example instances: recorded counts belong to them and the solver finds just these."""

import hashlib

import pytest

from gspcli.resources import INSTANCE_FOLDERS, data_json, instance_files
from gspcli.solver.api import solve
from gspcli.spec import load

FILES = instance_files()
EXPECTED = {
    name: record
    for folder in INSTANCE_FOLDERS
    for name, record in data_json(folder, "expected.json")["examples"].items()
}


def test_every_example_has_its_record():
    assert set(EXPECTED) == set(FILES), "run python -m tools.data.example_counts"


@pytest.mark.parametrize("path", FILES.values(), ids=lambda path: path.stem)
def test_the_solver_finds_the_recorded_counts(path):
    record = EXPECTED[path.stem]
    content = hashlib.sha256(path.read_bytes()).hexdigest()
    assert content == record["sha256"], "run python -m tools.data.example_counts"
    instance = load(path)
    assert instance.type.id == record["type"]
    result = solve(instance)
    if record["dimension"] > 0:
        assert result.verdict == "infinite"
    else:
        assert result.verdict == "complete"
        assert sum(solution.multiplicity for solution in result.solutions) == record["complex"]
        assert result.counts.found == record["distinct"]
        assert result.counts.real == record["real"]
