"""Meshes: the sag is met, nothing leaks, and the twin kernels agree."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold, Mesh64

import gomboc_cad
from gomboc_cad import Body
from gomboc_cad.body import mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import Cylinder, HollowBody, Mesh, Seam, brep, mesh, split_mesh
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import body_mesh, facet_sag_um, subdivision_level
from gomboc_cad.solid.mesh_distance import MeshDistance, mesh_distance
from gomboc_cad.solid.offset import InsetSurface
from tests.solid.conftest import ALONG_X, SAG_UM, Halves


def distance(found: Mesh, boundary: Boundary, promised_um: float = SAG_UM) -> MeshDistance:
    manifold = Manifold(Mesh64(found.vertices_mm, found.faces.astype(np.uint64)))
    return mesh_distance(found, manifold, boundary, promised_um)


def random_points_on(found: Mesh, count: int) -> Array:
    """Points spread over the facets, three weights each."""
    rng = np.random.default_rng(1)
    weights = rng.dirichlet((1.0, 1.0, 1.0), count)
    corners = found.vertices_mm[found.faces[rng.integers(len(found.faces), size=count)]]
    return np.einsum("nc,ncx->nx", weights, corners)


# Every body at one sag; the finer one on bodies with and without dents, of few and of many harmonics.
@pytest.mark.parametrize(
    ("name", "sag_um"),
    [
        *((name, 100.0) for name in gomboc_cad.catalog()),
        *((n, 20.0) for n in ("primary", "third", "tolerant-2")),
    ],
)
def test_sag_of_body_meshes_is_met_and_not_wasted(name: str, sag_um: float) -> None:
    body = gomboc_cad.catalog()[name]
    found = body_mesh(body, sag_um)
    surface = InsetSurface(body)
    sag = facet_sag_um(found, surface).max()
    assert sag_um / 4.2 < sag <= sag_um
    # The bound is no estimate from afar: random points come close to it and never beyond.
    heights = 1e3 * np.abs(surface.signed_distance_mm(random_points_on(found, 100_000)))
    assert 0.9 * sag < heights.max() <= 1.001 * sag


def test_mesh_of_a_body_is_watertight_and_lacks_the_volume_of_its_sag(primary: Body) -> None:
    found = body_mesh(primary, SAG_UM)
    tri = trimesh.Trimesh(found.vertices_mm, found.faces, process=False)
    assert tri.is_watertight
    assert tri.is_winding_consistent
    lacking = mass_properties(primary).volume_mm3 - found.mass().volume_mm3
    assert 0.0 < lacking < 1e-3 * SAG_UM * tri.area


def test_halves_keep_the_promised_distance_in_both_directions(halves: Halves) -> None:
    for found, part in zip(halves.meshes, halves.expected, strict=True):
        gap = distance(found, part.boundary)
        assert 0.5 * SAG_UM < gap.from_mesh_um <= SAG_UM
        assert gap.to_mesh_um <= gap.from_mesh_um


def test_twin_kernels_agree(halves: Halves) -> None:
    """Volumes agree within the sag's bound, and to a millionth once what lies under the sag is added."""
    for found, part in zip(halves.meshes, halves.expected, strict=True):
        gap, mass = distance(found, part.boundary), found.mass()
        area = trimesh.Trimesh(found.vertices_mm, found.faces, process=False).area
        assert abs(mass.volume_mm3 - part.volume_mm3) < 1e-3 * SAG_UM * area
        volume = mass.volume_mm3 + gap.missing_mm3
        assert volume == pytest.approx(part.volume_mm3, rel=2e-6)
        com = (np.array(mass.com_mm) * mass.volume_mm3 + gap.missing_moment_mm4) / volume
        assert com == pytest.approx(part.com_mm, abs=2e-4)


