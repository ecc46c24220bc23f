"""The recorded generic counts: complete, consistent, below every proved bound."""

from __future__ import annotations

import csv
import hashlib
import json
from pathlib import Path

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.counts import (
    FAMILIES_FILE,
    FOLDER,
    Method,
    all_families,
    family_counts,
    generic_counts,
    mirrored,
)
from gspcli.catalogue.kinds import DLL, DPH, DPL, DPP
from gspcli.catalogue.types import all_types
from gspcli.resources import data_path
from tools.atlas.intersection_numbers import NUMBERS_FILE, intersection_number, law
from tools.atlas.records import COLUMNS, MANIFEST_FILE
from tools.atlas.tasks import PRIMES, TOLERANCE, Task, monodromy_counts


def _rows(name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(data_path(FOLDER, name).read_text(encoding="utf-8").splitlines()))


def test_the_manifest_describes_the_files() -> None:
    manifest = json.loads(data_path(FOLDER, MANIFEST_FILE).read_text(encoding="utf-8"))
    for name, digest in manifest["sha256"].items():
        assert hashlib.sha256(data_path(FOLDER, name).read_bytes()).hexdigest() == digest
        assert list(_rows(name)[0]) == list(COLUMNS[name]) == list(manifest["columns"][name])
    assert tuple(manifest["primes"]) == PRIMES
    folder = data_path(FOLDER, MANIFEST_FILE).parent
    assert {p.name for p in Path(folder).iterdir()} == {*manifest["sha256"], MANIFEST_FILE}


def test_the_119_numbers_were_found_in_two_more_ways() -> None:
    rows = _rows(NUMBERS_FILE)
    assert {row["spaces"]: int(row["monodromy"]) for row in rows} == monodromy_counts()
    assert len(rows) == 119
    for row in rows:
        assert int(row["number"]) == intersection_number(row["spaces"])
        assert row["orders"].split() == [row["number"]] * len(PRIMES)
        assert row["number"] == row["monodromy"]


def test_every_family_was_confirmed_in_its_own_right() -> None:
    rows = {row["family"]: row for row in _rows(FAMILIES_FILE)}
    assert len(rows) == 896
    for family in all_families():
        row, counts = rows[family.id], family_counts(family)
        assert {Method.TRACKING, Method.TRACE} <= set(counts.confirmed)
        assert row["certified"] == row["one_sided"]
        assert float(row["trace"]) < TOLERANCE * float(row["trace_without_one"])
        assert (Method.GROEBNER in counts.confirmed) == bool(row["orders"])
        assert row["orders"].split() in ([], [row["one_sided"]] * len(PRIMES))
        assert row["two_sided_orders"].split() in ([], [row["two_sided"]] * len(PRIMES))
        assert row["two_sided_certified"] in ("", row["two_sided"])


def test_the_law_holds_for_all_families() -> None:
    for family in all_families():
        counts = family_counts(family)
        assert counts.one_sided == law(family.distances)
        sides = sum(kind.has_sides for kind in family.distances)
        assert counts.two_sided == 2**sides * counts.one_sided


def test_exchanging_platform_and_base_changes_nothing() -> None:
    by_distances = {family.distances: family_counts(family) for family in all_families()}
    for distances, counts in by_distances.items():
        image = by_distances[mirrored(distances)]
        assert (image.one_sided, image.two_sided) == (counts.one_sided, counts.two_sided)


def test_no_count_exceeds_a_bound() -> None:
    for gsp_type in all_types():
        counts, bounds = generic_counts(gsp_type), type_bounds(gsp_type)
        assert counts.one_sided <= bounds.refined_one_sided.value
        assert counts.two_sided <= bounds.refined_two_sided.value
        assert counts.two_sided <= min(bounds.theorem_5_2.value, bounds.theorem_5_3.value)
        if bounds.theorem_5_4 is not None:
            assert counts.one_sided <= bounds.theorem_5_4.value
        if bounds.table_3 is not None:
            # The paper counts one of the two planes of a DLL (Theorem 6.9).
            assert counts.one_sided == 2 ** gsp_type.count(DLL) * bounds.table_3.value


def test_where_theorem_5_3_is_sharp() -> None:
    for gsp_type in all_types():
        sharp = type_bounds(gsp_type).theorem_5_3.value == generic_counts(gsp_type).two_sided
        few = len(gsp_type.angles) <= 1 and gsp_type.count(DPP) >= 3
        assert sharp == (few and {*gsp_type.distances} <= {DPP, DPL, DPH})


def test_no_family_with_three_angles_has_another_count_than_table_3_by_hand() -> None:
    # Eight rotations; planes and at most one sphere for T; two factors for each product.
    for family in all_families():
        if family.platform_class.angles == 3:
            products = sum(kind.is_product for kind in family.distances)
            spheres = 2 if DPP in family.distances else 1
            assert family_counts(family).one_sided == 8 * spheres * 2**products


def test_tasks_expect_what_is_recorded() -> None:
    from tools.atlas.records import recorded

    for subject, sides in (("pppqqq", 1), ("DPL DPL DPH DHP DHP DLL", 2), ("DPP DPL DLP", 1)):
        task = Task(subject, sides, PRIMES[0])
        assert recorded(task) == task.expected
