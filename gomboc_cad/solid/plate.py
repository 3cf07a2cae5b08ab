"""A plate to print: made parts turned upright and packed on a printer's bed.

The parts are packed by their bounding rectangles, which may be turned by 90°, each as near to the front as
the skyline of those before it allows; the longest come first (bottom-left rule of Baker, Coffman, Rivest,
SIAM J. Comput. 9 (1980) 846, with the skyline of Burke, Kendall, Whitwell, Oper. Res. 52 (2004) 655).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import NamedTuple, Protocol

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.mesh import Mesh

_ROUNDING_MM = 1e-9
_QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""A turn by 90° about z."""


class Printable(Protocol):
    """A part that may be printed."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def mesh(self) -> Mesh | None:
        """Its mesh; None for a part that is bought."""

    @property
    def print_up(self) -> Vector | None:
        """Direction that points up on the bed; None for a part that is not to be printed."""


class Bed(Protocol):
    """A printer's bed and what is to stand on it."""

    @property
    def bed_mm(self) -> tuple[float, float]:
        """Its width and depth."""

    @property
    def spacing_mm(self) -> float:
        """Free space between parts and around them."""

    @property
    def copies(self) -> int:
        """How many of each part."""


@dataclass(frozen=True, eq=False)
class PlateItem:
    """A copy of a part on the bed: its vertices are turned, and then moved.

    Attributes:
        name: Its own name: the part's, with a number if there are several copies.
        part: Name of the part.
        turn: Rotation, shape (3, 3).
        shift_mm: Displacement after it, shape (3,).
    """

    name: str
    part: str
    turn: Array
    shift_mm: Array

    def placed(self, mesh: Mesh) -> Mesh:
        """The part's mesh where the copy stands."""
        return Mesh(mesh.vertices_mm @ self.turn.T + self.shift_mm, mesh.faces)


class _Rectangle(NamedTuple):
    """Room that a part takes on the bed, with the space to its right and behind it."""

    part: int
    width_mm: float
    depth_mm: float


class _Placed(NamedTuple):
    """A rectangle on the bed: its front left corner, and whether it was turned by 90°."""

    part: int
    x_mm: float
    y_mm: float
    turned: bool


def pack(parts: Sequence[Printable], plate: Bed) -> tuple[PlateItem, ...]:
    """Put parts on a bed that begins at the origin, standing on z = 0.

    Args:
        parts: The parts; those without mesh or printing direction are left out.
        plate: Size of the bed, space between the parts and around them, and number of copies.

    Returns:
        The copies part by part; `name-1`, `name-2` … if there are several.

    Raises:
        GeometryError: If the parts do not fit on the bed.
    """
    upright = [
        _Upright.of(part.name, part.mesh, np.array(part.print_up))
        for part in parts
        if part.mesh is not None and part.print_up is not None
    ]
    sizes = np.array([item.size_mm[:2] for item in upright]).reshape(-1, 2)
    _check_size([item.name for item in upright], sizes, plate)
    placed, depth_mm = _packed(sizes, plate, plate.copies)
    if depth_mm > plate.bed_mm[1] + _ROUNDING_MM:
        raise GeometryError(_too_much(sizes, plate, depth_mm))
    numbers = cycle(range(1, plate.copies + 1))
    return tuple(
        upright[place.part].laid_down(place, next(numbers) if plate.copies > 1 else None)
        for place in sorted(placed)
    )


@dataclass(frozen=True, eq=False)
class _Upright:
    """A part turned upright: the turn, and the lowest corner and the size of its box after it."""

    name: str
    turn: Array
    low_mm: Array
    size_mm: Array

    @classmethod
    def of(cls, name: str, mesh: Mesh, up: Array) -> _Upright:
        turn = _turn_upright(up / np.linalg.norm(up))
        vertices = mesh.vertices_mm @ turn.T
        return cls(name, turn, vertices.min(axis=0), np.ptp(vertices, axis=0))

    def laid_down(self, place: _Placed, number: int | None) -> PlateItem:
        """Turn by 90° if need be, and move to a place on the bed."""
        x, y, z = self.low_mm
        turn, low = self.turn, np.array([x, y, z])
        if place.turned:
            turn, low = _QUARTER @ self.turn, np.array([-y - self.size_mm[1], x, z])
        name = self.name if number is None else f"{self.name}-{number}"
        return PlateItem(name, self.name, turn, np.array([place.x_mm, place.y_mm, 0.0]) - low)