def test_halves_survive_single_precision(halves: Halves) -> None:
    for found in halves.meshes:
        rounded = found.vertices_mm.astype(np.float32)
        assert len(np.unique(rounded, axis=0)) == len(rounded)
        assert trimesh.Trimesh(rounded, found.faces, process=False).is_watertight


def test_halves_add_up(hollow_mesh: Mesh, halves: Halves) -> None:
    volumes = [found.mass().volume_mm3 for found in halves.meshes]
    assert sum(volumes) == pytest.approx(hollow_mesh.mass().volume_mm3, rel=1e-6)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.36, 0.48, 0.8), (-0.1, 0.7, -0.3)])
def test_mouth_of_a_blind_hole_flush_with_its_boss_is_open(primary: Body, axis) -> None:
    """Rounding must not leave a skin over it, whatever the direction."""
    up = np.array(axis) / np.linalg.norm(axis)
    top = -0.4 * 50.0
    boss = Cylinder(tuple(-60.0 * up), axis, 4.0, 60.0 + top)
    hole = Cylinder(tuple((top - 6.0) * up), axis, 2.0, 6.0)
    hollow = HollowBody(primary, 3.0, bosses=(boss,), holes=(hole,))
    found = mesh(hollow, 50.0)
    assert distance(found, Boundary.of_hollow(hollow), 50.0).from_mesh_um <= 50.0
    taken = (
        solid_mass(brep(HollowBody(primary, 3.0, bosses=(boss,)))).volume_mm3
        - solid_mass(brep(hollow)).volume_mm3
    )
    assert taken == pytest.approx(np.pi * 2.0**2 * 6.0, rel=1e-4)


def test_stacked_holes_open_into_each_other(primary: Body) -> None:
    """A counterbore and a drill that meet in a plane make one hole."""
    axis = (0.36, 0.48, 0.8)
    up = np.array(axis)
    boss = Cylinder(tuple(-60.0 * up), axis, 6.0, 40.0)
    drill = Cylinder(tuple(-33.0 * up), axis, 1.5, 8.0)
    bore = Cylinder(tuple(-25.0 * up), axis, 3.0, 5.0)
    hollow = HollowBody(primary, 3.0, bosses=(boss,), holes=(drill, bore))
    assert len(brep(hollow).shells()) == 2
    assert distance(mesh(hollow, 50.0), Boundary.of_hollow(hollow), 50.0).from_mesh_um <= 50.0


def test_planes_and_bosses_that_leave_pieces_are_refused(primary: Body, hollow_mesh: Mesh) -> None:
    with pytest.raises(GeometryError, match="upper part is in 0 pieces"):
        split_mesh(hollow_mesh, Seam((60.0, 0.0, 0.0), ALONG_X), SAG_UM)
    floating = HollowBody(primary, 3.0, bosses=(Cylinder((-5.0, 0.0, 0.0), ALONG_X, 3.0, 10.0),))
    with pytest.raises(GeometryError, match="is in 2 pieces"):
        mesh(floating, 200.0)


@pytest.mark.parametrize("sag_um", [0.0, -1.0, float("nan")])
def test_senseless_sags_are_refused(primary: Body, sag_um: float) -> None:
    with pytest.raises(GeometryError, match="sag must be a positive length"):
        subdivision_level(InsetSurface(primary), sag_um)


def test_a_sag_that_needs_too_many_facets_is_refused(primary: Body) -> None:
    with pytest.raises(GeometryError, match="327,680 facets at this size; ask for"):
        body_mesh(primary, 0.01)
    with pytest.raises(GeometryError, match="ask for"):
        mesh(HollowBody(primary, 3.0), 0.1)


def test_the_sag_that_a_refusal_names_is_enough(primary: Body) -> None:
    large = HollowBody(primary.with_diameter(2000.0), 60.0)
    with pytest.raises(GeometryError, match="ask for") as caught:
        mesh(large, 1.0)
    enough_um = float(str(caught.value).split("ask for ")[1].split()[0])
    assert subdivision_level(large.outer, enough_um, 4.0) <= 7
