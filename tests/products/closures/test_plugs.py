"""Plugs close head recesses flush: their outer face is the body's own surface."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gomboc_cad.body import depth_mm
from gomboc_cad.products.closures import ScrewsSpec
from gomboc_cad.products.closures.layout import lay_out_closure
from gomboc_cad.products.closures.plugs import plug_parts
from gomboc_cad.products.materials import load_material
from tests.products.closures.sites import SAG_UM, SHIFT_MM, overlap_mm3, site_of, split

SPEC = ScrewsSpec(kind="screws", count=3, screw="M2-0.4", insert="M2-0.4-3", plugged=True)


def test_plugs_fill_the_recesses_up_to_the_surface() -> None:
    site = site_of()
    layout = lay_out_closure(SPEC, site)
    moved = layout.moved(np.array(SHIFT_MM))
    assert {opening.state for opening in moved.openings} == {"plugged"}
    plugs = plug_parts(moved, load_material("PLA"), (0.7, 0.8, 0.9), SAG_UM, "imu-housing-plug")
    assert [plug.name for plug in plugs] == [f"imu-housing-plug-{number}" for number in (1, 2, 3)]

    upper = split(layout).solids[1]
    screws = [part.solid for part in moved.parts if part.name.startswith("closure-screw")]
    for plug, tool, driven, opening in zip(plugs, moved.plugs, screws, moved.openings, strict=True):
        assert plug.mesh is not None
        depth = depth_mm(site.body, plug.mesh.vertices_mm[:: max(1, len(plug.mesh.vertices_mm) // 150)])
        assert depth.min() == pytest.approx(0.0, abs=1e-3)
        assert overlap_mm3(plug.solid, upper) == pytest.approx(0.0, abs=1e-6)
        assert overlap_mm3(plug.solid, driven) == pytest.approx(0.0, abs=1e-6)
        # A cylinder cut off by the surface is as long as its axis, but for the curvature.
        length = float(np.dot(np.subtract(opening.position_mm, tool.base_mm), tool.direction))
        assert plug.volume_mm3 == pytest.approx(math.pi * tool.radius_mm**2 * length, rel=0.03)
