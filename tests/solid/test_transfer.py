"""Whether the exported solid has the equilibria of the analytic body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from build123d import Solid
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import chebyshev
from scipy.interpolate import BSpline

import gomboc_cad
from gomboc_cad import Body
from gomboc_cad.body import make_body, mass_properties
from gomboc_cad.body.sphere import Array, geodesic_triangulation, tangent_frame, unit
from gomboc_cad.equilibria import com_margin
from gomboc_cad.errors import GeometryError, NotConvexError
from gomboc_cad.solid.export import write_step
from gomboc_cad.solid.hollow import split_brep
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.patches import (
    DEGREE,
    Patch,
    body_solid,
    inset_solid,
    interpolate_patches,
    patches_solid,
)
from gomboc_cad.solid.spans import FINER, NODES, OVERSHOOT, chebyshev_grid, least_modulus, spline_faces
from gomboc_cad.solid.step import NamedSolid, read_step
from gomboc_cad.solid.transfer import Transfer, transfer
from tests.solid.conftest import ORIGIN, SEAM

BODIES = ("primary", "sloan2-0.035")
SPHERE = make_body("sloan2", 0.0)

MARGIN = 0.0033
"""Margin of the primary about its centroid in units of R₀, the value of its catalogue entry."""


def through_step(folder: Path, *solids: Solid) -> list[Solid]:
    """What a reader of the STEP file gets."""
    path = folder / "solid.step"
    write_step(path, [NamedSolid(f"part {i}", solid) for i, solid in enumerate(solids)], "solid")
    return [part.solid for part in read_step(path)]


def transfer_of(body: Body, patches: tuple[Patch, ...]) -> Transfer:
    """The transfer to a solid of given patches, about the homogeneous centroids of both."""
    solid = patches_solid(patches)
    margin_mm = MARGIN * body.radius_mm
    return transfer([solid], body, mass_properties(body).com_mm, solid_mass(solid).com_mm, margin_mm)


class Spline:
    """A patch with its derivatives by its own knots, apart from the code under test."""

    def __init__(self, patch: Patch) -> None:
        self.poles = patch.poles_mm
        self.bases = [
            BSpline(patch.knots, np.eye(len(patch.poles_mm)), DEGREE).derivative(k) for k in range(3)
        ]

    def __call__(self, places: Array, first: int = 0, second: int = 0) -> Array:
        rows, columns = self.bases[first](places[:, 0]), self.bases[second](places[:, 1])
        return np.einsum("ni,nj,ijx->nx", rows, columns, self.poles, optimize=True)

    def on_rays(self, rays: Array, places: Array) -> Array:
        """Points on rays from the origin, by Newton iteration from nearby places."""
        first, second = tangent_frame(rays)
        frame = np.stack([first, second], axis=1)
        for _ in range(3):
            slope = np.stack([self(places, 1, 0), self(places, 0, 1)], axis=-1)
            miss = np.einsum("nax,nx->na", frame, self(places))
            places = places - np.linalg.solve(frame @ slope, miss[:, :, None])[:, :, 0]
        return self(places)


def sampled_deviation(body: Body, patches: tuple[Patch, ...], com: Array, count: int) -> tuple[float, float]:
    """Largest gradient and Hessian of D' − D met at random places, by differences along geodesics."""
    generator = np.random.default_rng(7)
    step = 4e-4 * body.radius_mm
    gradients, hessians = [], []
    for patch in patches:
        spline = Spline(patch)
        places = generator.uniform(-0.78, 0.78, (count, 2))
        # A spline's second derivatives are farthest off at the knots: half of the coordinates go there.
        knots = np.unique(patch.knots)[1:-1]
        snapped = knots[np.abs(places[..., None] - knots).argmin(axis=-1)]
        places = np.where(generator.random(places.shape) < 0.5, snapped, places)
        here = body.surface(unit(spline(places)))

        def delta(
            angle: float, length: float, spline: Spline = spline, places: Array = places, here=here
        ) -> Array:
            turn = np.array([np.cos(angle), np.sin(angle)])
            bend = np.einsum("a,nab,b->n", turn, here.shape_operator_per_mm, turn)
            moved = here.position_mm + length * np.einsum("a,nax->nx", turn, here.tangents)
            rays = unit(moved - 0.5 * length**2 * bend[:, None] * here.normal)
            own, other = body.position_mm(rays), spline.on_rays(rays, places)
            return 0.5 * np.einsum("nx,nx->n", other - own, other + own - 2.0 * com)

        middle = delta(0.0, 0.0)
        ahead, behind = (
            np.array([delta(angle, sign * step) for angle in (0.0, np.pi / 4, np.pi / 2)])
            for sign in (1.0, -1.0)
        )
        slope = (ahead - behind) / (2.0 * step)
        along, between, across = (ahead + behind - 2.0 * middle) / step**2
        gradients.append(np.hypot(slope[0], slope[2]).max())
        mixed = between - 0.5 * (along + across)
        hessians.append((np.abs(along + across) / 2 + np.hypot((along - across) / 2, mixed)).max())
    return max(gradients), max(hessians)


