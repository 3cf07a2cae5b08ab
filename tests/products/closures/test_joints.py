"""What holds the parts together: snaps that catch, fits that press, threads that mesh, by closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gomboc_cad.body import depth_mm
from gomboc_cad.errors import GeometryError, SpecError
from gomboc_cad.products.closures import DowelsSpec, PressSpec, ScrewsSpec, SnapSpec, ThreadRingSpec
from gomboc_cad.products.closures.elasticity import load_elasticity
from gomboc_cad.products.closures.fits import iso_fit
from gomboc_cad.products.closures.layout import lay_out_closure
from gomboc_cad.products.closures.press import press_stress
from gomboc_cad.products.closures.spec import ClosureSpec
from gomboc_cad.solid import hollow
from gomboc_cad.solid.facets import facet_normals
from gomboc_cad.solid.hollow.tools import Cylinder, Ellipsoid
from gomboc_cad.solid.mass import solid_mass
from tests.products.closures.sites import RING_SAG_UM, halves_of, layout_of, shared_mm3, site_of


def test_the_widest_ring_touches_the_covered_surface() -> None:
    """By the distance to the surface, found in another way; sampled normals may be 2 µm too generous."""
    site = site_of()
    radius = site.widest_ring_mm(6.0, 2.0, 3.0)
    angle = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    rings = [
        site.frame.point(radius * math.cos(turn), radius * math.sin(turn), height)
        for turn in angle
        for height in (-6.0, 2.0)
    ]
    assert float(depth_mm(site.body, np.array(rings)).min()) == pytest.approx(3.0, abs=0.02)


def test_a_snap_catches_and_is_free_when_it_is_closed() -> None:
    """Closed it has its clearance all around, twice the sag; lifted by half the bead it does not come off."""
    lower, upper = halves_of("snap").meshes
    up = np.array(layout_of("snap").site.frame.up)
    assert shared_mm3(lower, upper) == pytest.approx(0.0, abs=1e-6)
    assert shared_mm3(lower, upper, 0.05 * up) == pytest.approx(0.0, abs=1e-6)
    assert shared_mm3(lower, upper, 1.0 * up) > 10.0


def test_the_bead_is_as_high_as_the_strain_allows() -> None:
    layout, material = layout_of("snap"), load_elasticity("PLA")
    neck, bead = layout.seam.tongue
    assert isinstance(neck, Cylinder)
    assert isinstance(bead, Ellipsoid)
    mouth = layout.seam.groove[0]
    assert isinstance(mouth, Cylinder)
    strain = (bead.semi_axes_mm[0] - mouth.radius_mm) / neck.radius_mm
    assert strain == pytest.approx(material.strain_limit, rel=1e-6)
    # The spheroid leaves the neck at the edges of the bead.
    edge = 1.0 - (0.5 * 2.0 / bead.semi_axes_mm[2]) ** 2
    assert bead.semi_axes_mm[0] * math.sqrt(edge) == pytest.approx(neck.radius_mm)


def test_a_press_fit_overlaps_by_its_interference() -> None:
    """Both halves hold more than the uncut body: the interference; and less: the gap under the tongue."""
    layout, halves = layout_of("press"), halves_of("press")
    tongue, socket = layout.seam.tongue[0], layout.seam.groove[0]
    assert isinstance(tongue, Cylinder)
    assert isinstance(socket, Cylinder)
    fit = iso_fit("H7/p6", tongue.radius_mm + socket.radius_mm)
    assert 2e3 * (tongue.radius_mm - socket.radius_mm) == pytest.approx(fit.mean_um)
    bore = layout.bosses[0].inner_radius_mm
    overlap = math.pi * (tongue.radius_mm**2 - socket.radius_mm**2) * 5.0
    gap = math.pi * (socket.radius_mm**2 - bore**2) * 0.15
    lower, upper = (solid_mass(solid).volume_mm3 for solid in halves.solids)
    whole = solid_mass(hollow.brep(halves.hollow)).volume_mm3
    assert lower + upper - whole == pytest.approx(overlap - gap, abs=1e-3)


@given(bore=st.floats(1.0, 39.0), outside=st.floats(41.0, 90.0), interference=st.floats(1.0, 500.0))
def test_the_pressure_closes_the_interference(bore: float, outside: float, interference: float) -> None:
    """Displacements by Lamé's `u(r) = A r + B / r` with the stresses at all three radii given, ν = 0.3."""
    modulus, poisson, joint = 2500.0, 0.3, 40.0
    stress = press_stress(modulus, interference, bore, joint, outside)

    def displacement(inner: float, outer: float, p_inner: float, p_outer: float) -> float:
        a = (p_inner * inner**2 - p_outer * outer**2) / (outer**2 - inner**2)
        b = (p_inner - p_outer) * inner**2 * outer**2 / (outer**2 - inner**2)
        r = 0.5 * joint
        return ((1.0 - poisson) * a * r + (1.0 + poisson) * b / r) / modulus

    socket = displacement(0.5 * joint, 0.5 * outside, stress.pressure_mpa, 0.0)
    tongue = displacement(0.5 * bore, 0.5 * joint, 0.0, stress.pressure_mpa)
    assert 2e3 * (socket - tongue) == pytest.approx(interference, rel=1e-9)


