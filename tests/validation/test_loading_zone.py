"""The loading zone of the primary against the census: one rest inside, another number just outside.

Reference: the S-margin grows to 0.0077 R with the COM 0.0055 R nearer to the rest, falls to 0.0008 R at
0.020 R and grows again, 0.024 R at 0.05 R and 0.062 R at 0.10 R (grids of 1500² to 2000² points, refined).
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from gomboc_cad.body import Body, catalog, depth_mm, mass_properties
from gomboc_cad.body.sphere import unit
from gomboc_cad.equilibria import com_margin, find_equilibria
from gomboc_cad.equilibria.zone import LoadingZone, loading_zone, margins_towards_rest
from tests.body.shapes import Array, random_directions

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def primary() -> Body:
    return catalog()["primary"].with_diameter(2.0)


@pytest.fixture(scope="module")
def zone(primary: Body) -> LoadingZone:
    """With cells of twice the usual size, by which the tests below measure; every passage is open still."""
    return loading_zone(primary, fineness=0.5)


def rests(body: Body, com: Array) -> int:
    return sum(e.kind == "stable" for e in find_equilibria(body, com))


def picked_faces(zone: LoadingZone, per_octave: int) -> tuple[Array, Array]:
    """Centres and outward normals of random faces at the focal sheet, as many in each octave of distance."""
    corners = zone.vertices_mm[zone.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area, centers = np.linalg.norm(across, axis=1), corners.mean(axis=1)
    distance = np.linalg.norm(centers - zone.com_mm, axis=1)
    inner = np.linalg.norm(corners, axis=2).min(axis=1) < 0.6
    rng = np.random.default_rng(4)
    chosen = []
    for low in zone.s_margin_mm * 2.0 ** np.arange(7):
        rows = np.flatnonzero(inner & (distance >= low) & (distance < 2.0 * low))
        chosen.append(rng.choice(rows, per_octave, p=area[rows] / area[rows].sum()))
    index = np.concatenate(chosen)
    return centers[index], across[index] / area[index, None]


def test_the_boundary_is_closed(zone: LoadingZone) -> None:
    mesh = trimesh.Trimesh(zone.vertices_mm, zone.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(zone.volume_mm3, rel=1e-9)


def test_the_best_places(zone: LoadingZone, primary: Body) -> None:
    com = np.array(mass_properties(primary).com_mm)
    assert zone.s_margin_mm == pytest.approx(0.00339, rel=0.01)
    shift = np.array(zone.nearest_best_com_mm) - com
    assert zone.nearest_best_s_margin_mm == pytest.approx(0.0077, rel=0.01)
    assert shift[0] == pytest.approx(-0.0055, abs=2e-4)
    assert np.linalg.norm(shift[1:]) < 0.2 * 0.0077
    for place, margin in (
        (zone.best_com_mm, zone.best_s_margin_mm),
        (zone.nearest_best_com_mm, zone.nearest_best_s_margin_mm),
    ):
        room = min(com_margin(primary, place).s_margin_mm, depth_mm(primary, np.array(place))[0])
        assert margin == pytest.approx(room, rel=1e-9)
        assert rests(primary, np.array(place)) == 1
    assert zone.best_s_margin_mm > 0.4


def test_margins_along_the_axis(zone: LoadingZone) -> None:
    lowered = np.array([0.0, 0.0055, 0.02, 0.05, 0.10])
    expected = [0.00339, 0.0077, 0.0008, 0.024, 0.062]
    np.testing.assert_allclose(margins_towards_rest(zone, lowered), expected, rtol=0.05)


def test_one_rest_on_the_inner_side_of_every_face_and_another_number_beyond(
    zone: LoadingZone, primary: Body
) -> None:
    """No face is farther than a cell from a COM at which a rest is born, few farther than a tenth of one.

    Those few cut off the sharp corners between crossing sheets.
    """
    centers, normals = picked_faces(zone, 3)
    resolution = zone.resolution_mm(centers)
    gaps = []
    for center, normal, cell in zip(centers, normals, resolution, strict=True):
        assert rests(primary, center) == 1
        assert rests(primary, center - 0.1 * cell * normal) == 1
        witness = np.array(com_margin(primary, center).s_witness_mm)
        gaps.append(np.linalg.norm(witness - center) / cell)
        # Where the sheet folds its edge is the nearest, and its inside is met a little to the side.
        probes = [witness, *(witness + 0.03 * cell * random_directions(12, seed=7))]
        assert any(rests(primary, center + 1.05 * (p - center)) > 1 for p in probes)
    assert max(gaps) < 1.0
    assert np.mean(np.array(gaps) < 0.1) > 0.85


def test_random_places_inside_have_one_rest(zone: LoadingZone, primary: Body) -> None:
    """At all distances from the COM, on the side of the boundary that the mesh says."""
    rng = np.random.default_rng(5)
    reach = zone.s_margin_mm * 100.0 ** rng.random(60)
    places = np.array(zone.com_mm) + reach[:, None] * random_directions(60, seed=6)
    inside = winding(zone, places) > 0.5
    assert 15 < inside.sum() < 55
    for place in places[inside]:
        assert rests(primary, place) == 1


def winding(zone: LoadingZone, places: Array) -> Array:
    """Winding number of the boundary about places, by the solid angles of its faces.

    Source: Van Oosterom, Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30 (1983).
    """
    corners = zone.vertices_mm[zone.faces]
    result = np.empty(len(places))
    for index, place in enumerate(places):
        a, b, c = unit(corners - place).transpose(1, 0, 2)
        above = np.einsum("nx,nx->n", a, np.cross(b, c))
        below = 1.0 + np.einsum("nx,nx->n", a, b) + np.einsum("nx,nx->n", b, c) + np.einsum("nx,nx->n", c, a)
        result[index] = np.arctan2(above, below).sum() / (2.0 * np.pi)
    return result
