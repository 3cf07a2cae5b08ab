"""Layers: the meridian polygon of a layered sphere in closed form, flats at poles, the dead zone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gomboc_cad.body import Body, Harmonic, catalog, mass_properties, support_jet
from gomboc_cad.body.sphere import unit
from gomboc_cad.equilibria import Census
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.equilibria.round_solids import EllipsoidShape
from gomboc_cad.errors import CensusError
from gomboc_cad.tolerance.geometry import MadePart
from gomboc_cad.tolerance.layers import Layers, layered_rest, sample_layers, stair_dead_zone_mm
from gomboc_cad.tolerance.rebuilt import sampled_census
from gomboc_cad.tolerance.variants import Nominal, Variants
from tests.body.shapes import Array

RADIUS = 50.0
SPHERE = Body("sphere", Harmonic(()), RADIUS)
UP: Vector = (0.0, 0.0, 1.0)


def variant(com: Vector) -> Variants:
    return Variants(np.array([com]), np.eye(3)[None], np.empty((1, 0)), np.zeros((1, 3)))


def layered_census(body: Body, com: Vector, layers: Layers, sag_mm: float, barrier_mm: float) -> Census:
    sampled = sample_layers(MadePart.of(Nominal(body, com), variant(com), 0), layers, sag_mm)
    assert sampled.sag_mm <= sag_mm
    return sampled_census(sampled, barrier_mm)


def meridian_mm(layers: Layers) -> Array:
    """Corners (r, z) of the layered sphere's profile from the lower pole to the upper one."""
    t = layers.height_mm
    first, last = math.ceil(-RADIUS / t - layers.phase), math.floor(RADIUS / t - layers.phase)
    z = (np.arange(first, last + 1) + layers.phase) * t
    r = np.sqrt(RADIUS**2 - z**2)
    below = np.stack([r, z - 0.5 * t], axis=1)[z <= 1e-9]
    above = np.stack([r, z + 0.5 * t], axis=1)[z >= -1e-9]
    return np.concatenate([below, above])


def rings(layers: Layers, com_height_mm: float, barrier_mm: float) -> int:
    """Rests of the layered sphere about a COM on its axis, by rising water along the meridian.

    The landscape is a path: flat, edge, strip, edge, …, flat; a strip is a rest if the foot lies inside it.
    """
    corners = meridian_mm(layers)
    corners = np.concatenate([[[0.0, corners[0, 1]]], corners, [[0.0, corners[-1, 1]]]])
    arm = corners - [0.0, com_height_mm]
    side = np.diff(corners, axis=0)
    length = np.linalg.norm(side, axis=1)
    share = -(arm[:-1] * side).sum(axis=1) / length**2
    plane = np.abs(arm[:-1, 0] * side[:, 1] - arm[:-1, 1] * side[:, 0]) / length
    # Between two strips stands the corner; the height there is its distance only if it is a crest.
    ahead, behind = share[:-1] < 1.0, share[1:] > 0.0
    crest = np.where(ahead & behind, np.linalg.norm(arm[1:-1], axis=1), np.maximum(plane[:-1], plane[1:]))
    lakes = [[k] for k in range(len(plane))]
    counted = 1
    for corner in np.argsort(crest):
        left = next(lake for lake in lakes if corner in lake)
        right = next(lake for lake in lakes if corner + 1 in lake)
        floor = max(plane[left].min(), plane[right].min())
        counted += int(crest[corner] - floor >= barrier_mm)
        left.extend(right)
        lakes.remove(right)
    return counted


@pytest.mark.parametrize(("lowered", "height", "phase"), [(6.0, 4.0, 0.3), (5.0, 3.0, 0.2)])
def test_every_step_in_the_dead_zone_holds_a_sphere(lowered: float, height: float, phase: float) -> None:
    """About an axis along the build direction each strip that holds the sphere is a neutral ring."""
    layers = Layers(UP, height, phase)
    barrier = 0.02
    expected = rings(layers, -lowered, barrier)
    found = layered_census(SPHERE, (0.0, 0.0, -lowered), layers, 0.2 * barrier, barrier)
    assert expected > 3
    assert found.stable == expected


def test_the_dead_zone_of_a_sphere() -> None:
    """`t/2 (1/sinα + sinα)`, and at the poles the radius of the flat that a layer may leave."""
    angles = np.radians([90.0, 60.0, 30.0, 10.0, 179.9, 0.0])
    normals = np.stack([np.sin(angles), np.zeros(6), np.cos(angles)], axis=1)
    found = stair_dead_zone_mm(SPHERE, UP, 0.2, normals)
    sine = np.sin(angles[:4])
    np.testing.assert_allclose(found[:4], 0.1 * (1.0 / sine + sine), rtol=1e-9)
    np.testing.assert_allclose(found[4:], math.sqrt(2.0 * RADIUS * 0.2), rtol=1e-3)


