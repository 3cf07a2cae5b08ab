"""The sphere with ballast that a design is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gomboc_cad.body import mass_properties
from gomboc_cad.tolerance.acceptance import Effort, Target
from gomboc_cad.tolerance.baseline import concentric_sphere, sphere_baseline
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.variants import Nominal, Outcomes, Variants
from tests.tolerance.toys import LoadedSphere

TILTED = Target(Requirement(max_tilt_deg=10.0))


def test_a_sphere_with_ballast_is_worth_just_that() -> None:
    """The design is judged by its closed form, the spheres by the census."""
    design = LoadedSphere(lowered_mm=1.0, across_mm=0.08, along_mm=0.1)
    found = sphere_baseline(design, TILTED, Effort(512))
    assert found.radius_mm == pytest.approx(50.0)
    assert found.design_lowering_mm == pytest.approx(1.0)
    assert found.same_margin_mm == pytest.approx(1.0)
    assert found.same_yield_mm == pytest.approx(1.0, rel=0.03)
    assert found.same_tilt_mm == pytest.approx(1.0, rel=0.025)
    assert found.sphere_good == found.design_good
    assert 0.8 < found.design_good.estimate < 0.99
    assert not found.shape_is_worth_it


def test_the_tilt_of_spheres_is_that_of_their_com() -> None:
    design = LoadedSphere(lowered_mm=2.0, across_mm=0.1, along_mm=0.0)
    sphere = concentric_sphere(design).with_com_shift((0.0, 0.0, -0.5))
    rows = np.random.default_rng(0).random((200, 3))
    made = sphere.variants(rows)
    outcomes = sphere.judge(made)
    across = np.hypot(made.com_mm[:, 0], made.com_mm[:, 1])
    assert made.com_mm[:, 2] == pytest.approx(-0.5)
    assert outcomes.tilt_deg == pytest.approx(np.degrees(np.arctan2(across, 0.5)), abs=1e-6)


def test_a_design_with_more_margin_than_its_lowering_is_worth_its_shape() -> None:
    """A study whose parts rest more truly than a sphere with such a COM could."""

    class Stiff(LoadedSphere):
        def judge(self, variants: Variants) -> Outcomes:
            outcomes = super().judge(variants)
            return replace(outcomes, tilt_deg=0.1 * outcomes.tilt_deg, s_margin_mm=2.0 * outcomes.s_margin_mm)

    found = sphere_baseline(Stiff(lowered_mm=1.0, across_mm=0.3, along_mm=0.0), TILTED, Effort(512))
    assert found.same_margin_mm == pytest.approx(2.0)
    # 95 % of the COM errors are shorter than this, by Rayleigh's distribution.
    error_mm = 0.3 * np.sqrt(-2.0 * np.log(0.05))
    assert found.same_tilt_mm == pytest.approx(error_mm / np.tan(0.1 * np.arctan(error_mm)), rel=0.03)
    assert found.same_yield_mm is not None
    assert found.same_yield_mm > 2.0
    assert found.shape_is_worth_it
    assert "the shape is worth it" in found.sentence


def test_the_sphere_has_the_volume_and_the_seam_of_the_design() -> None:
    design = LoadedSphere()
    sphere = concentric_sphere(design)
    assert mass_properties(sphere.nominal.body).volume_mm3 == pytest.approx(
        mass_properties(design.nominal.body).volume_mm3
    )
    assert sphere.nominal.seam == design.nominal.seam
    assert sphere.sources == design.sources
    assert isinstance(sphere.nominal, Nominal)


def test_parts_without_one_rest_have_no_equal_in_tilt() -> None:
    """More than one part in twenty has several rests: there is no tilt that 95 % stay within."""
    design = LoadedSphere(lowered_mm=1.0, margin_mm=0.2)
    found = sphere_baseline(design, Target(Requirement()), Effort(512))
    assert found.same_tilt_mm is None
    assert found.document()["same_tilt_mm"] is None