def test_a_full_disc_in_a_wide_plate_has_half_the_modulus_times_the_strain() -> None:
    """The limit without a bore and without an outer edge: `p = E δ / (2 d)`."""
    stress = press_stress(2000.0, 100.0, 1e-6, 50.0, 1e9)
    assert stress.pressure_mpa == pytest.approx(2000.0 * 0.1 / (2.0 * 50.0))
    assert stress.socket_mpa == pytest.approx(2.0 * stress.pressure_mpa)


@pytest.mark.parametrize(
    ("fit", "diameter", "least", "most"),
    [
        ("H7/p6", 20.0, 1.0, 35.0),
        ("H7/p6", 50.0, 1.0, 42.0),
        ("H7/s6", 50.0, 18.0, 59.0),
        ("H7/r6", 30.0, 7.0, 41.0),
    ],
)
def test_fits_are_those_of_iso_286(fit: str, diameter: float, least: float, most: float) -> None:
    """Limits of interference as drawing tables give them, in µm."""
    interference = iso_fit(fit, diameter)
    assert (interference.least_um, interference.most_um) == (least, most)


def test_the_threads_mesh_and_lock() -> None:
    """In mesh they are free; lifted alone they collide; turned along with it they are free again."""
    female, male = (part.mesh for part in layout_of("thread-ring").parts)
    assert female is not None
    assert male is not None
    up = np.array(layout_of("thread-ring").site.frame.up)
    assert shared_mm3(female, male) == pytest.approx(0.0, abs=0.01)
    assert shared_mm3(female, male, 1.0 * up) > 10.0
    # The frame's up is x: half a turn about it changes the signs of y and z.
    turned = replace(male, vertices_mm=male.vertices_mm * np.array([1.0, -1.0, -1.0]))
    assert shared_mm3(female, turned) > 10.0
    assert shared_mm3(female, turned, 1.0 * up) == pytest.approx(0.0, abs=0.01)


def test_meshes_of_the_rings_keep_their_sag() -> None:
    for part in layout_of("thread-ring").parts:
        assert part.mesh is not None
        area = float(facet_normals(part.mesh)[1].sum())
        gap = abs(part.mesh.mass().volume_mm3 - part.volume_mm3)
        assert 0.0 < gap < 1e-3 * RING_SAG_UM * area
        assert part.print_up is not None


def test_recesses_of_screws_add_no_rest() -> None:
    for opening in layout_of("screws").openings:
        assert opening.state == "allowed"
        assert opening.com_clearance_mm is not None
        assert opening.com_clearance_mm > 0.01 * 30.0