def _turn_upright(up: Array) -> Array:
    """Rotation that takes a unit vector to z by the shortest way, shape (3, 3)."""
    axis, cosine = np.array([up[1], -up[0], 0.0]), up[2]
    if cosine < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    skew = np.array([[0.0, 0.0, axis[1]], [0.0, 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    turn: Array = np.eye(3) + skew + skew @ skew / (1.0 + cosine)
    return turn


def _check_size(names: list[str], sizes: Array, plate: Bed) -> None:
    """Refuse a part that does not fit on the bed even alone."""
    around = 2.0 * plate.spacing_mm
    for name, size in zip(names, sizes, strict=True):
        if np.any(np.sort(size) + around > np.sort(plate.bed_mm) + _ROUNDING_MM):
            raise GeometryError(
                f"The part {name} is {size[0]:.4g} × {size[1]:.4g} mm as it stands on the bed, and with "
                f"{plate.spacing_mm:g} mm around it does not fit on one of {_bed(*plate.bed_mm)}; it needs a "
                f"plate.bed_mm of at least {_bed(*(size + around))}."
            )


def _too_much(sizes: Array, plate: Bed, depth_mm: float) -> str:
    """Say how many copies would fit and what bed all of them need."""
    fit = bisect_right(
        range(1, plate.copies),
        plate.bed_mm[1] + _ROUNDING_MM,
        key=lambda copies: _packed(sizes, plate, copies)[1],
    )
    what = "copies of all parts" if plate.copies > 1 else "the parts"
    count = f"{plate.copies} {what}" if plate.copies > 1 else what
    remedy = f"{fit} would fit, or " if fit else ""
    return (
        f"The bed of {_bed(*plate.bed_mm)} is too small for {count} with {plate.spacing_mm:g} mm between "
        f"them: {remedy}plate.bed_mm would have to be {_bed(plate.bed_mm[0], depth_mm)}."
    )


def _bed(width_mm: float, depth_mm: float) -> str:
    """A size in words, rounded up so that it is enough."""
    return f"{math.ceil(width_mm - _ROUNDING_MM)} × {math.ceil(depth_mm - _ROUNDING_MM)} mm"


def _packed(sizes: Array, plate: Bed, copies: int) -> tuple[list[_Placed], float]:
    """Pack copies of parts of given sizes (n, 2) on a bed of given width; tell the depth that it takes."""
    space = plate.spacing_mm
    rectangles = [
        _Rectangle(part, width + space, depth + space)
        for part, (width, depth) in enumerate(sizes.tolist())
        for _ in range(copies)
    ]
    rectangles.sort(key=lambda item: (-max(item.width_mm, item.depth_mm), item.part))
    skyline = _Skyline(plate.bed_mm[0] - space)
    placed = [skyline.place(item) for item in rectangles]
    shifted = [_Placed(part, x + space, y + space, turned) for part, x, y, turned in placed]
    return shifted, max(skyline.heights, default=0.0) + space


class _Skyline:
    """The back edge of what stands on a bed already, as steps from left to right."""

    def __init__(self, width_mm: float):
        """An empty bed of a given width."""
        self.starts = [0.0]
        self.heights = [0.0]
        self.width_mm = width_mm

    def place(self, item: _Rectangle) -> _Placed:
        """Put a rectangle where its back is nearest to the front, and raise the skyline to it."""
        ways = [(item.width_mm, item.depth_mm, False), (item.depth_mm, item.width_mm, True)]
        back, x, turned, width = min(
            (front + depth, x, turned, width)
            for width, depth, turned in ways
            if width <= self.width_mm + _ROUNDING_MM
            for front, x in [self._lowest(width)]
        )
        depth = item.width_mm if turned else item.depth_mm
        self._raise(x, x + width, back)
        return _Placed(item.part, x, back - depth, turned)

    def _lowest(self, width: float) -> tuple[float, float]:
        """The place nearest to the front, and then to the left, for a given width: (y, x)."""
        return min(
            (max(h for s, e, h in self._steps() if s < x + width - _ROUNDING_MM and e > x + _ROUNDING_MM), x)
            for x in self.starts
            if x + width <= self.width_mm + _ROUNDING_MM
        )

    def _steps(self) -> list[tuple[float, float, float]]:
        return list(zip(self.starts, [*self.starts[1:], self.width_mm], self.heights, strict=True))

    def _raise(self, left: float, right: float, height: float) -> None:
        """Set the skyline to a height between two places."""
        kept = [(s, h) for s, e, h in self._steps() if s < left - _ROUNDING_MM]
        after = [(max(s, right), h) for s, e, h in self._steps() if e > right + _ROUNDING_MM]
        steps = [*kept, (left, height), *after]
        self.starts, self.heights = [s for s, _ in steps], [h for _, h in steps]