def equilibria_of(patches: tuple[Patch, ...], com: Array) -> int:
    """Count critical points of the distance from the COM, by Newton iteration from 1,600 places a patch."""
    found: list[Array] = []
    grid = np.linspace(-np.pi / 4, np.pi / 4, 40)
    for patch in patches:
        spline = Spline(patch)
        places = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
        for _ in range(15):
            arm, u, v = spline(places) - com, spline(places, 1, 0), spline(places, 0, 1)
            slope = np.stack([(arm * u).sum(1), (arm * v).sum(1)], axis=-1)
            uu, uv, vv = (
                (arm * spline(places, *order)).sum(1) + (a * b).sum(1)
                for order, a, b in (((2, 0), u, u), ((1, 1), u, v), ((0, 2), v, v))
            )
            bend = np.stack([np.stack([uu, uv], -1), np.stack([uv, vv], -1)], -1)
            step = -np.linalg.solve(bend, slope[:, :, None])[:, :, 0]
            # A start next to a critical point has a short way to go.
            near = np.linalg.norm(step, axis=1) < 0.15
            places = np.clip((places + step)[near], -np.pi / 4, np.pi / 4)
        for point in spline(places[np.linalg.norm(step[near], axis=1) < 1e-9]):
            if all(np.linalg.norm(point - other) > 1e-3 for other in found):
                found.append(point)
    return len(found)


def with_bump(patches: tuple[Patch, ...], direction: Array, height_um: float) -> tuple[Patch, ...]:
    """Move the inner control point nearest to a direction outwards."""

    def nearness(patch: Patch) -> Array:
        return unit(patch.poles_mm)[5:-5, 5:-5] @ direction

    chosen = max(range(len(patches)), key=lambda i: float(nearness(patches[i]).max()))
    near = nearness(patches[chosen])
    row, column = np.unravel_index(near.argmax(), near.shape)
    poles = patches[chosen].poles_mm.copy()
    poles[row + 5, column + 5] += 1e-3 * height_um * unit(poles[row + 5, column + 5])
    return tuple(replace(p, poles_mm=poles) if i == chosen else p for i, p in enumerate(patches))


@pytest.mark.parametrize("name", BODIES)
def test_the_solid_in_the_step_file_inherits_the_census(name: str, tmp_path: Path) -> None:
    body = gomboc_cad.catalog()[name]
    com = mass_properties(body).com_mm
    margin = com_margin(body, com).margin_mm
    (solid,) = through_step(tmp_path, body_solid(body))
    found = transfer([solid], body, com, solid_mass(solid).com_mm, margin)
    assert found.holds
    assert found.bound_mm < 0.9 * margin
    assert found.com_deviation_mm < 1e-6
    assert found.seam_kink_deg < 1.5e-4
    assert found.reason.startswith("The exported solid inherits the computed census")
    proven = transfer([solid], body, com, solid_mass(solid).com_mm, margin, "proven")
    assert proven.reason.startswith("The exported solid inherits the proof")


@pytest.mark.parametrize("name", ["primary", "sloan2-0.035"])
def test_bound_covers_an_independent_sampling_and_is_not_far_above_it(name: str) -> None:
    body = gomboc_cad.catalog()[name]
    patches = interpolate_patches(body.position_mm, 17)
    com = np.array(mass_properties(body).com_mm)
    found = transfer([patches_solid(patches)], body, com, com, 1.0)
    gradient, hessian = sampled_deviation(body, patches, com, 1_500)
    assert gradient <= found.gradient_deviation_mm <= 1.25 * gradient
    reach = np.linalg.norm(body.position_mm(geodesic_triangulation(4)[0]) - com, axis=1).max()
    stiffness = reach * hessian / (1.0 - hessian)
    assert stiffness <= found.hessian_deviation_mm <= 1.25 * stiffness


