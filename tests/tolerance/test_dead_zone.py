"""Dead zones of rolling resistance against the closed form of a sphere and the slopes of the primary."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gomboc_cad.body import Body, catalog, mass_properties, support_jet
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import com_margin, find_equilibria
from gomboc_cad.equilibria.records import Equilibrium
from gomboc_cad.equilibria.round_solids import EllipsoidShape
from gomboc_cad.tolerance.dead_zone import dead_zones, half_width_deg

PRIMARY = catalog()["primary"]
CENTROID = mass_properties(PRIMARY).com_mm


@given(st.floats(1e-3, 10.0), st.floats(1e-6, 0.1))
def test_of_a_sphere_it_is_the_arcsine(lowered_mm: float, part: float) -> None:
    """The slope of the height at the tilt t is s·sin t."""
    truth = np.degrees(np.arcsin(part))
    found = half_width_deg(part * lowered_mm, np.array(lowered_mm))
    assert found == pytest.approx(truth, rel=0.2 * part**2 + 1e-12)


def test_extremes() -> None:
    stiffness = np.array([[0.0, 1e-300], [-2.0, np.nan], [np.inf, 1.0]])
    found = half_width_deg(0.1, stiffness)
    assert found[0].tolist() == [180.0, 180.0]
    assert found[1, 0] == pytest.approx(np.degrees(0.05))
    assert np.isnan(found[1, 1])
    assert found[2, 0] == 0.0
    assert half_width_deg(0.0, np.array([0.0, 1.0]))[1] == 0.0


def test_the_slope_reaches_b_at_the_edge_of_each_zone() -> None:
    """On the primary, in both principal directions of rest and unstable pose."""
    rolling = 1e-4
    equilibria = find_equilibria(PRIMARY, CENTROID)
    zones = dead_zones(equilibria, rolling)
    assert [zone.kind for zone in zones] == ["stable", "unstable"]
    for zone in zones:
        jet = support_jet(PRIMARY, np.array([zone.direction]), np.array(CENTROID))
        stiffness, axes = np.linalg.eigh(jet.hessian_mm[0])
        softest = np.argsort(np.abs(stiffness))
        for width, index in zip(zone.half_width_deg, softest, strict=True):
            along = axes[:, index] @ jet.tangents[0]
            turn = np.radians(width)
            edge = np.cos(turn) * np.array(zone.direction) + np.sin(turn) * along
            slope = support_jet(PRIMARY, edge[None], np.array(CENTROID)).gradient_mm[0]
            assert np.linalg.norm(slope) == pytest.approx(rolling, rel=0.02)


def test_below_the_margin_a_body_is_held_only_around_its_equilibria() -> None:
    """Nowhere farther from them than arcsin(b/m), of a loaded ellipsoid; a sphere reaches just that."""
    body, com = Body("ellipsoid", EllipsoidShape((1.06, 1.0, 0.97)), 50.0), np.array([0.0, 0.0, -12.0])
    margin = com_margin(body, com)
    rest, top = (np.array(e.direction) for e in find_equilibria(body, com))
    directions, _ = geodesic_triangulation(5)
    jet = support_jet(body, directions, com)
    slope = np.linalg.norm(jet.gradient_mm, axis=1)
    trough = np.linalg.eigvalsh(jet.hessian_mm)[:, 0] > 0.0
    for part, center, m in ((trough, rest, margin.s_margin_mm), (~trough, top, margin.u_margin_mm)):
        for rolling in (0.5 * m, 0.95 * m):
            held = directions[part & (slope <= rolling)]
            farthest = np.arccos((held @ center).min())
            assert 0.4 * np.arcsin(rolling / m) < farthest < np.arcsin(rolling / m)


def test_a_polyhedron_has_no_stiffness() -> None:
    with pytest.raises(ValueError, match="has no stiffness"):
        dead_zones([Equilibrium("stable", (0.0, 0.0, -1.0), 1.0)], 0.1)
