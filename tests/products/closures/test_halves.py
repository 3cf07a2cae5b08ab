"""Every kind of closure leaves two sound halves, the same from both kernels, and parts that do not meet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gomboc_cad.body import depth_mm
from gomboc_cad.products.closures.layout import lay_out_closure
from gomboc_cad.products.closures.spec import PressSpec, SnapSpec
from gomboc_cad.solid import hollow
from gomboc_cad.solid.export import write_step, write_stl
from gomboc_cad.solid.facets import facet_normals
from gomboc_cad.solid.inspect import Expected, inspect_file
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.step import NamedSolid
from tests.products.closures.sites import (
    SAG_UM,
    SHIFT_MM,
    SPECS,
    Halves,
    halves_of,
    layout_of,
    overlap_mm3,
    site_of,
    split,
)


def assert_kernels_agree(halves: Halves) -> None:
    """The sag bounds what may lie between a mesh and its solid."""
    for solid, mesh in zip(halves.solids, halves.meshes, strict=True):
        assert solid.is_valid
        made, meshed = solid_mass(solid), mesh.mass()
        assert abs(made.volume_mm3 - meshed.volume_mm3) < 1e-3 * SAG_UM * area_mm2(mesh)
        assert np.allclose(made.com_mm, meshed.com_mm, atol=2e-3 * SAG_UM)


def area_mm2(mesh: Mesh) -> float:
    return float(facet_normals(mesh)[1].sum())


@pytest.mark.parametrize("kind", SPECS)
def test_both_kernels_make_the_same_halves(kind: str) -> None:
    assert_kernels_agree(halves_of(kind))


@pytest.mark.parametrize("kind", ["screws", "thread-ring"])
def test_a_flat_seam_loses_no_material(kind: str) -> None:
    """Both halves together are the uncut hollow body."""
    halves = halves_of(kind)
    lower, upper = (solid_mass(solid).volume_mm3 for solid in halves.solids)
    whole = solid_mass(hollow.brep(halves.hollow)).volume_mm3
    assert lower + upper == pytest.approx(whole, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["screws", "snap", "press"])
def test_files_of_the_halves_are_on_their_surfaces(kind: str, tmp_path: Path) -> None:
    """Read back, STEP and STL lie on the analytic surfaces of a half whose core moved."""
    halves = halves_of(kind)
    for name, solid, mesh, boundary in zip(
        ("lower", "upper"), halves.solids, halves.meshes, halves.boundaries, strict=True
    ):
        mass = solid_mass(solid)
        write_step(tmp_path / f"{name}.step", [NamedSolid(name, solid)], name)
        write_stl(tmp_path / f"{name}.stl", mesh, name)
        for suffix, distance_um in (("step", 0.2), ("stl", SAG_UM)):
            expected = Expected(name, mass.volume_mm3, mass.com_mm, distance_um, boundary)
            assert inspect_file(tmp_path / f"{name}.{suffix}", [expected]).problems == ()


@pytest.mark.parametrize("kind", ["dowels", "screws", "tapped", "thread-ring"])
def test_parts_are_in_place_and_touch_nothing(kind: str) -> None:
    """Only inserts are wider than their holes; they end at the seam, where the frame's up is x."""
    layout, halves = layout_of(kind).moved(np.array(SHIFT_MM)), halves_of(kind)
    parts = {part.name: part for part in layout.parts}
    one_of_each = {name.rstrip("-0123456789"): part for name, part in parts.items()}
    for name, part in one_of_each.items():
        if name == "closure-insert":
            top = part.solid.bounding_box().max.X
            assert top == pytest.approx(layout.seam.origin_mm[0], abs=1e-5)
        else:
            shared = [overlap_mm3(part.solid, half) for half in halves.solids]
            assert shared == pytest.approx([0.0, 0.0], abs=1e-6)
        assert np.all(depth_mm(layout.site.body, np.array([part.com_mm])) > 0.0)
    assert set(layout.upper_parts) <= set(parts)
    heights = {name: float(np.dot(part.com_mm, layout.site.frame.up)) for name, part in parts.items()}
    seam = float(np.dot(layout.seam.origin_mm, layout.site.frame.up))
    assert all(heights[name] > seam for name in layout.upper_parts)


@pytest.mark.parametrize(
    ("kind", "standards"),
    [
        ("dowels", {"ISO 8734 3 x 10"}),
        ("screws", {"ISO4762 M2-0.4 x 8", "CNCKitchen M2-0.4-3"}),
        ("tapped", {"ISO4762 M2-0.4 x 8"}),
        ("thread-ring", {""}),
        ("snap", set()),
        ("press", set()),
    ],
)
def test_bought_parts_name_their_standard(kind: str, standards: set[str]) -> None:
    parts = layout_of(kind).parts
    assert {part.standard for part in parts} == standards
    assert all(part.made == (part.standard == "") for part in parts)


def test_the_layout_moves_with_its_core() -> None:
    layout = layout_of("screws")
    moved = layout.moved(np.array(SHIFT_MM))
    for before, after in zip(layout.parts, moved.parts, strict=True):
        assert np.subtract(after.com_mm, before.com_mm) == pytest.approx(SHIFT_MM)
    assert np.subtract(moved.seam.origin_mm, layout.seam.origin_mm) == pytest.approx(SHIFT_MM)
    assert (moved.bosses, moved.holes) == (layout.bosses, layout.holes)
    for before, after in zip(layout.openings, moved.openings, strict=True):
        assert after.name == before.name
        assert after.com_clearance_mm != before.com_clearance_mm


@pytest.mark.parametrize(
    "spec",
    [
        PressSpec(kind="press"),
        SnapSpec(kind="snap", height_mm=4.0),
    ],
)
def test_a_solid_body_gets_a_bore_instead_of_a_flange(spec: PressSpec | SnapSpec) -> None:
    layout = lay_out_closure(spec, site_of(40.0, bore_radius_mm=4.0))
    assert layout.bosses == ()
    assert_kernels_agree(split(layout))
