"""Solutions with N = 0 are no poses, however the kernel rounds N."""

from __future__ import annotations

from gspcli.solver.all_poses import careful_paths
from gspcli.solver.problem import Problem
from gspcli.spec import loads
from tests.support.strategies import added

#: Of its 208 paths 48 lead to infinity, many to simple solutions with N = 0 exactly.
AT_INFINITY = """
gsp: 1
units: {length: unit, angle: rad}
platform:
  P1: {point: [-0.642, 0.502, -0.344]}
  P2: {point: [0.421, 0.441, -0.233]}
  P3: {point: [-0.494, -0.006, -0.697]}
  P4: {point: [0.508, 0.393, 0.638]}
  L1: {line: {point: [0.345, 0.594, -0.754], direction: [-11, 10, -2]}}
  H1: {plane: {point: [-0.071, 0.066, -0.143], normal: [-11, -2, -10]}}
base:
  P1: {point: [0.36, 1.984, 0.624]}
  H1: {plane: {point: [-1.352, -1.302, -0.642], normal: [-10, -11, -2]}}
  H2: {plane: {point: [-1.574, -0.504, -0.45], normal: [-1, -2, 2]}}
  L1: {line: {point: [-0.534, -1.676, -1.458], direction: [7, 4, 4]}}
  H3: {plane: {point: [-1.378, 1.102, -1.314], normal: [6, -6, -7]}}
constraints:
  - {distance: [P1, P1], value: sqrt(4528283/1075000)}
  - {distance: [P2, P1], value: sqrt(394481321/43000000)}
  - {distance: [P3, H1], value: 285257/161250, side: negative}
  - {distance: [P4, H2], value: 4009/3225}
  - {distance: [L1, L1], value: sqrt(1597520961/851562500)}
  - {angle: [H1, H3], value: acos(-478/7095)}
"""


def test_no_solution_at_infinity_is_certified() -> None:
    """Whether a pose is rounded correctly is left out: 160 exist (msolve, modulo two primes)."""
    problem = Problem(loads(AT_INFINITY))
    assert problem.proofs is not None
    (ends,) = added(careful_paths, problem)
    found, _ = problem.proofs.decide(problem.choices, ends.points, ends.frames)
    assert found.certified.shape == (1, 208)
    assert (found.certified.sum(), found.real.sum()) == (160, 10)
