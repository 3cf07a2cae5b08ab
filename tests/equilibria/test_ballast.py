"""Ballast: the subjects, rows, changes of the number of rests, rotations and equivalent ballast."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from gomboc_cad.body import Body, catalog, catalogue_entries
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.equilibria import mesh_census
from gomboc_cad.equilibria.ballast import (
    BallastShape,
    BallastSubject,
    ballast_rows,
    ballast_subject,
    body_subject,
    equivalent_ballast,
    rest_changes,
    turned_counts,
)
from gomboc_cad.equilibria.round_solids import EllipsoidShape
from gomboc_cad.errors import CensusError

NAMES: tuple[BallastShape, ...] = get_args(BallastShape)


@pytest.fixture(scope="module")
def flat_ellipsoid() -> BallastSubject:
    """Semi-axes 1.05, 1 and 0.95: two rests until the COM is lowered by b²/c − c = 0.10263."""
    return body_subject(Body("flat", EllipsoidShape((1.05, 1.0, 0.95)), 1.0))


@pytest.mark.parametrize("name", NAMES)
def test_solid_and_mesh_are_the_same_body(name: BallastShape) -> None:
    """The exact rests have the heights of the mesh, and the given centroid is that of the mesh."""
    subject = ballast_subject(name)
    mass = mesh_mass(*subject.mesh)
    np.testing.assert_allclose(mass.com_mm, subject.centroid_mm, atol=2e-5)
    com = subject.com_mm(0.1)
    census = mesh_census(*subject.mesh, com, probabilities=False)
    assert subject.rests(com)[0].height_mm == pytest.approx(census.rest.height_mm, abs=2e-3)
    assert subject.lowest_mm[2] == subject.mesh.vertices[:, 2].min()


def test_ballast_follows_the_papers_law() -> None:
    subject = ballast_subject("cube")
    np.testing.assert_allclose(subject.com_mm(0.25), 0.25 * np.array(subject.lowest_mm), atol=1e-15)
    np.testing.assert_allclose(subject.com_mm(0.25, (0.0, 0.4, 0.0)), (0.0, 0.1, 0.0), atol=1e-15)


def test_rows_carry_truth_and_readings() -> None:
    rows = ballast_rows(ballast_subject("cube"), (0.0, 0.3), rotations=5)
    assert [(row.stable, row.extent, len(row.oracle)) for row in rows] == [(6, "point", 6), (6, "point", 6)]
    assert rows[0].oracle[0] == 3
    assert len(set(rows[0].oracle)) > 1


def test_the_change_of_an_ellipsoid_is_at_its_closed_form(flat_ellipsoid: BallastSubject) -> None:
    """The upper rest goes where the curvature 1/ρ = c/b² meets the COM: `w c = b²/c − c`."""
    (change,) = rest_changes(flat_ellipsoid, 0.05, 0.15, step=0.02)
    assert change.fraction == pytest.approx((1.0 / 0.95 - 0.95) / 0.95, abs=1e-8)
    assert (change.before, change.after) == (2, 1)


def test_a_com_outside_is_refused() -> None:
    for name in ("cube", "capsule"):
        with pytest.raises(CensusError, match="outside"):
            ballast_rows(ballast_subject(name), (0.5,), place_mm=(5.0, 0.0, 0.0))


@pytest.mark.parametrize(("name", "rests"), [("cube", 6), ("cylinder", 3)])
def test_rotations_change_the_oracle_and_not_the_census(name: BallastShape, rests: int) -> None:
    counts = turned_counts(ballast_subject(name), rotations=30)
    assert set(counts.census) == {rests}
    assert len(counts.oracle) == 30
    assert len(set(counts.oracle)) > 1


def test_equivalent_ballast_of_the_primary_and_of_what_is_refuted() -> None:
    figure = equivalent_ballast(catalog()["primary"])
    margin = catalogue_entries()["primary"].evidence.s_margin
    assert margin is not None
    assert figure.s_margin_mm == pytest.approx(50.0 * margin, rel=1e-4)
    assert figure.fraction == pytest.approx(margin, rel=2e-4)
    second = equivalent_ballast(catalog()["second"])
    assert (second.s_margin_mm, second.fraction) == (None, None)
