"""The drill map against solids that are really drilled or cut, judged by the census of their meshes.

The COM is that of the body throughout, as if what is removed were balanced.
"""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from gomboc_cad.body import Body, catalog, mass_properties
from gomboc_cad.body.sphere import geodesic_triangulation, tangent_frame, unit
from gomboc_cad.equilibria import Census
from gomboc_cad.equilibria.drill_map import DrillLimits, drill_limits, drill_map
from gomboc_cad.equilibria.mesh import mesh_census
from tests.body.shapes import Array, random_directions

BODY = catalog()["primary"].with_diameter(2.0)
COM = np.array(mass_properties(BODY).com_mm)
COUNT = 12


@pytest.fixture(scope="module")
def limits() -> DrillLimits:
    found = drill_limits(BODY, random_directions(COUNT, seed=20), COM)
    assert found.radius_mm.max() > 0.08
    assert (found.refined_radius_mm > 1.2 * found.radius_mm).sum() >= 2
    return found


def solid_dense_at(body: Body, position: Array, radius: float) -> manifold3d.Manifold:
    """The body as a mesh that is finest at one place: directions drawn together about it."""
    directions, faces = geodesic_triangulation(5)
    pole = unit(position)
    cosine = directions @ pole
    across = directions - cosine[:, None] * pole
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    near = min(0.9, 2.0 * radius)
    angle *= near + (1.0 - near) * (angle / np.pi) ** 2
    drawn = unit(np.cos(angle)[:, None] * pole + np.sin(angle)[:, None] * across)
    return manifold3d.Manifold(manifold3d.Mesh64(body.position_mm(drawn), faces.astype(np.uint64)))


def drill(position: Array, normal: Array, radius: float) -> manifold3d.Manifold:
    """A drill along the normal, right through the body's middle."""
    first, second = (axis[0] for axis in tangent_frame(normal[None]))
    if np.linalg.det([first, second, normal]) < 0.0:
        first, second = second, first
    rod = manifold3d.Manifold.cylinder(1.0, radius, radius, 240, True)
    return rod.transform(np.column_stack([first, second, normal, position]))


def census_of(solid: manifold3d.Manifold, barrier: float) -> Census:
    mesh = solid.to_mesh64()
    vertices, faces = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    return mesh_census(vertices, faces, COM, barrier_mm=barrier, probabilities=False)


def rests_over(solid: manifold3d.Manifold, position: Array, normal: Array, radius: float) -> int:
    """Stable facets of the hull whose foot is inside the mouth of the hole."""
    census = census_of(solid, 0.0)
    stable = [e for e in census.equilibria if e.kind == "stable"]
    feet = COM + np.array([e.height_mm * np.array(e.direction) for e in stable]) - position
    depth = feet @ normal
    across = np.linalg.norm(feet - depth[:, None] * normal, axis=1)
    return int(((across < radius * (1.0 - 1e-6)) & (depth > -0.3)).sum())


def rests_after_drilling(limits: DrillLimits, i: int, radius: float) -> int:
    position, normal = limits.positions_mm[i], limits.directions[i]
    solid = solid_dense_at(BODY, position, radius) - drill(position, normal, radius)
    return rests_over(solid, position, normal, radius)


@pytest.mark.parametrize("i", range(COUNT))
def test_a_plane_flat_just_under_its_depth_is_harmless_and_one_just_over_is_a_rest(
    limits: DrillLimits, i: int
) -> None:
    position, normal, depth = limits.positions_mm[i], limits.directions[i], limits.flat_depth_mm[i]
    solid = solid_dense_at(BODY, position, np.sqrt(2.0 * depth))
    for share, rests in ((0.95, 0), (1.05, 1)):
        cut = solid.trim_by_plane(-normal, -(position @ normal - share * depth))
        found = census_of(cut, 0.0).equilibria
        flats = [e for e in found if e.kind == "stable" and np.dot(e.direction, normal) > 1.0 - 1e-10]
        assert len(flats) == rests


def test_the_whole_census_counts_one_rest_more_when_the_best_hole_is_too_large() -> None:
    """Of the solid as it is, flocks left out by a barrier that the new rest is far above."""
    drilling = drill_map(BODY)
    position, normal = drilling.best.positions_mm[0], drilling.best.directions[0]
    directions, faces = geodesic_triangulation(6)
    whole = manifold3d.Manifold(manifold3d.Mesh64(BODY.position_mm(directions), faces.astype(np.uint64)))
    counts = [
        census_of(whole - drill(position, normal, share * drilling.max_radius_mm), 5e-5).stable
        for share in (0.95, 1.2)
    ]
    assert counts == [1, 2]


@pytest.mark.slow
@pytest.mark.parametrize("i", range(COUNT))
def test_a_drilled_hole_just_under_the_map_is_harmless_and_one_just_over_is_a_rest(
    limits: DrillLimits, i: int
) -> None:
    safe, refined = limits.radius_mm[i], limits.refined_radius_mm[i]
    # Where both are nearly the same, the larger hole speaks for the smaller one.
    for radius in {safe, refined} if refined > 1.2 * safe else {refined}:
        assert rests_after_drilling(limits, i, 0.95 * radius) == 0
    assert rests_after_drilling(limits, i, 1.05 * limits.refined_radius_mm[i]) > 0
