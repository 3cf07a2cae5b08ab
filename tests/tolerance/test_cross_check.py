"""Two judges of the same variants: what they agree on, and damage to one of them that the other must tell."""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np
import pytest

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.body.sphere import unit
from gomboc_cad.equilibria import find_equilibria
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.openings.placed_opening import PlacedOpening, judged_opening
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder
from gomboc_cad.tolerance.cross_check import CrossCheck, checked_rows, cross_check
from gomboc_cad.tolerance.fast_census import judge
from gomboc_cad.tolerance.harmonics import degrees_and_orders
from gomboc_cad.tolerance.sampling import quantiles
from gomboc_cad.tolerance.variants import Nominal, Outcomes, SeamPlane, Variants
from tests.body.shapes import Array
from tests.tolerance.toys import LoadedSphere

MODEL = LoadedSphere(lowered_mm=5.0, across_mm=0.5, along_mm=0.5)
ROWS = checked_rows(256, 3, seed=1)
QUANTILES = quantiles(3, 7, 0, 256)[ROWS]


@dataclass(frozen=True)
class Given:
    """Variants of the primary that are given, judged by the fast judge; the one quantile is their number."""

    nominal: Nominal
    made: Variants

    def variants(self, numbers: Array) -> Variants:
        return self.made.rows(numbers[:, 0].astype(np.int64))

    def judge(self, variants: Variants) -> Outcomes:
        return judge(self.nominal, variants)


@dataclass(frozen=True)
class Mirrored(LoadedSphere):
    """Judges the COM as if x were −x."""

    def judge(self, variants: Variants) -> Outcomes:
        return super().judge(replace(variants, com_mm=variants.com_mm * (-1.0, 1.0, 1.0)))


def checked(model: LoadedSphere) -> CrossCheck:
    return cross_check(model, QUANTILES, ROWS)


def test_the_same_seed_draws_the_same_rows() -> None:
    rows = checked_rows(1000, 20, seed=3)
    np.testing.assert_array_equal(rows, checked_rows(1000, 20, seed=3))
    assert len(set(rows.tolist())) == 20
    assert np.all(np.diff(rows) > 0)
    assert (rows.min() >= 0, rows.max() < 1000) == (True, True)
    np.testing.assert_array_equal(checked_rows(5, 20, seed=3), np.arange(5))
    assert list(rows) != list(checked_rows(1000, 20, seed=4))


@pytest.fixture(scope="module")
def honest() -> CrossCheck:
    return checked(MODEL)


def test_judges_of_a_sphere_agree(honest: CrossCheck) -> None:
    assert len(honest.agreed) == len(ROWS)
    assert [row.row for row in honest.rows] == ROWS.tolist()
    assert all(row.difference_deg < 1e-6 and row.rebuilt.settled for row in honest.rows)
    document = json.loads(json.dumps(honest.document(), allow_nan=False))
    assert (document["rows"], document["agreed"], document["disagreed"]) == (3, 3, [])
    assert 0.0 < document["largest_barrier_um"] < 2.0


def test_processes_give_the_same_records(honest: CrossCheck) -> None:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        spread = cross_check(MODEL, QUANTILES, ROWS, spread=pool.map)
    assert spread == honest


def test_a_rest_in_the_wrong_place_is_told() -> None:
    found = checked(Mirrored(5.0, 0.5, 0.5))
    assert len(found.disagreed) == len(ROWS)
    assert "from each other" in found.disagreed[0].reason


def test_a_rest_that_is_not_there_is_told() -> None:
    found = checked(replace(MODEL, margin_mm=0.0))
    assert len(found.disagreed) == len(ROWS)
    entry = found.document()["disagreed"][0]
    assert entry["fast"]["verdict"] == "multistable"
    assert entry["rebuilt"]["verdict"] == "monostable"
    assert entry["rebuilt"]["barrier_um"] < 0.1  # the finer points were tried before it was listed
    assert "shallower" in entry["reason"]


def test_what_the_fast_judge_leaves_open_is_answered_but_no_agreement() -> None:
    found = checked(replace(MODEL, margin_mm=0.0, doubt_mm=0.0))
    assert (len(found.undecided), len(found.agreed)) == (len(ROWS), 0)
    entry = found.document()["undecided"][0]
    assert (entry["fast"]["verdict"], entry["rebuilt"]["verdict"]) == ("undecided", "monostable")


PRIMARY = catalog()["primary"].with_diameter(100.0)
CENTROID = mass_properties(PRIMARY).com_mm


def drilled(direction: Vector, share: float) -> PlacedOpening:
    """A hole in the primary of a share of the radius that is allowed there."""
    frame = RestFrame.from_rest(find_equilibria(PRIMARY, CENTROID)[0].direction)
    place = PRIMARY.surface(unit(np.array([direction])))
    base, axis = as_vector(place.position_mm[0] - 10.0 * place.normal[0]), as_vector(place.normal[0])

    def hole(radius_mm: float) -> PlacedOpening:
        return judged_opening(PRIMARY, CENTROID, "port", Cylinder(base, axis, radius_mm, 20.0), frame=frame)

    allowed = hole(1.0).allowed_radius_mm
    assert allowed is not None
    return hole(share * allowed)


def made(count: int, com_mm: float, form_mm: float, shift_mm: float = 0.0) -> Variants:
    """Random errors of every kind; those of form fall with the square of the degree, up to 10."""
    rng = np.random.default_rng(3)
    degrees = degrees_and_orders(10)[:, 0]
    axes = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    stretch = 1.0 + 1e-4 * rng.normal(size=(count, 3))
    return Variants(
        np.array(CENTROID) + com_mm * rng.normal(size=(count, 3)),
        np.einsum("nij,nj,nkj->nik", axes, stretch, axes),
        form_mm * rng.normal(size=(count, len(degrees))) / degrees**2,
        shift_mm * rng.normal(size=(count, 3)),
    )


@pytest.mark.slow
@pytest.mark.parametrize("what", ["smooth", "seam", "holes"])
def test_the_fast_judge_and_the_geometry_agree_about_the_primary(what: str) -> None:
    nominal, variants = Nominal(PRIMARY, CENTROID), made(4, 0.05, 0.03)
    if what == "seam":
        seam = SeamPlane((10.0, 0.0, 0.0), (1.0, 0.0, 0.0))
        nominal, variants = replace(nominal, seam=seam), made(3, 0.03, 0.002, 0.01)
    elif what == "holes":
        holes = (drilled((0.5, -0.5, 0.7), 0.985), drilled((-0.3, 0.8, 0.5), 0.985))
        nominal, variants = replace(nominal, openings=holes), made(4, 0.03, 0.002)
    numbers = np.arange(len(variants))
    found = cross_check(Given(nominal, variants), numbers[:, None], numbers)  # type: ignore[arg-type]
    assert found.disagreed == ()
    assert len(found.agreed) >= len(variants) - 1
    rests = [row for row in found.agreed if row.rebuilt.verdict == "monostable" and row.rebuilt.settled]
    assert all(row.difference_deg < 1e-6 for row in rests)
