"""The loading zone near the COM: the wall that the COM must not cross, and the rests on either side of it.

The number of rests changes only when the COM crosses the sheet of κ₁ of the focal surface, `x − n/κ₁`. A
plane cuts that sheet in curves, which divide the plane into fields with one number of rests each; so one
census in each field tells them all. Nothing of the zone is sampled but these curves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.ndimage import distance_transform_edt, label

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, geodesic_triangulation, unit
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.margin import focal_points_mm
from gomboc_cad.equilibria.records import Census, Vector, as_vector
from gomboc_cad.equilibria.smooth import find_equilibria
from gomboc_cad.errors import CensusError
from gomboc_cad.report.packing import packed, packed_integers, unpacked, unpacked_integers
from gomboc_cad.report.sections import section_loops

_MESH_LEVEL, _CURVE_LEVEL = 5, 7
_CELLS = 240
_CLOSE_UP = 4.0
"""Half the width of the close-up, in S-margins or in deviations of the COM, whichever are larger."""

_SMALLEST_FIELD = 4
_MOST_FIELDS = 24


@dataclass(frozen=True, eq=False)
class ZoneMesh:
    """The sheet of κ₁ of the focal surface, in the body's frame.

    Attributes:
        vertices_mm: Centres of the larger curvature, shape (n, 3).
        faces: Triangles, shape (m, 3); the sheet has cusps and crosses itself.
    """

    vertices_mm: Array
    faces: IntArray

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        return {"vertices_mm": packed(self.vertices_mm), "faces": packed_integers(self.faces)}

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored.

        Raises:
            InspectionError: If an array is damaged.
        """
        return cls(unpacked(document["vertices_mm"]), unpacked_integers(document["faces"]))


def zone_mesh(body: Body, level: int = _MESH_LEVEL) -> ZoneMesh:
    """Evaluate the sheet of a strictly convex body over a subdivided icosahedron."""
    directions, faces = geodesic_triangulation(level)
    return ZoneMesh(focal_points_mm(body, directions, 0), faces)


@dataclass(frozen=True, eq=False)
class Fields:
    """How many rests the body has, by the place of the COM in a square of a plane.

    Attributes:
        reach_mm: Half the side of the square, whose middle is the given COM.
        rests: Number of rests in each cell, from below and from the left, shape (n, n); 0 outside the body.
            Cells that a curve passes through, and fields of few cells, have that of the nearest other field.
    """

    reach_mm: float
    rests: IntArray

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        return {"reach_mm": self.reach_mm, "rests": packed_integers(self.rests, "uint8")}

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored.

        Raises:
            InspectionError: If the array is damaged.
        """
        return cls(float(document["reach_mm"]), unpacked_integers(document["rests"]))


@dataclass(frozen=True, eq=False)
class ZoneSection:
    """The plane through the COM in which down at rest and the nearest place with other rests lie.

    Places in it are given from the COM, in mm: to the right and upwards.

    Attributes:
        com_mm: The COM in the body's frame.
        axes: To the right and upwards, as unit vectors of the body's frame.
        s_margin_mm: Distance to the nearest place with another number of rests, of the body without openings.
        witness_mm: That place.
        curves_mm: Closed curves across which the number of rests changes, shape (k, 2) each.
        outline_mm: Section of the body's surface, shape (k, 2).
        whole: The fields in the whole body.
        close_up: Those near the COM.
        com_covariance_mm2: Covariance of the COM in this plane, shape (2, 2); None if nothing is known of it.
        product_margin_mm: The S-margin of the finished product, in whose openings there may be a rest sooner;
            None if nothing is known of them.
    """

    com_mm: Vector
    axes: tuple[Vector, Vector]
    s_margin_mm: float
    witness_mm: tuple[float, float]
    curves_mm: tuple[Array, ...]
    outline_mm: Array
    whole: Fields
    close_up: Fields
    com_covariance_mm2: Array | None
    product_margin_mm: float | None = None

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        covariance = self.com_covariance_mm2
        return {
            "com_mm": list(self.com_mm),
            "axes": [list(axis) for axis in self.axes],
            "s_margin_mm": self.s_margin_mm,
            "witness_mm": list(self.witness_mm),
            "curves_mm": [packed(curve) for curve in self.curves_mm],
            "outline_mm": packed(self.outline_mm),
            "whole": self.whole.document(),
            "close_up": self.close_up.document(),
            "com_covariance_mm2": None if covariance is None else covariance.tolist(),
            "product_margin_mm": self.product_margin_mm,
        }

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored.

        Raises:
            InspectionError: If an array is damaged.
        """
        right, up = (as_vector(np.array(axis)) for axis in document["axes"])
        x, y = document["witness_mm"]
        covariance, product = document["com_covariance_mm2"], document["product_margin_mm"]
        return cls(
            com_mm=as_vector(np.array(document["com_mm"])),
            axes=(right, up),
            s_margin_mm=float(document["s_margin_mm"]),
            witness_mm=(float(x), float(y)),
            curves_mm=tuple(unpacked(curve) for curve in document["curves_mm"]),
            outline_mm=unpacked(document["outline_mm"]),
            whole=Fields.of_document(document["whole"]),
            close_up=Fields.of_document(document["close_up"]),
            com_covariance_mm2=None if covariance is None else np.array(covariance, dtype=float),
            product_margin_mm=None if product is None else float(product),
        )


