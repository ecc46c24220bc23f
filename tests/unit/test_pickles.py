"""Results and errors go through pickle; functions take the names that commands take."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError, GspError, Location, Mistake, SpecError


def copied(one):
    return pickle.loads(pickle.dumps(one))


def subclasses(kind):
    yield kind
    for one in kind.__subclasses__():
        yield from subclasses(one)


@pytest.mark.parametrize("kind", [*dict.fromkeys(subclasses(GspError))], ids=lambda k: k.__name__)
def test_an_error_is_the_same_after_it(kind):
    if kind is SpecError:
        places = [Mistake(Location("f.yaml", k, 2), "units", f"found {k}") for k in range(7)]
        error = SpecError([*places, Mistake(None, "", "nothing")])
        assert copied(error).mistakes == error.mistakes
    elif issubclass(kind, ArgumentError) and kind is not ArgumentError:
        # A mistake of a row: the row, and what was found.
        error = kind(3, "found 1")
    elif kind is ArgumentError:
        error = ArgumentError("found 1", "lengths[3]")
        assert (copied(error).message, copied(error).where) == ("found 1", "lengths[3]")
    else:
        error = kind("found 1, expected 2")
    again = copied(error)
    assert (type(again), str(again), again.exit_code) == (kind, str(error), error.exit_code)


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.example("rubin-m2")


@pytest.fixture(scope="module")
def solved(hexapod):
    return gspcli.solve(hexapod)


def of_functions(hexapod, solved):
    """Yield what public functions return, by their names."""
    R, T = solved.R[solved.real].real, solved.T[solved.real].real
    values = gspcli.measure(hexapod, R[0], T[0])
    yield "solve", solved
    yield "solve_batch", gspcli.solve_batch(hexapod, np.tile(values, (2, 1)))
    yield "certify", gspcli.certify(hexapod, R, T)
    yield "track", gspcli.track(hexapod, np.stack((values, values * 1.0001)))
    yield "clearance", gspcli.clearance(hexapod, R, T)
    yield "analyze", gspcli.analyze(hexapod, R, T, stiffness=1)
    yield "check", gspcli.check("@nothing")
    yield "count", gspcli.count(hexapod, effort=1e-6)
    yield "derive", gspcli.derive("psc")
    yield "derive expanded", gspcli.derive("ppp", expand=True)
    yield "bound", gspcli.bound("6PP")
    yield "show", gspcli.show("6PP")
    yield "table", gspcli.table(1)
    yield "sample", gspcli.sample("3D3A PH PH PH", 2)
    yield "exported", gspcli.exported(hexapod, "msolve")
    yield "sensors", gspcli.sensors(hexapod)
    yield "atlas_summary", gspcli.atlas_summary()


def test_results_are_the_same_after_it(hexapod, solved):
    for name, result in of_functions(hexapod, solved):
        again = copied(result)
        assert repr(again) == repr(result), name
        if hasattr(result, "to_json") and name not in ("certify",):
            assert repr(again.to_json()) == repr(result.to_json()), name


def test_certificates_prove_the_same_after_it(hexapod, solved):
    proved = gspcli.certify(hexapod, solved.R, solved.T)
    for one, again in zip(proved, copied(proved), strict=True):
        assert (again.certified, again.real, again.outcome) == (
            one.certified, one.real, one.outcome,
        )  # fmt: skip


def test_a_follower_stands_where_it_stood(hexapod, solved):
    pose = solved.real_solutions[0]
    follower = gspcli.Follower(hexapod, pose.R.real, pose.T.real)
    follower.forward(follower.values * 1.001)
    again = copied(follower)
    assert np.allclose(again.values, follower.values, rtol=1e-14)
    assert np.allclose(again.T, follower.T, rtol=1e-12)


@pytest.mark.parametrize("name", sorted({*gspcli.__all__} - {"__version__"}))
def test_functions_and_classes_are_found_by_name(name):
    """What is sent to another process is found there."""
    one = getattr(gspcli, name)
    assert copied(one) is one


def test_functions_take_the_names_that_commands_take():
    assert gspcli.bound("3D3A PL PL LP").subject.id
    assert gspcli.show(421).subject.number == gspcli.show("421").subject.number == 421
    assert gspcli.constraint_facts("PL") == gspcli.constraint_facts("dpl")
    assert gspcli.new("6-3", seed=2) == gspcli.new("6-3", seed=2)
    assert gspcli.new("421").type.number == gspcli.new(421).type.number == 421
    assert gspcli.sample("3D3A PH PH PH", 2).tally.platforms == 2
    for wrong in (lambda: gspcli.bound("6XX"), lambda: gspcli.show("4D2A"),
                  lambda: gspcli.constraint_facts("LL"), lambda: gspcli.new("6QQ"),
                  lambda: gspcli.sample("6PP", -1), lambda: gspcli.bound(None)):  # fmt: skip
        with pytest.raises(GspError):
            wrong()


def test_a_path_and_a_frame_are_taken(tmp_path, hexapod):
    pd = pytest.importorskip("pandas")
    path = tmp_path / "a.yaml"
    gspcli.dump(hexapod, path)
    gspcli.dump(hexapod, str(path))
    assert gspcli.load(path) == hexapod
    base, platform = np.arange(18.0).reshape(6, 3), np.arange(18.0).reshape(6, 3) ** 2 % 7
    given = gspcli.hexapod(base, platform, [1, 2, 3, 4, 5, 6])
    frames = [pd.DataFrame(rows, columns=list("xyz")) for rows in (base, platform)]
    assert gspcli.hexapod(*frames, pd.Series([1, 2, 3, 4, 5, 6])) == given


def test_results_are_equal_after_pickling():
    instance = gspcli.example("nano-hexapod")
    result = gspcli.solve(instance)
    home = result.home
    for one in (
        result,
        result.solutions[0],
        home,
        gspcli.analyze(instance, home),
        gspcli.clearance(instance, home.R, home.T),
        gspcli.freedoms(instance, home.R, home.T),
    ):
        again = pickle.loads(pickle.dumps(one))
        assert again == one
        assert hash(again) == hash(one)
    assert result != gspcli.solve(gspcli.set_values(instance, {1: "0.001"}, delta=True))