def test_sphere_too_large_by_a_constant() -> None:
    """About c, δ = const − e c·v on the sphere: |∇δ| and R ‖∇²δ‖ are both e |c| / R at their largest."""
    excess, com = 0.08, np.array([3.0, -4.0, 12.0])
    larger = SPHERE.with_diameter(SPHERE.diameter_mm + 2.0 * excess)
    solid = patches_solid(interpolate_patches(larger.position_mm, 17))
    found = transfer([solid], SPHERE, com, com, 1.0)
    exact = excess * 13.0 / 50.0
    reach = 50.08 + 13.0
    assert exact <= found.gradient_deviation_mm <= OVERSHOOT**2 * exact * 1.001
    assert exact / 50.0 * reach <= 1.001 * found.hessian_deviation_mm
    assert found.hessian_deviation_mm <= OVERSHOOT**2 * exact / 50.0 * reach * 1.02


def test_displaced_sphere_counts_as_a_displaced_centre() -> None:
    """δ = R s·v to first order, so gradient and stiffness deviate by s, as if the COM had moved by s."""
    shift = np.array([0.0, 6e-3, 8e-3])
    solid = patches_solid(interpolate_patches(lambda u: SPHERE.position_mm(u) + shift, 17))
    found = transfer([solid], SPHERE, ORIGIN, ORIGIN, 1.0)
    assert 1.001 * found.gradient_deviation_mm >= 0.01
    assert 1.001 * found.hessian_deviation_mm >= 0.01
    assert found.bound_mm <= OVERSHOOT**2 * np.sqrt(2.0) * 0.01 * 1.01


def test_finer_patches_come_closer_and_coarse_ones_are_refused(primary: Body) -> None:
    coarse, usual, fine = (
        transfer_of(primary, interpolate_patches(primary.position_mm, points)) for points in (11, 17, 25)
    )
    # The Hessian of a quintic interpolant is of fourth order: (24/16)⁴ = 5.06.
    assert usual.hessian_deviation_mm > 5.0 * fine.hessian_deviation_mm
    assert usual.seam_kink_deg > 5.0 * fine.seam_kink_deg
    assert not coarse.holds
    assert "smaller deviation, which takes finer patches" in coarse.reason


@pytest.mark.parametrize("diameter_mm", [25.0, 1000.0])
def test_everything_scales_with_the_body(diameter_mm: float, primary: Body) -> None:
    scale = diameter_mm / primary.diameter_mm
    usual, scaled = (
        transfer_of(body, interpolate_patches(body.position_mm, 17))
        for body in (primary, primary.with_diameter(diameter_mm))
    )
    assert scaled.holds
    for key in ("gradient_deviation_mm", "hessian_deviation_mm", "bound_mm", "seam_demand_mm"):
        assert getattr(scaled, key) == pytest.approx(scale * getattr(usual, key), rel=1e-4)
    assert scaled.min_curvature_per_mm == pytest.approx(usual.min_curvature_per_mm / scale, rel=1e-4)
    assert scaled.seam_kink_deg == pytest.approx(usual.seam_kink_deg, rel=1e-3)


def test_a_bump_is_noticed_before_it_makes_an_equilibrium(primary: Body) -> None:
    fine = interpolate_patches(primary.position_mm, 33)
    com = np.array(mass_properties(primary).com_mm)
    margin = MARGIN * primary.radius_mm
    rest = np.array([-1.0, 0.0, 0.0])
    counts = []
    for height_um in (0.1, 1.0):
        bumped = with_bump(fine, rest, height_um)
        found = transfer([patches_solid(bumped)], primary, com, com, margin)
        assert found.holds == (height_um < 1.0)
        counts.append(equilibria_of(bumped, com))
    assert counts == [2, 4]


def test_the_deviation_grows_in_proportion_to_a_bump(primary: Body) -> None:
    com = np.array(mass_properties(primary).com_mm)
    patches = interpolate_patches(primary.position_mm, 17)
    low, middle, high = (
        transfer(
            [patches_solid(with_bump(patches, unit(np.array([0.3, 0.2, 0.9])), h))], primary, com, com, 0.1
        )
        for h in (3.0, 30.0, 300.0)
    )
    assert high.gradient_deviation_mm == pytest.approx(10.0 * middle.gradient_deviation_mm, rel=0.05)
    assert middle.gradient_deviation_mm == pytest.approx(10.0 * low.gradient_deviation_mm, rel=0.05)
    assert high.seam_kink_deg == low.seam_kink_deg