def zone_section(
    body: Body,
    census: Census,
    com_covariance_mm2: Sequence[Sequence[float]] | Array | None = None,
    product_margin_mm: float | None = None,
) -> ZoneSection:
    """Cut the loading zone where the COM is nearest to its wall.

    Args:
        body: A strictly convex body.
        census: Its census about the given COM.
        com_covariance_mm2: How uncertain that COM is, in the body's frame, shape (3, 3).
        product_margin_mm: The S-margin of the finished product.

    Raises:
        CensusError: If the census has no margin, as that of a mesh.
    """
    if census.margin is None:
        raise CensusError(
            "This census has no margin to draw; take the smooth one of the body, with its margins."
        )
    center = np.array(census.com_mm)
    frame = _plane(census)
    directions, triangles = geodesic_triangulation(_CURVE_LEVEL)
    curves, outline = (
        section_loops((points - center) @ frame.T, triangles, np.zeros(3), (0, 1))
        for points in (focal_points_mm(body, directions, 0), body.position_mm(directions))
    )
    covariance, spread = None, 0.0
    if com_covariance_mm2 is not None:
        covariance = frame[:2] @ np.array(com_covariance_mm2) @ frame[:2].T
        spread = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    near = _CLOSE_UP * max(census.margin.s_margin_mm, spread)
    across = 1.02 * float(np.abs(outline[0]).max())
    x, y = frame[:2] @ (np.array(census.margin.s_witness_mm) - center)
    drawing = _Drawing(body, center, frame, curves, outline[0])
    return ZoneSection(
        com_mm=census.com_mm,
        axes=(as_vector(frame[0]), as_vector(frame[1])),
        s_margin_mm=census.margin.s_margin_mm,
        witness_mm=(float(x), float(y)),
        curves_mm=tuple(curves),
        outline_mm=outline[0],
        whole=drawing.fields(across),
        close_up=drawing.fields(min(near, across)),
        com_covariance_mm2=covariance,
        product_margin_mm=product_margin_mm,
    )


def _plane(census: Census) -> Array:
    """Right, up and across the plane of the section, as the rows of a rotation, shape (3, 3)."""
    assert census.margin is not None
    up = -np.array(census.rest.direction)
    arm = np.array(census.margin.s_witness_mm) - census.com_mm
    level = arm - (arm @ up) * up
    aside = np.linalg.norm(level) > 1e-6 * np.linalg.norm(arm)
    right = unit(level) if aside else np.array(census.rest.soft_direction)
    return np.array([right, up, np.cross(right, up)])


@dataclass(frozen=True, eq=False)
class _Drawing:
    """The curves in their plane, and the body to ask about the fields between them."""

    body: Body
    center_mm: Array
    frame: Array
    curves_mm: list[Array]
    outline_mm: Array

    def fields(self, reach_mm: float) -> Fields:
        """Divide a square about the COM into its fields and count the rests in each."""
        inside = self._inside(reach_mm)
        free = inside & ~self._drawn(reach_mm)
        numbers, count = label(free)
        sizes = np.bincount(numbers.ravel(), minlength=count + 1)[1:]
        depth = distance_transform_edt(free)
        rests = np.zeros(numbers.shape, dtype=np.int64)
        for field in 1 + np.argsort(-sizes, kind="stable")[:_MOST_FIELDS]:
            if sizes[field - 1] >= _SMALLEST_FIELD:
                cells = numbers == field
                deepest = np.unravel_index(np.argmax(np.where(cells, depth, 0.0)), cells.shape)
                rests[cells] = self._rests_at(_places(reach_mm)[list(deepest[::-1])])
        nearest = distance_transform_edt(rests == 0, return_distances=False, return_indices=True)
        return Fields(reach_mm, np.where(inside, rests[tuple(nearest)], 0))

    def _inside(self, reach_mm: float) -> BoolArray:
        """Which cells are in the body, whose outline each ray from the COM crosses once."""
        x, y = np.meshgrid(_places(reach_mm), _places(reach_mm))
        turn = np.arctan2(self.outline_mm[:, 1], self.outline_mm[:, 0])
        order = np.argsort(turn, kind="stable")
        radius = np.linalg.norm(self.outline_mm, axis=1)[order]
        far = np.interp(np.arctan2(y, x).ravel(), turn[order], radius, period=2.0 * np.pi)
        result: BoolArray = np.hypot(x, y) < far.reshape(x.shape)
        return result

    def _drawn(self, reach_mm: float) -> BoolArray:
        """Which cells the curves pass through; no step from cell to neighbouring cell crosses a curve."""
        cell = 2.0 * reach_mm / _CELLS
        drawn = np.zeros((_CELLS, _CELLS), dtype=bool)
        for curve in self.curves_mm:
            start, arm = curve, np.roll(curve, -1, axis=0) - curve
            near = np.abs(start).max(axis=1) - np.abs(arm).max(axis=1) < reach_mm
            start, arm = start[near], arm[near]
            steps = 1 + np.ceil(2.0 * np.abs(arm).max(axis=1, initial=0.0) / cell).astype(int)
            row = np.repeat(np.arange(len(start)), steps)
            part = (np.arange(len(row)) - np.repeat(np.cumsum(steps) - steps, steps)) / steps[row]
            place = np.floor((start[row] + part[:, None] * arm[row] + reach_mm) / cell).astype(int)
            place = place[((place >= 0) & (place < _CELLS)).all(axis=1)]
            drawn[place[:, 1], place[:, 0]] = True
        return drawn

    def _rests_at(self, place_mm: Array) -> int:
        """Number of rests with the COM at a place of the plane; 0 where it cannot be told."""
        try:
            equilibria = find_equilibria(self.body, self.center_mm + place_mm @ self.frame[:2])
        except CensusError:
            return 0
        return sum(e.kind == "stable" for e in equilibria)


def _places(reach_mm: float) -> Array:
    """Middles of the cells along a side."""
    return reach_mm * (2.0 * (np.arange(_CELLS) + 0.5) / _CELLS - 1.0)
