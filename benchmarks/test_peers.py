"""The benchmarks ask every peer for the solutions of the same platform."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import fksgp, macaulay2, machines, msolve, peer_table, phc
from benchmarks.__main__ import _machine_bars, bars, main
from benchmarks.cases import CASES, Case
from benchmarks.homotopy import (
    NAMES,
    Homotopy,
    blackbox_system,
    poses,
    split_name,
    split_system,
    stated_equations,
    written_product,
)
from benchmarks.markdown import duration, table
from benchmarks.peers import Answer, compare
from benchmarks.report import Bar, CaseResult, PeerResult, Report
from benchmarks.sweep import Cost, plot
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import study_from_pose
from gspcli.solver import SolveResult, solve
from gspcli.spec import dumps, loads

SEED = 1
SMALL = [case for case in CASES if case.key not in ("6PL", "6LL")]
CASE = pytest.mark.parametrize("case", SMALL, ids=lambda case: case.key)
TOLERANCE = 1e-9


@cache
def solved(case: Case) -> tuple[Instance, SolveResult, NDArray[np.complex128]]:
    """Return an instance, our solutions, and these as affine points (n, 7)."""
    [instance] = case.draw(SEED, 1)
    result = solve(instance)
    e, f = study_from_pose(result.R, result.T)
    return instance, result, np.concatenate((e[:, 1:], f), axis=1) / e[:, :1]


def worst(text: str, imaginary: str, names: list[str], points: NDArray[np.complex128]) -> float:
    """Return the largest value of a polynomial given as text, relative to that of its terms."""
    python = re.sub(rf"\*{imaginary}\b", "*1j", text.replace("^", "**"))
    known = dict(zip(names, points.T, strict=True))
    value = np.abs(eval(python, {}, known))
    # The same with nothing cancelling: signs dropped, and sizes for the unknowns.
    sizes = {name: np.abs(x) for name, x in known.items()}
    scale = np.abs(eval(re.sub(r"(?<!e)-", "+", python), {}, sizes))
    return float((value / (1 + scale)).max())


@CASE
def test_msolve_gets_our_equations(case: Case) -> None:
    instance, _, points = solved(case)
    names, characteristic, *rows = msolve.written(blackbox_system(instance)).splitlines()
    assert characteristic == "0"
    assert len(rows) == 7
    for row in rows:
        assert worst(row.rstrip(","), "I", names.split(","), points) < TOLERANCE


@CASE
def test_phc_gets_our_equations(case: Case) -> None:
    instance, _, points = solved(case)
    for row in Homotopy.of(instance, SEED).target:
        text = phc.written_sum(row).replace("E", "e")
        assert worst(text, "I", list(NAMES), points) < TOLERANCE


def test_products_are_split_by_one_unknown_each() -> None:
    case = next(case for case in CASES if case.split)
    instance, _, points = solved(case)
    rows = split_system(instance)
    assert len(rows) == 7 + 3
    unknowns = []
    texts = [phc.STYLE.written(row).replace("E", "e") for row in rows]
    names = [split_name(k) for k in range(3)]
    for name in names:
        # Of the two rows with u the second is u H = d N, the first G = d N u: solve the second.
        row = [text for text in texts if f"*{name}" in text][1]
        known = dict(zip(NAMES, points.T, strict=True))
        python = row.replace("^", "**").replace("*I", "*1j")
        zero, one = (eval(python, {}, known | {name: np.complex128(u)}) for u in (0, 1))
        unknowns.append(-zero / (one - zero))
    full = np.concatenate((points, np.array(unknowns).T), axis=1)
    assert all(worst(text, "I", [*NAMES, *names], full) < TOLERANCE for text in texts)


@CASE
def test_peers_start_at_solutions(case: Case) -> None:
    instance, result, _ = solved(case)
    homotopy = Homotopy.of(instance, SEED)
    assert len(homotopy.points) == result.expected
    for row in homotopy.start:
        text = "+".join(written_product(macaulay2.STYLE, pair) for pair in row)
        # Start solutions are stored in single precision.
        assert worst(text, "ii", list(NAMES), homotopy.points) < 1e-4


def test_solutions_are_written_as_phc_reads_them() -> None:
    points = np.array([[k + 1j / (1 + k) for k in range(7)], np.arange(7) * 1e-9 + 0j])
    assert np.array_equal(phc.read_solutions(phc.written_solutions(points)), points)


def test_instances_can_be_written_and_read() -> None:
    for case in CASES:
        [instance] = case.draw(SEED, 1)
        again = loads(dumps(instance))
        assert again.constraints == instance.constraints


def test_irrational_lengths_are_refused() -> None:
    text = dumps(solved(next(case for case in CASES if case.key == "6PH"))[0])
    crooked = loads(re.sub(r"normal: \[[^\]]*\]", "normal: [1, 1, 1]", text))
    with pytest.raises(ValueError, match=r"irrational: sqrt\(3\)"):
        stated_equations(crooked)


def test_faults_of_peers_are_counted() -> None:
    _, result, points = solved(CASES[0])
    stranger = np.full((1, 7), 0.5 + 0.25j)
    answer = Answer(1.0, np.concatenate((points[1:], points[-2:], stranger)))
    comparison = compare(answer, result)
    assert (comparison.complex_count, comparison.lost) == (39, 1)
    assert (comparison.duplicated, comparison.extra) == (2, 1)
    assert not comparison.clean
    assert comparison.real == result.counts.real - 1
    whole = compare(Answer(1.0, points), result)
    assert whole.clean
    assert whole.real == result.counts.real
    R, _ = poses(points)
    assert np.allclose(R, result.R)


def test_an_exact_peer_lists_the_real_ones() -> None:
    _, result, points = solved(CASES[0])
    real = points[: result.counts.real]
    assert compare(Answer(1.0, real, 40), result).clean
    assert compare(Answer(1.0, real[1:], 40), result).lost == 1
    assert compare(Answer(1.0, real, 39), result).lost == 1


STUB = """
import numpy as np