def test_layers_stop_a_sphere_as_far_as_the_dead_zone_reaches() -> None:
    """On the lower half, where the edges lie farther out, |∇h| = s sinα reaches the bound itself."""
    lowered, layers = 3.0, Layers(UP, 0.5)
    corners = meridian_mm(layers)
    middle, side = 0.5 * (corners[1:] + corners[:-1]), np.diff(corners, axis=0)
    normal = unit(np.stack([side[:, 1], -side[:, 0]], axis=1))
    foot = np.abs(((middle - [0.0, -lowered]) * unit(side)).sum(axis=1))
    held = foot <= 0.5 * np.linalg.norm(side, axis=1)
    slope = lowered * np.abs(normal[:, 0])
    reach = stair_dead_zone_mm(SPHERE, UP, 0.5, np.stack([normal[:, 0], 0.0 * slope, normal[:, 1]], axis=1))
    lower = middle[:, 1] < -1.0
    np.testing.assert_array_equal(held[lower], (slope <= reach)[lower])
    assert np.all((slope <= reach)[held])
    assert held[lower].sum() == 5


def test_strips_of_an_ellipsoid_run_along_conjugate_directions() -> None:
    """Along the contour line a strip does not turn, so its other direction is conjugate to that."""
    semi = np.array([1.3, 0.8, 1.0])
    body = Body("ellipsoid", EllipsoidShape((1.3, 0.8, 1.0)), 20.0)
    build = unit(np.array([0.4, 0.3, 0.8]))
    normal = unit(np.array([[0.7, 0.5, -0.3]]))
    axes = 20.0 * semi
    # On an ellipsoid the directions d and e are conjugate if Σ dᵢ eᵢ / aᵢ² vanishes.
    along = np.cross(normal[0], build)
    conjugate = np.cross(normal[0], along / axes**2)
    step = 0.01 * conjugate / (conjugate @ build)
    level = build - (build @ normal[0]) * normal[0]
    expected = 0.5 * np.linalg.norm(step) + 0.005 * np.linalg.norm(level)
    found = stair_dead_zone_mm(body, as_vector(build), 0.01, normal)[0]
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("phase", "stable"), [(0.0, 1), (0.3, 3)])
def test_flats_at_the_poles_of_the_build_direction(phase: float, stable: int) -> None:
    """The COM 5 mm off the axis falls into the flats of radius 8.3 and 5.5 mm that a phase of 0.3 leaves."""
    layers = Layers(UP, 1.0, phase)
    found = layered_census(SPHERE, (5.0, 0.0, 0.0), layers, 4e-4, 1e-3)
    assert found.stable == stable
    poles = [e for e in found.equilibria if e.kind == "stable" and abs(e.direction[2]) > 0.99]
    for pose in poles:
        z = 49.3 if pose.direction[2] > 0.0 else 49.7
        flat = math.sqrt(RADIUS**2 - z**2)
        height = z + 0.5
        assert pose.height_mm == pytest.approx(height, abs=1e-5)
        over_the_edge = math.hypot(height, flat - 5.0) - height
        assert pose.barrier_mm == pytest.approx(over_the_edge, abs=1e-3)


def test_layers_of_the_primary_hold_it_in_the_dead_zone_only() -> None:
    """Poles where |∇h| is small become rests; on steps it stops only where the bound allows."""
    body = catalog()["primary"].with_diameter(2.0 * RADIUS)
    com = mass_properties(body).com_mm
    layers = Layers(as_vector(unit(np.array([0.3, 0.2, 1.0]))), 1.0, 0.4)
    found = layered_census(body, com, layers, 5e-3, 0.01)
    down = np.array([e.direction for e in found.equilibria if e.kind == "stable"])
    slope = np.linalg.norm(support_jet(body, down, np.array(com)).gradient_mm, axis=1)
    reach = stair_dead_zone_mm(body, layers.build_direction, layers.height_mm, down)
    assert len(down) > 1
    assert np.all(slope <= 1.05 * reach + 0.05)


def test_thin_layers_leave_the_rest_where_it_was() -> None:
    com = (0.0, 3.0, -4.0)
    found = layered_rest(
        Nominal(SPHERE, com), variant(com), 0, Layers((1.0, 0.0, 0.0), 0.01), barrier_mm=0.05, sag_mm=5e-4
    )
    assert (found.verdict, found.stable) == ("monostable", 1)
    assert found.tilt_deg < 0.2


@pytest.mark.parametrize(
    ("direction", "height", "what"), [((0.0, 0.0, 2.0), 0.2, "unit vector"), (UP, 0.0, "positive length")]
)
def test_layers_that_cannot_be(direction: Vector, height: float, what: str) -> None:
    with pytest.raises(CensusError, match=what):
        Layers(direction, height)
