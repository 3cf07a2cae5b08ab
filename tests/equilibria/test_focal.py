"""Samples of folded images of the sphere lie as dense as was asked."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from gomboc_cad.body import Body
from gomboc_cad.equilibria import focal
from gomboc_cad.equilibria.focal import image_samples
from gomboc_cad.equilibria.margin import focal_points_mm
from gomboc_cad.errors import CensusError
from tests.body.shapes import Array, random_directions


def graded(points: Array) -> Array:
    return 0.002 + 0.03 * np.linalg.norm(points - [0.05, 0.0, 0.0], axis=1)


def test_no_point_of_the_focal_sheet_is_farther_than_the_spacing(primary: Body) -> None:
    samples = image_samples(lambda u: focal_points_mm(primary, u, 0), graded)
    points = focal_points_mm(primary, random_directions(100_000, seed=1), 0)
    gap = cKDTree(samples).query(points)[0]
    assert np.max(gap / graded(points)) < 1.0
    on_sheet = cKDTree(points).query(samples)[0]
    assert np.max(on_sheet) < 0.02


def test_the_spacing_is_met_where_everything_is_folded_onto_a_line() -> None:
    def fold(u: Array) -> Array:
        return np.stack([u[:, 0] ** 2, np.zeros(len(u)), np.zeros(len(u))], axis=-1)

    samples = np.sort(image_samples(fold, lambda p: np.full(len(p), 0.01))[:, 0])
    assert np.max(np.diff(samples)) < 0.02
    assert samples[0] < 0.01
    assert samples[-1] > 0.99


def test_more_samples_than_the_memory_holds_are_refused(
    primary: Body, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(focal, "_MAX_SAMPLES", 50_000)
    with pytest.raises(CensusError, match="move it farther inside"):
        image_samples(lambda u: focal_points_mm(primary, u, 0), lambda p: np.full(len(p), 1e-4))
