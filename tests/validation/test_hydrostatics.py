"""Hydrostatics against closed forms and classical results.

Each test names its source. Bodies with curved surfaces are meshed, so their figures hold up to the fineness
of the mesh.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.hydrostatics import FRESH_WATER, SEA_WATER, FloatingCensus, FloatingPose, floating_state
from tests.equilibria.polyhedra import hull_mesh, prism
from tests.hydrostatics.hulls import ball, box, census_with, float_with, mass_for, revolution


def stable(census: FloatingCensus) -> list[FloatingPose]:
    return [pose for pose in census.poses if pose.kind == "stable"]


@pytest.mark.parametrize("share", [0.05, 0.3, 0.5, 0.9])
def test_a_ball_floats_at_the_draft_of_the_spherical_cap(share: float) -> None:
    """A cap of height T has the volume π T² (3R − T) / 3; GM is the depth of the COM below the centre.

    The metacentre of a ball is its centre, because all pressures pass through it.
    """
    drop = 0.07
    state = float_with(ball(5), share, (0.0, 0.0, -drop), (0.0, 0.0, 1.0))
    draft = next(t.real for t in np.roots([1.0, -3.0, 0.0, 4.0 * share]) if 0.0 < t.real < 2.0)
    center = -3.0 * (2.0 - draft) ** 2 / (4.0 * (3.0 - draft))
    assert state.draft_mm == pytest.approx(draft, abs=1e-3)
    assert state.draft_mm + state.freeboard_mm == pytest.approx(2.0, abs=1e-3)
    assert state.waterplane_area_mm2 == pytest.approx(np.pi * draft * (2.0 - draft), rel=2e-3)
    assert state.center_of_buoyancy_mm == pytest.approx((0.0, 0.0, center), abs=1e-3)
    assert state.gm_mm == pytest.approx((drop, drop), abs=1e-3)
    assert state.reserve_buoyancy == pytest.approx(1.0 - share)


@given(
    length=st.floats(1.0, 9.0),
    beam=st.floats(1.0, 9.0),
    depth=st.floats(1.0, 9.0),
    share=st.floats(0.05, 0.95),
)
@settings(max_examples=50, deadline=None)
def test_an_upright_box_has_the_metacentric_radii_of_the_textbook(
    length: float, beam: float, depth: float, share: float
) -> None:
    """BM = B² / 12 T and L² / 12 T, KB = T / 2: any text on ship stability."""
    state = float_with(box(length, beam, depth), share, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    draft = share * depth
    radii = np.sort([beam**2, length**2]) / (12.0 * draft)
    assert state.draft_mm == pytest.approx(draft)
    assert state.freeboard_mm == pytest.approx(depth - draft)
    assert state.waterplane_area_mm2 == pytest.approx(length * beam)
    assert state.bm_mm == pytest.approx(radii)
    assert state.gm_mm == pytest.approx(radii - (depth - draft) / 2.0)


@pytest.mark.parametrize(
    ("share", "count", "tangent"),
    [
        (0.15, 4, 0.0),
        (0.205, 4, 0.0),
        (0.22, 8, None),
        (0.25, 8, 0.5),
        (0.275, 8, None),
        (0.29, 4, 1.0),
        (0.5, 4, 1.0),
        (0.71, 4, 1.0),
        (0.75, 8, 0.5),
        (0.80, 4, 0.0),
    ],
)
def test_a_square_log_floats_as_archimedes_would_have_found(
    share: float, count: int, tangent: float | None
) -> None:
    """Poses of a long square log over its relative density s, and their tilt θ.

    Flat for 6 s (1 − s) < 1, that is s < (1 − 1/√3) / 2 = 0.2113; corner up for 9/32 < s < 23/32; between
    them at tan²θ = 12 s (1 − s) − 2 as long as the water cuts opposite sides (s ≤ 1/4); the same for s and
    1 − s. Source: Gilbert, "How things float", Am. Math. Monthly 98 (1991) 201; it follows from
    BM = B² / 12 T and, corner down, BM = 2 d / 3 = depth of the corner under the centre of buoyancy at
    the draft d = sqrt(s) B.
    """
    census = census_with(box(5.0, 1.0, 1.0), share)
    assert (census.stable, census.saddles, census.unstable) == (count, count, 2)
    assert census.verdict == "multistable"
    if tangent is not None:
        for pose in stable(census):
            low, high = np.sort(np.abs(pose.up[1:]))
            assert pose.up[0] == pytest.approx(0.0, abs=1e-6)
            assert low / high == pytest.approx(tangent, abs=1e-6)


def test_the_barrier_of_a_square_log_is_that_of_its_two_closed_forms() -> None:
    """At s = 1/2: flat (1 − s) B / 2 = B / 4, corner up B √2 / 6, the centroid of the triangle below."""
    census = census_with(box(5.0, 1.0, 1.0), 0.5)
    for pose in stable(census):
        assert pose.state.com_over_buoyancy_mm == pytest.approx(np.sqrt(2.0) / 6.0)
        assert pose.barrier_mm == pytest.approx(0.25 - np.sqrt(2.0) / 6.0)
        assert pose.barrier_mj == pytest.approx(9.80665e-3 * census.mass_g * pose.barrier_mm)


@pytest.mark.parametrize(("radius", "share"), [(0.5, 0.5), (0.72, 0.5), (0.6, 0.2), (0.55, 0.2), (0.4, 0.95)])
def test_an_upright_cylinder_is_stable_if_it_is_wide_enough(radius: float, share: float) -> None:
    """GM = R² / 4T − (H − T) / 2, so a cylinder floats upright if (R/H)² > 2 s (1 − s)."""
    mesh = hull_mesh(prism(256, 1.0, radius=radius))
    state = float_with(mesh, share, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    expected = radius**2 / (4.0 * share) - (1.0 - share) / 2.0
    assert state.gm_mm == pytest.approx((expected, expected), abs=1e-3)
    assert (min(state.gm_mm) > 0.0) == (radius**2 > 2.0 * share * (1.0 - share))


@pytest.mark.parametrize(
    ("height", "share"),
    [(0.7, 0.05), (0.74, 0.5), (1.0, 0.05), (1.0, 0.08), (1.5, 0.2), (1.5, 0.3), (1.5, 0.9)],
)
def test_a_paraboloid_floats_upright_as_archimedes_proved(height: float, share: float) -> None:
    """r² = p z floats with its apex down if its axis H ≤ 3p/4, or else if s ≥ ((H − 3p/4) / H)².

    Source: Archimedes, On Floating Bodies II, propositions 2 and 4. With the draft T = H sqrt(s), GM is
    2T/3 + p/2 − 2H/3.
    """
    z = height * np.linspace(0.0, 1.0, 80) ** 2
    mesh = revolution(np.column_stack([np.sqrt(z), z]))
    state = float_with(mesh, share, (0.0, 0.0, 2.0 * height / 3.0), (0.0, 0.0, 1.0))
    draft = height * np.sqrt(share)
    assert state.draft_mm == pytest.approx(draft, rel=1e-3)
    assert state.gm_mm == pytest.approx([2.0 * draft / 3.0 + 0.5 - 2.0 * height / 3.0] * 2, abs=2e-3)
    proved = height <= 0.75 or share >= ((height - 0.75) / height) ** 2
    assert (min(state.gm_mm) > 0.0) == proved


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_ball_with_a_lowered_com_has_one_stable_pose(share: float) -> None:
    """The centre of buoyancy is under the centre of the ball, so E varies by twice the drop of the COM."""
    com = np.array([0.02, -0.03, 0.06])
    census = census_with(ball(3), share, com)
    drop = np.linalg.norm(com)
    assert (census.stable, census.saddles, census.unstable) == (1, 0, 1)
    assert census.verdict == "monostable"
    assert stable(census)[0].up == pytest.approx(-com / drop, abs=2e-3)
    assert census.depth_mm == pytest.approx(2.0 * drop, rel=1e-3)


def test_a_heavy_keel_below_the_center_of_buoyancy_is_no_trouble() -> None:
    census = census_with(ball(3), 0.3, (0.0, 0.0, -0.8))
    assert stable(census)[0].state.com_over_buoyancy_mm < 0.0
    assert (census.stable, census.verdict) == (1, "monostable")


def test_a_ball_about_its_center_floats_in_every_pose() -> None:
    census = census_with(ball(4), 0.5, (0.0, 0.0, 0.0))
    assert [(pose.kind, pose.extent) for pose in census.poses] == [("stable", "sphere")]
    assert census.verdict == "undecided"
    assert census.evidence.exact_stable is None


def test_a_long_cylinder_floats_in_a_ring_of_poses_on_its_side() -> None:
    """E = 4 R / 3π there at s = 1/2, the centroid of a half disc, and H / 4 upright."""
    census = census_with(hull_mesh(prism(96, 4.0)), 0.5)
    (side,) = stable(census)
    assert side.extent == "ring"
    assert side.up[2] == pytest.approx(0.0, abs=1e-6)
    assert side.state.com_over_buoyancy_mm == pytest.approx(4.0 / (3.0 * np.pi), rel=1e-3)
    ends = [pose for pose in census.poses if pose.kind == "unstable"]
    assert sorted(pose.up[2] for pose in ends) == pytest.approx([-1.0, 1.0])
    assert [pose.state.com_over_buoyancy_mm for pose in ends] == pytest.approx([1.0, 1.0])
    assert census.verdict == "undecided"


def test_a_flat_disc_floats_on_both_faces() -> None:
    census = census_with(hull_mesh(prism(96, 0.7)), 0.5)
    assert [abs(pose.up[2]) for pose in stable(census)] == pytest.approx([1.0, 1.0])
    assert {pose.extent for pose in census.poses if pose.kind == "unstable"} == {"ring"}


def test_a_part_floats_higher_in_the_sea() -> None:
    """Archimedes' principle: drafts of a box are as the densities of the waters."""
    mesh = box(4.0, 4.0, 4.0)
    drafts = [
        floating_state(*mesh, mass_for(mesh, 0.6), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), water).draft_mm
        for water in (FRESH_WATER, SEA_WATER)
    ]
    assert drafts == pytest.approx([2.4 / 0.9982, 2.4 / 1.025])