def {name}(X, x, L, realOnly):
    assert not X[0].any() and not x[0].any()
    found = np.load({file!r})
    legs = found[:, :, :3] @ x.T + found[:, :, 3:] - X.T
    assert np.allclose((legs * legs).sum(axis=1), L)
    real = ~np.iscomplex(found).any(axis=(1, 2))
    return found[real] if realOnly else found, None
"""


@pytest.mark.parametrize(("key", "name"), [("6-6", "solver66"), ("planar 6-6", "solver6p6p")])
def test_fksgp_is_asked_in_frames_that_begin_at_the_first_points(
    key: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A copy that has our poses, in those frames, returns them; planar ones separately."""
    instance, result, _ = solved(next(case for case in CASES if case.key == key))
    y, x = result.arrangement.y[0], result.arrangement.x[0]
    t = result.T - x + result.R @ y
    np.save(tmp_path / "poses.npy", np.concatenate((result.R, t[:, :, None]), axis=2))
    (tmp_path / "python").mkdir()
    assert fksgp.version(tmp_path) == fksgp.version(None) == ""
    source = STUB.format(file=str(tmp_path / "poses.npy"), name=name)
    (tmp_path / "python" / "solver66.py").write_text("", encoding="utf-8")
    (tmp_path / "python" / f"{name}.py").write_text(source, encoding="utf-8")
    assert fksgp.version(tmp_path).startswith("sha256 ")
    modules = ("_fksgp", f"_fksgp.{name}")
    for module in modules:
        monkeypatch.delitem(sys.modules, module, raising=False)
    assert compare(fksgp.solve(tmp_path, instance, SEED), result).clean
    for module in modules:
        del sys.modules[module]
    assert [case.key for case in SMALL if fksgp.can(case)] == ["6-6", "planar 6-6", "Dietmaier"]


@pytest.mark.parametrize("given", ["fksgp", "other=.", "fksgp=nowhere"])
def test_a_peer_without_a_copy_is_refused(
    given: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["bench", "--peer", given])
    with pytest.raises(SystemExit):
        main()
    assert f"--peer {given}: " in capsys.readouterr().err


def test_bars_and_tables() -> None:
    assert Bar("a", 2.4, 12.34).cells == ["a", "≥ 2.4 times", "12 times", "met"]
    assert Bar("b", 20, 19).cells[3] == "**missed**"
    assert table(["x", "y"], [["1", "2"]]) == "| x | y |\n| --- | ---: |\n| 1 | 2 |\n"
    assert [duration(x) for x in (12.3, 0.0456, 7e-6)] == ["12 s", "46 ms", "7 µs"]


