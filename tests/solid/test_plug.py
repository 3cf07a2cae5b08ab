"""Flush plugs: their outer face is the body's own surface, in both kernels and wherever they are put."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from build123d import Location

from gomboc_cad import Body
from gomboc_cad.body import mass_properties
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import Cylinder, HollowBody, brep, plug_brep, plug_mesh
from gomboc_cad.solid.mass import solid_mass
from tests.solid.inspection import problems_on_disk

SAG_UM = 20.0
BLIND = Cylinder((0.0, 0.0, 38.0), (0.1, 0.0, 1.0), 4.0, 30.0)
FROM_OUTSIDE = Cylinder((0.0, 60.0, 10.0), (0.0, -1.0, -0.4), 1.2, 20.0)
WIDE = Cylinder((-10.0, 0.0, 0.0), (-1.0, 0.0, 0.0), 20.0, 60.0)


@pytest.mark.parametrize("cylinder", [BLIND, FROM_OUTSIDE, WIDE], ids=["blind", "from outside", "wide"])
def test_files_of_a_plug_pass_their_inspection(primary: Body, cylinder: Cylinder, tmp_path: Path) -> None:
    boundary = Boundary.of_plug(primary, cylinder)
    solid, facets = plug_brep(primary, cylinder), plug_mesh(primary, cylinder, SAG_UM)
    assert problems_on_disk(tmp_path, solid, facets, boundary, SAG_UM) == ()
    shift = (1.0, -20.0, 3.0)
    moved, there = solid.moved(Location(shift)), replace(facets, vertices_mm=facets.vertices_mm + shift)
    assert problems_on_disk(tmp_path, moved, there, boundary.moved(shift), SAG_UM) == ()
    assert problems_on_disk(tmp_path, moved, there, boundary, SAG_UM) != ()


@pytest.mark.parametrize("cylinder", [BLIND, FROM_OUTSIDE])
def test_a_plug_in_its_opening_makes_the_body_whole(primary: Body, cylinder: Cylinder) -> None:
    drilled = brep(HollowBody(primary, None, openings=(cylinder,)))
    parts = [solid_mass(drilled), solid_mass(plug_brep(primary, cylinder))]
    whole = mass_properties(primary)
    assert sum(part.volume_mm3 for part in parts) == pytest.approx(whole.volume_mm3, rel=2e-8)
    moment = sum(part.volume_mm3 * np.array(part.com_mm) for part in parts)
    assert moment / whole.volume_mm3 == pytest.approx(whole.com_mm, abs=2e-6)


def test_no_facet_of_a_plug_stands_out_of_the_body(primary: Body) -> None:
    """A plug that stood out would be a new rest."""
    heights = Boundary.of_body(primary).outer.signed_distance_mm(plug_mesh(primary, BLIND, 5.0).vertices_mm)
    assert heights.max() < 1e-9


@pytest.mark.parametrize(
    ("cylinder", "sentence"),
    [
        (Cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 4.0, 20.0), "one end wholly inside"),
        (Cylinder((0.0, 0.0, -80.0), (0.0, 0.0, 1.0), 4.0, 160.0), "one end wholly inside"),
        (Cylinder((0.0, 0.0, 49.0), (0.0, 0.0, 1.0), 20.0, 20.0), "one end wholly inside"),
        (replace(BLIND, inner_radius_mm=1.0), "not with a tube"),
    ],
)
def test_cylinders_that_cut_no_plug_are_refused(primary: Body, cylinder: Cylinder, sentence: str) -> None:
    for make in (lambda: plug_brep(primary, cylinder), lambda: plug_mesh(primary, cylinder, SAG_UM)):
        with pytest.raises(GeometryError, match=sentence):
            make()
