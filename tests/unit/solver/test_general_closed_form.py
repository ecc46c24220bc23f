"""The closed form of one platform at once: as the one of many sets of values finds them."""

from itertools import islice

import numpy as np
import pytest

from bench.cases import random_instances
from gspcli import load, solve
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.numbers import Number
from gspcli.resources import data_path
from gspcli.solver.closed_form import solve_closed_form
from gspcli.solver.closed_form_proofs import proved_closed_form, proved_general_form

TYPES = (
    "DPL DPL DLP 3ALL",
    "DLL DLP DPP 3ALL",
    "DPH DPL DPP ALL ALH AHH",
    "DPP DPP DPP 3AHH",
)


@pytest.mark.parametrize("type_text", TYPES)
def test_poses_accounts_and_proofs_are_those_of_the_careful_way(type_text):
    compared = 0
    for instance in islice(random_instances(type_text, 5), 4):
        arrangement, proofs = Arrangement.of(instance), ValueProofs.of(instance, None)
        quick = proved_general_form(proofs, arrangement)
        careful = proved_closed_form(proofs, arrangement, solve_closed_form(arrangement))
        if quick is None or careful is None or careful.proof is None:
            continue
        compared += 1
        quick, careful = (poses.in_order(arrangement.length) for poses in (quick, careful))
        assert (quick.account, quick.proof) == (careful.account, careful.proof)
        assert len(quick.R) == instance.expected
        np.testing.assert_array_equal(quick.real, careful.real)
        np.testing.assert_allclose(quick.R, careful.R, rtol=0, atol=1e-9)
        np.testing.assert_allclose(quick.T, careful.T, rtol=0, atol=1e-8 * arrangement.length)
    assert compared > 1


def test_what_is_special_goes_the_careful_way():
    example = load(str(data_path("examples", "example-6.8.yaml")))
    special = example.with_values({5: Number.of("sqrt(52)")})  # cylinders touch
    (general,) = islice(random_instances("DPL DPL DLP 3ALL", 5), 1)
    two_sided = next(random_instances("DPH DPL DPP 3ALL", 5, one_sided=False))
    for instance in (special, two_sided):
        proofs = ValueProofs.of(instance, None)
        assert proved_general_form(proofs, Arrangement.of(instance)) is None
    assert solve(general, certify=False).proof is None
    assert solve(two_sided).verdict == "complete"