def test_the_centre_of_mass_counts_in_full(primary: Body) -> None:
    com = np.array(mass_properties(primary).com_mm)
    margin = MARGIN * primary.radius_mm
    solid = body_solid(primary)
    there = transfer([solid], primary, com, com, margin)
    away = transfer([solid], primary, com, com + np.array([0.0, 0.0, 0.16]), margin)
    assert away.com_deviation_mm == pytest.approx(0.16)
    assert away.bound_mm == pytest.approx(there.bound_mm + 0.16, abs=1e-4)
    assert there.holds
    assert not away.holds


def test_an_equilibrium_on_an_edge_between_patches_is_not_decided(primary: Body) -> None:
    edge = unit(np.array([[-1.0, 1.0, 0.2]]))
    point = primary.surface(edge)
    com = (point.position_mm - 35.0 * point.normal)[0]
    solid = patches_solid(interpolate_patches(primary.position_mm, 25))
    found = transfer([solid], primary, com, com, com_margin(primary, com).margin_mm)
    assert not found.holds
    assert "next to an edge between two patches" in found.reason
    assert found.seam_gradient_mm <= found.seam_demand_mm


def test_a_dent_is_refused() -> None:
    body = gomboc_cad.catalog()["sloan2-0.035"]
    flat = np.array(gomboc_cad.equilibria.convexity(body).min_curvature_direction)
    dented = with_bump(interpolate_patches(body.position_mm, 17), flat, -20.0)
    found = transfer_of(body, dented)
    assert found.min_curvature_per_mm < 0.0
    assert "dented" in found.reason


def test_halves_of_a_housing_carry_the_patches_of_the_body(
    hollow_brep: Solid, primary: Body, tmp_path: Path
) -> None:
    com = mass_properties(primary).com_mm
    (whole,) = through_step(tmp_path, body_solid(primary))
    halves = through_step(tmp_path, *split_brep(hollow_brep, SEAM))
    of_halves = spline_faces(halves)
    assert all(any(face.same_as(other) for other in of_halves) for face in spline_faces([whole]))
    found, expected = (transfer(solids, primary, com, com, 0.165) for solids in (halves, [whole]))
    assert found == expected
    with pytest.raises(GeometryError, match="give all parts"):
        transfer(halves[:1], primary, com, com, 0.165)


@pytest.mark.parametrize(
    "make",
    [
        lambda body: Solid.make_box(1, 1, 1),
        lambda body: inset_solid(InsetSurface(body, 3.0)),
        lambda body: body_solid(gomboc_cad.catalog()["sloan2-0.030"]),
        lambda body: body_solid(body).faces()[0],
    ],
)
def test_a_solid_of_other_faces_is_an_error(make: Callable[[Body], Solid], primary: Body) -> None:
    with pytest.raises(GeometryError, match="cannot be compared"):
        transfer([make(primary)], primary, ORIGIN, ORIGIN, 0.1)


def test_a_body_that_is_not_convex_is_an_error() -> None:
    second = gomboc_cad.catalog()["second"]
    with pytest.raises(NotConvexError):
        transfer([body_solid(second)], second, ORIGIN, ORIGIN, 0.1)


@settings(deadline=None)
@given(arrays(float, NODES, elements=st.floats(-1.0, 1.0)))
def test_no_polynomial_exceeds_its_bound_from_the_fine_grid(coefficients: Array) -> None:
    fine = chebyshev.chebval(chebyshev_grid().fine_points, coefficients)
    dense = chebyshev.chebval(np.linspace(-1.0, 1.0, 5_001), coefficients)
    assert np.abs(dense).max() <= OVERSHOOT * np.abs(fine).max() + 1e-12


@settings(deadline=None)
@given(arrays(float, (3, NODES), elements=st.floats(-1.0, 1.0)))
def test_no_curve_comes_nearer_to_the_origin_than_its_bound(coefficients: Array) -> None:
    grid = chebyshev_grid().fine_points
    assert len(grid) == FINER * (NODES - 1) + 1
    curve = chebyshev.chebval(grid, coefficients.T).T
    dense = chebyshev.chebval(np.linspace(-1.0, 1.0, 5_001), coefficients.T).T
    assert least_modulus(curve[None]) <= np.linalg.norm(dense, axis=1).min() + 1e-12


def test_a_straight_line_is_measured_exactly() -> None:
    grid = chebyshev_grid().fine_points
    line = np.stack([grid - 0.0123, np.full_like(grid, 0.5), np.zeros_like(grid)], axis=-1)
    assert least_modulus(line[None]) == pytest.approx(0.5, abs=1e-12)
