"""A small body to be closed, and its two halves by both kernels."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from build123d import Solid
from manifold3d import Manifold, Mesh64

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array
from gomboc_cad.products.body_spec import BodySpec
from gomboc_cad.products.closures import (
    ClosureSpec,
    DowelsSpec,
    PressSpec,
    ScrewsSpec,
    SnapSpec,
    ThreadRingSpec,
)
from gomboc_cad.products.closures.layout import ClosureLayout, ClosureSite, lay_out_closure
from gomboc_cad.products.common_spec import ShellSpec
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid import hollow
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import HollowBody
from gomboc_cad.solid.mesh import Mesh

WALL_MM = 3.0
SAG_UM = 50.0
RING_SAG_UM = 10.0
SHIFT_MM = (0.2, -0.1, 0.15)

SPECS: dict[str, ClosureSpec] = {
    "dowels": DowelsSpec(length_mm=10.0),
    "screws": ScrewsSpec(kind="screws", count=2, screw="M2-0.4", insert="M2-0.4-3"),
    "tapped": ScrewsSpec(kind="screws", count=2, screw="M2-0.4", thread="tapped", head_in="lower"),
    "thread-ring": ThreadRingSpec(kind="thread-ring", diameter_mm=16.0),
    "snap": SnapSpec(kind="snap"),
    "press": PressSpec(kind="press"),
}


class Halves(NamedTuple):
    """Both halves, by both kernels, with their boundaries."""

    hollow: HollowBody
    solids: tuple[Solid, Solid]
    meshes: tuple[Mesh, Mesh]
    boundaries: tuple[Boundary, Boundary]


@lru_cache(maxsize=8)
def primary(diameter_mm: float) -> Body:
    return BodySpec(name="primary", diameter_mm=diameter_mm).body()


def site_of(diameter_mm: float = 60.0, bore_radius_mm: float | None = None) -> ClosureSite:
    """The middle of a primary about the best centre of mass."""
    return ClosureSite(
        body=primary(diameter_mm),
        frame=RestFrame.from_rest((-1.0, 0.0, 0.0)),
        shell=ShellSpec(wall_mm=WALL_MM),
        seam_height_mm=0.0,
        com_mm=(-0.0041 * diameter_mm, 0.0, 0.0),
        bore_radius_mm=bore_radius_mm,
        sag_um=RING_SAG_UM,
    )


@lru_cache(maxsize=16)
def layout_of(kind: str) -> ClosureLayout:
    """A closure in a 60 mm primary."""
    return lay_out_closure(SPECS[kind], site_of())


@lru_cache(maxsize=16)
def halves_of(kind: str) -> Halves:
    """The halves of a 60 mm primary, its core moved."""
    return split(layout_of(kind))


def split(layout: ClosureLayout) -> Halves:
    """The halves that a closure leaves of a body whose core moved."""
    wall_mm = WALL_MM if layout.site.bore_radius_mm is None else None
    body = HollowBody(layout.site.body, wall_mm, SHIFT_MM, bosses=layout.bosses, holes=layout.holes)
    seam = layout.moved(np.array(SHIFT_MM)).seam
    return Halves(
        body,
        hollow.split_brep(hollow.brep(body), seam),
        hollow.split_mesh(hollow.mesh(body, SAG_UM), seam, SAG_UM),
        Boundary.of_hollow(body).split(seam),
    )


def overlap_mm3(one: Solid, other: Solid) -> float:
    """Volume that two solids share."""
    common = one.intersect(other)
    return 0.0 if common is None else sum(solid.volume for solid in common.solids())


def shared_mm3(one: Mesh, other: Mesh, rise_mm: Array | None = None) -> float:
    """Volume that two meshes share, the second one displaced: the quick way, but for the sag."""
    first, second = (
        Manifold(Mesh64(mesh.vertices_mm, np.ascontiguousarray(mesh.faces, dtype=np.uint64)))
        for mesh in (one, other)
    )
    if rise_mm is not None:
        second = second.translate(rise_mm.tolist())
    return float((first ^ second).volume())
