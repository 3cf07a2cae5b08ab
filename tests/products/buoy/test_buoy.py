"""The buoy: its centre of mass, its watertight recess, how it floats, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gomboc_cad.body import depth_mm
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GeometryError, GombocError, SpecError
from gomboc_cad.products.assembly import Assembly, center_of_mass
from gomboc_cad.products.batteries import load_battery
from gomboc_cad.products.buoy.floating import check_displacement, float_buoy, water_of
from gomboc_cad.products.buoy.layout import BuoyLayout, lay_out_buoy
from gomboc_cad.products.buoy.recipe import HYDROSTATICS_FILE, LOWER, UPPER, design_buoy
from gomboc_cad.products.buoy.spec import BuoySpec, WaterSpec
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.placing.com_placement import com_target
from gomboc_cad.products.toml_model import parse_model, read_toml
from gomboc_cad.products.verdict import judge
from gomboc_cad.resources import template_folder
from gomboc_cad.solid.hollow import Cylinder, HollowBody

Changes = dict[str, Any]

GLUED: Changes = {"kind": "dowels", "diameter_mm": 5.0, "length_mm": 16.0}
"""A closure that is laid out in no time."""


def spec_with(**tables: Changes) -> BuoySpec:
    """The template with some keys changed, or a whole table where it has a `kind`; meshes are coarser."""
    data = read_toml(template_folder() / "buoy.toml")
    for name, changes in ({"mesh": {"sag_um": 400.0}} | tables).items():
        data[name] = changes if "kind" in changes else data.get(name, {}) | changes
    return parse_model(BuoySpec, data, "buoy.toml")


def layout_of(spec: BuoySpec) -> BuoyLayout:
    body = spec.body.body()
    return lay_out_buoy(spec, body, load_battery(spec.battery.type), com_target(spec.com.target, body))


@pytest.fixture(scope="module")
def buoy() -> ProductDesign:
    """The buoy of the template."""
    return design_buoy(spec_with())


@pytest.fixture(scope="module")
def layout() -> BuoyLayout:
    """Its layout, before the core is moved."""
    return layout_of(spec_with())


def part(design: ProductDesign, name: str):
    return next(part for part in design.assembly.parts if part.name == name)


def in_void(hollow: HollowBody, points_mm: Array) -> Array:
    """Whether points lie in the cavity beside all bosses."""
    assert hollow.inner is not None
    void = hollow.inner.signed_distance_mm(points_mm) < 0.0
    for boss in hollow.placed_bosses:
        void &= ~boss.contains(points_mm)
    return void


def around(cylinder: Cylinder, margin_mm: float) -> Array:
    """Points of the hull of a cylinder grown by a margin on its side and at its base."""
    grown = replace(
        cylinder.extended(margin_mm, 0.0), radius_mm=cylinder.radius_mm + margin_mm, inner_radius_mm=0.0
    )
    low, high = np.split(grown.rims_mm(48), 2)
    share = np.linspace(0.0, 1.0, 40)[:, None, None]
    side = (low + share * (high - low)).reshape(-1, 3)
    end = (low.mean(axis=0) + share * (low - low.mean(axis=0))).reshape(-1, 3)
    return np.concatenate([side, end])


def test_the_centre_of_mass_is_on_its_target(buoy: ProductDesign) -> None:
    assembly = buoy.assembly
    assert assembly.com_target_mm == (-30.0, 0.0, 0.0)
    assert assembly.com_residual_um < 0.11
    by_hand = center_of_mass([(part.mass_g, part.com_mm) for part in assembly.parts])
    assert np.allclose(assembly.com_mm, by_hand, atol=1e-9)
    limit = buoy.spec.shell.wall_mm - (buoy.spec.shell.min_wall_mm or 0.0)
    assert np.linalg.norm(buoy.placement.core_shift_mm) <= limit


def test_it_rights_itself_on_a_flat_floor_with_the_eye_below(buoy: ProductDesign) -> None:
    verdict = judge(buoy.body, buoy.assembly.com_mm)
    assert verdict.passed
    assert verdict.census is not None
    assert np.allclose(verdict.census.rest.direction, -np.array(buoy.frame.up), atol=1e-6)
    eye = np.array(part(buoy, "eye-bolt").com_mm)
    assert eye @ np.array(buoy.frame.up) < -0.7 * buoy.body.radius_mm
    assert [opening.state for opening in buoy.openings].count("forced") == 0
    assert buoy.openings[0].state == "rest"


def test_the_ballast_is_what_the_moment_asks_for(buoy: ProductDesign, layout: BuoyLayout) -> None:
    """It weighs what a turned ring weighs, and without it the centre of mass is higher by what is said."""
    ballast = part(buoy, "ballast")
    inner, outer = layout.ballast_radii_mm
    (cost,) = [cost for cost in buoy.placement.costs if cost.variable == "ballast"]
    steel = load_material("steel").density_g_cm3
    assert ballast.mass_g == pytest.approx(1e-3 * steel * math.pi * (outer**2 - inner**2) * cost.amount)
    assert cost.amount == pytest.approx(round(cost.amount, 1))
    others = center_of_mass([(p.mass_g, p.com_mm) for p in buoy.assembly.parts if p is not ballast])
    raised = float((others - np.array(buoy.assembly.com_mm)) @ np.array(buoy.frame.up))
    assert raised == pytest.approx(1e-3 * cost.com_effect_um, rel=0.02)


def test_the_mooring_recess_does_not_open_the_cavity(buoy: ProductDesign, layout: BuoyLayout) -> None:
    """All around recess and core hole there is material, with the core where it ended up."""
    assert layout.mooring is not None
    hollow = layout.hollow_at(buoy.placement.core_shift_mm)
    wall = buoy.spec.shell.min_wall_mm
    assert wall is not None
    for hole in (layout.mooring.recess.tool, layout.mooring.thread_hole):
        assert not in_void(hollow, around(hole, wall)).any()
    # The same look finds the cavity when it is there: a recess that is 15 mm deeper.
    deeper = layout.mooring.recess.tool.extended(30.0, 0.0)
    assert in_void(hollow, around(deeper, wall)).any()


def test_bought_parts_stay_under_the_surface(buoy: ProductDesign) -> None:
    """Nothing but the shell may touch the floor."""
    for name in ("eye-bolt", "port-plug", "closure-screw-1"):
        points = np.array([tuple(vertex) for vertex in part(buoy, name).solid.vertices()])
        assert depth_mm(buoy.body, points).min() > 0.5


@pytest.mark.parametrize("name", ["battery", "electronics", "ballast", "o-ring", "eye-bolt", "port-plug"])
def test_parts_do_not_overlap_the_shell(buoy: ProductDesign, name: str) -> None:
    content = part(buoy, name)
    for half in (LOWER, UPPER):
        common = content.solid.intersect(part(buoy, half).solid)
        shared = 0.0 if common is None else sum(solid.volume for solid in common.solids())
        assert shared < 1e-4 * content.volume_mm3


def test_two_kernels_agree_on_both_halves(buoy: ProductDesign) -> None:
    """The meshes come from manifold3d, the solids from OCCT; the sag bounds what may lie between them."""
    sag_mm = 1e-3 * buoy.spec.mesh.sag_um
    for name in (LOWER, UPPER):
        half = part(buoy, name)
        assert half.mesh is not None
        mesh = half.mesh.mass()
        assert abs(mesh.volume_mm3 - half.volume_mm3) < half.solid.area * sag_mm
        assert np.allclose(mesh.com_mm, half.com_mm, atol=0.2)


def test_the_o_ring_lies_in_the_lower_half_between_cavity_and_screws(buoy: ProductDesign) -> None:
    up = np.array(buoy.frame.up)
    ring, screw = part(buoy, "o-ring"), part(buoy, "closure-screw-1")
    size = ring.solid.bounding_box().size
    outer = 0.5 * max(size.Y, size.Z)
    place = np.array(screw.com_mm) - np.array(screw.com_mm) @ up * up
    assert outer < np.linalg.norm(place) - 2.75
    assert ring.standard.startswith("O-ring ISO 3601-1")


def test_it_floats_upright_and_archimedes_holds(buoy: ProductDesign) -> None:
    document = buoy.documents(judge(buoy.body, buoy.assembly.com_mm))[HYDROSTATICS_FILE]
    floating = document["floating"]
    assert floating["stable"] == 1
    lowest = floating["poses"][0]
    assert lowest["heel_deg"] < 1.0
    for state in (lowest, document["upright"]):
        assert state["displaced_volume_mm3"] == pytest.approx(1e3 * buoy.assembly.mass_g / 1.025)
        height = state["draft_mm"] + state["freeboard_mm"]
        assert height == pytest.approx(buoy.body.diameter_mm, rel=0.03)
    assert lowest["gm_mm"][0] > 20.0
    assert len(document["upright"]["waterline_mm"]) == 1


def test_both_verdicts_stand_side_by_side(buoy: ProductDesign) -> None:
    verdict = judge(buoy.body, buoy.assembly.com_mm)
    document = buoy.documents(verdict)[HYDROSTATICS_FILE]
    assert document["flat_floor"] == {"verdict": "PASS", "stable": 1}
    assert document["floating"]["verdict"] == "monostable"
    assert any("waves" in what for what in document["not_modelled"])
    assert "apart from the verdict on the flat floor" in buoy.summary["floating"]["sentence"]
    # A fail on the floor says nothing about floating, and the other way round.
    failed = replace(verdict, verdict="FAIL")
    other = buoy.documents(failed)[HYDROSTATICS_FILE]
    assert other["flat_floor"]["verdict"] == "FAIL"
    assert other["floating"] == document["floating"]


def test_with_the_centre_of_mass_at_the_best_place_it_floats_heeled(buoy: ProductDesign) -> None:
    """One rest on the floor does not make it float upright: that takes ballast, or a flooded recess below."""
    best = com_target("best", buoy.body)
    assert judge(buoy.body, best).passed
    light = Assembly("buoy", (replace(part(buoy, LOWER), mass_g=7000.0, com_mm=best),), best)
    floating = float_buoy(buoy.body, (), light, buoy.frame.up, water_of(WaterSpec()))
    assert floating.heel_deg(floating.lowest) > 20.0
    assert "heeled by" in floating.sentence
    assert floating.upright.gm_mm[0] == pytest.approx(floating.gm_with_air_mm)
    assert floating.upright.gm_mm[0] < 0.0


def test_fresh_water_carries_less(buoy: ProductDesign) -> None:
    volume = 14.0e6
    mass = 14.1e3
    check_displacement(mass, volume, water_of(WaterSpec(kind="sea")))
    with pytest.raises(GeometryError, match=r"weighs 14100 g and can displace 13975 g of fresh water"):
        check_displacement(mass, volume, water_of(WaterSpec(kind="fresh")))


def test_a_heavier_battery_by_its_tolerance_moves_the_centre_of_mass(buoy: ProductDesign) -> None:
    """`δc = δm (p − c) / M` for a small δm."""
    battery = part(buoy, "battery")
    tolerance = load_battery("sla-12v-7ah").mass_tolerance_g
    (found,) = [u for u in buoy.uncertainties if "mass of the battery" in u.source]
    arm = np.subtract(battery.com_mm, buoy.assembly.com_mm)
    assert np.allclose(found.com_error_mm, tolerance * arm / buoy.assembly.mass_g)
    assert len(buoy.uncertainties) == 6


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        (
            {"battery": {"type": "sla-12v-4ah"}, "split": {"height_mm": -30.0}},
            r"battery .* does not fit: its tube",
        ),
        ({"shell": {"wall_mm": 50.0}}, r"does not fit"),
        ({"mooring": {"recess_diameter_mm": 40.0}}, r"recess of 40 mm leaves no room .* at least 42 mm"),
        ({"ballast": {"outer_diameter_mm": 60.0}}, r"ballast ring of 60 mm does not go around .* 68 mm"),
        ({"flange": {"thickness_mm": 5.0}}, r"thickness_mm = 5 leaves too little .* at least 7.3 mm"),
        ({"flange": {"inside_diameter_mm": 291.47}}, r"groove of the O-ring .* reaches"),
        ({"port": {"direction": [-1.0, 0.02, 0.0]}}, r"filling port and the mooring recess meet"),
    ],
    ids=["battery-too-tall", "wall", "eye", "ballast", "flange", "o-ring", "openings-meet"],
)
def test_what_does_not_fit_is_one_sentence(tables: dict[str, Changes], words: str) -> None:
    with pytest.raises(GombocError, match=words) as caught:
        layout_of(spec_with(closure=GLUED, **tables))
    assert str(caught.value).count(". ") == 0
    assert str(caught.value).endswith(".")


def test_a_wall_below_the_process_minimum_is_refused() -> None:
    with pytest.raises(SpecError, match=r"shell.wall_mm = 0.4 is thinner"):
        design_buoy(spec_with(shell={"wall_mm": 0.4, "min_wall_mm": 0.3}))


def test_a_buoy_heavier_than_its_displacement_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"heavier than its displacement: it weighs 1\d{4} g"):
        design_buoy(spec_with(closure=GLUED, electronics={"mass_g": 12000.0}, ballast={"mass_g": 0.0}))


def test_ballast_that_the_bay_does_not_hold_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"ballast does not fit: its bay takes 42.* mm of steel"):
        design_buoy(spec_with(closure=GLUED, com={"target": [-75.0, 0.0, 0.0]}))


@pytest.mark.parametrize(
    ("table", "key", "value", "words"),
    [
        ("body", "diameter_mm", 200.0, r"body.diameter_mm = 200 is no size of a buoy .*300 to 1000"),
        ("water", "kind", "other", r"density_g_cm3 goes with kind"),
        ("mooring", "eye", "M12", r"mooring.eye = 'M12' is not allowed \(allowed: M6, M8, M10, none\)"),
        ("port", "plug", "G1/2", r"port.plug = 'G1/2' is not allowed"),
    ],
)
def test_wrong_keys_are_told(table: str, key: str, value: Any, words: str) -> None:
    with pytest.raises(SpecError, match=words):
        spec_with(**{table: {key: value}})


def test_a_users_own_battery_beside_the_spec_is_used(tmp_path: Path) -> None:
    text = (template_folder() / "batteries" / "sla-12v-7ah.toml").read_text(encoding="utf-8")
    big = text.replace("size_mm = [151.0, 94.0, 65.0]", "size_mm = [260.0, 180.0, 65.0]")
    (tmp_path / "big.toml").write_text(big, encoding="utf-8")
    with pytest.raises(GeometryError, match=r"The battery .* does not fit"):
        design_buoy(spec_with(battery={"type": "big.toml"}), tmp_path)


@pytest.mark.slow
def test_gap_and_step_of_the_seam_move_the_upper_half_with_what_is_screwed_into_it(
    buoy: ProductDesign,
) -> None:
    apart = design_buoy(spec_with(split={"gap_mm": 0.5, "step_mm": [0.2, 0.0]}))
    moved = {
        name: np.subtract(part(apart, name).com_mm, part(buoy, name).com_mm)
        - np.subtract(apart.placement.core_shift_mm, buoy.placement.core_shift_mm)
        for name in ("closure-screw-1", "closure-insert-1", "battery")
    }
    lift = apart.frame.point(0.2, 0.0, 0.5)
    assert np.allclose(moved["closure-screw-1"], lift, atol=1e-6)
    assert np.allclose(moved["closure-insert-1"], 0.0, atol=1e-6)
    assert np.allclose(moved["battery"], 0.0, atol=1e-6)
    assert apart.assembly.com_residual_um < 0.11