def test_the_page_states_the_worst_ratio_first() -> None:
    report = Report(1, 1.0, True, {})
    for case, seconds in zip(CASES, (3.0, 2.0), strict=False):
        asked = {"quick": PeerResult([seconds], [], ""), "slow": PeerResult([9.0], [], "")}
        report.cases.append(CaseResult(case, 40, [40], [2], 1.0, asked))
    report.bars = bars(report)
    assert [bar.measured for bar in report.bars] == [2.0, 3.0]
    text = report.markdown()
    assert text.index("The lowest ratio is 2") < text.index("quick over gsp | ≥")


def test_the_plot_has_a_dot_for_each_family() -> None:
    rows = [Cost(f"f{n}", "paths", n, n, 2, "complete", 0.1 * n) for n in (8, 40, 4096)]
    one_less = plot(rows[::2])
    assert plot(rows).count(b"<use") == one_less.count(b"<use") + 1


def test_libraries_are_loaded_with_one_thread() -> None:
    """Else the waiting of the others counts as processor time."""
    given = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    code = (
        "import benchmarks, os, sys; assert 'numpy' not in sys.modules; import benchmarks.own;"
        "import numpy as np; a = np.ones((400, 400));"
        "a @ a; print(os.environ['OPENBLAS_NUM_THREADS'], len(os.listdir('/proc/self/task')))"
        if sys.platform == "linux"
        else "import benchmarks, os; print(os.environ['OPENBLAS_NUM_THREADS'], 1)"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], env=given, capture_output=True, text=True, check=True
    )
    assert found.stdout.split() == ["1", "1"]


def test_of_sampled_machines_the_median_and_the_worst_are_shown() -> None:
    one = machines.MachineResult("t-top-head", 9.0, 9.0, 9.0, 9.0)
    drawn = [
        machines.MachineResult(f"sampled 6-6/{k}", 0.01 * k, 0.001, 1e-4 * k, 0.006)
        for k in (1, 2, 6)
    ]
    shipped, middle, worst = machines.lines([one, *drawn])
    assert (shipped.name, shipped.ratios) == ("t-top-head", [1, 1, 1])
    assert middle.name == "3 sampled machines, median"
    assert (middle.seconds[0], worst.seconds[0]) == (0.02, 0.06)
    assert worst.seconds[2] == pytest.approx(6e-4)
    # The median and the least of the ratios, not ratios of medians.
    assert middle.ratios[0] == pytest.approx(0.3)
    assert worst.ratios[0] == pytest.approx(0.1)
    assert len(list(machines.lines([one]))) == 1


def test_the_bars_of_first_solutions_are_those_of_sampled_machines() -> None:
    report = Report(seed=1, limit=1.0, quick=True, versions={})
    report.machines = [
        machines.MachineResult(f"sampled 6-6/{k}", 0.01 * k, 0.001, 1e-4, 0.006) for k in (1, 2, 6)
    ]
    bars = {bar.name: bar.measured for bar in _machine_bars(report)}
    assert bars["sampled machines, first, median, fkSGP over gsp"] == pytest.approx(0.3)
    assert bars["sampled machines, first, least, fkSGP over gsp"] == pytest.approx(0.1)
    assert "3 sampled machines, worst" in report.markdown()


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.02, "3.3 times quicker"), (0.002, "3 times slower")]
)
def test_the_readme_says_what_a_first_solution_of_sampled_machines_costs(
    seconds, said, monkeypatch, tmp_path
) -> None:
    report = Report(seed=1, limit=1.0, quick=True, versions={})
    report.machines = [
        machines.MachineResult(name, seconds, 0.001, 1e-4, 0.006)
        for name in ("t-top-head", "sampled 6-6/1")
    ]
    page = tmp_path / "benchmarks.md"
    page.write_text(report.markdown())
    monkeypatch.setattr(peer_table, "BENCHMARKS", page)
    real, sampled = peer_table._machines()
    assert real[0] == "1 real machines, first solve"
    assert sampled[:3] == ["1 sampled machines, first solve, median", f"{1e3 * seconds:g} ms", said]