def test_a_place_that_the_drill_map_forbids_is_named() -> None:
    """The slope of the surface is too small there for a recess that wide."""
    spec = ScrewsSpec(
        kind="screws", count=2, screw="M2-0.4", insert="M2-0.4-3", angle_deg=90.0, pitch_radius_mm=21.0
    )
    openings = lay_out_closure(spec, site_of()).openings
    assert {opening.state for opening in openings} == {"forced"}
    assert "also rests on that rim" in openings[0].sentence


_SMALL = {"screw": "M2-0.4", "insert": "M2-0.4-3"}


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        (DowelsSpec(length_mm=60.0), "use shorter pins"),
        (DowelsSpec(count=8, diameter_mm=12.0, boss_wall_mm=6.0), "bosses of two closure pins meet"),
        (ScrewsSpec(kind="screws", length_mm=5.0), "too short: 4 mm are clamped, so it engages 1 mm"),
        (
            ScrewsSpec(kind="screws", count=2, length_mm=30.0, pitch_radius_mm=18.0, **_SMALL),
            "no standard length 30 mm",
        ),
        (
            ScrewsSpec(kind="screws", count=2, length_mm=20.0, pitch_radius_mm=20.0, **_SMALL),
            "longer than its boss: its hole of 17 mm ends 1.83 mm under the surface and must stay 3 mm",
        ),
        (ScrewsSpec(kind="screws", count=12, boss_wall_mm=6.0), "do not fit beside each other"),
        (ScrewsSpec(kind="screws", insert="M2-0.4-3"), "different threads"),
        (ScrewsSpec(kind="screws", standard="iso1"), "choose one of.*iso4762"),
        (ThreadRingSpec(kind="thread-ring", diameter_mm=58.0), "does not fit: the room at the seam takes 4"),
        (ThreadRingSpec(kind="thread-ring", length_mm=2.0), "fewer than 3 turns"),
        (ThreadRingSpec(kind="thread-ring", diameter_mm=8.0, ring_wall_mm=4.0), "leaves a bore of 0 mm"),
        (
            SnapSpec(kind="snap", undercut_mm=1.5),
            "strains the PLA by.*1.4 % is permissible; take at most 0.4",
        ),
        (SnapSpec(kind="snap", undercut_mm=0.05), "would not hold"),
        (SnapSpec(kind="snap", diameter_mm=57.0), "leaves less than a wall of 3 mm outside of it"),
        (SnapSpec(kind="snap", bead_mm=6.0), "must be less than closure.height_mm"),
        (PressSpec(kind="press", interference_um=2000.0), "stresses the PLA to.*22.5 MPa is permissible"),
        (PressSpec(kind="press", fit="H8/u8"), "take one of H7/p6, H7/r6, H7/s6"),
        (PressSpec(kind="press", height_mm=60.0), "does not stay 3 mm under the surface"),
        (PressSpec(kind="press", diameter_mm=8.0, tongue_wall_mm=5.0), "leaves a bore of 0 mm"),
    ],
)
def test_what_does_not_fit_is_said_with_a_remedy(spec: ClosureSpec, said: str) -> None:
    with pytest.raises((GeometryError, SpecError), match=said) as caught:
        lay_out_closure(spec, site_of())
    assert "\n" not in str(caught.value)


def test_a_closure_stays_clear_of_the_payload() -> None:
    site = site_of()
    pin = lay_out_closure(DowelsSpec(), site).columns[0]
    with pytest.raises(GeometryError, match=r"closure pin meets another part.*turn closure\.angle_deg"):
        lay_out_closure(DowelsSpec(), replace(site, keep_out=(pin,)))


def test_a_material_without_elastic_properties_is_said() -> None:
    with pytest.raises(SpecError, match=r"no elastic properties of the material 'brass'.*dowels"):
        load_elasticity("brass")
