"""A mark of small drilled dots, an arrow and a part id, laid on the outer surface where it adds no rest.

A dot-peening tool, a drill and a printer make the same dots. Each is judged like any other hole; the land
between two of them keeps the true surface, so that none acts together with its neighbour.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, fibonacci_directions, unit
from gomboc_cad.body.support import support_about, touching_directions
from gomboc_cad.equilibria.drill_map import drill_limits
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.equilibria.rim import hole_rims_mm, rim_clearance_mm
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.common_spec import MarkSpec
from gomboc_cad.products.openings.cylinder_gaps import gaps_mm
from gomboc_cad.products.openings.mark_layout import MarkLayout, least_spacing_mm, mark_layouts, walked
from gomboc_cad.products.openings.placed_opening import OVERRUN_SHARE, PlacedOpening, State, frame_place
from gomboc_cad.products.openings.sites import SIDE_NAMES, Side, cap_directions
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder

_LARGEST_REACH = 0.65
"""Of a dot from the middle of the mark, in units of R₀; farther out letters would be distorted."""

_STRETCH = 1.08
"""Pitch of the dots over the least one, because ways that part on a curved surface come nearer again."""

_SITES, _TRIED = 800, 16
_NEARBY, _NEARBY_ANGLE = 60, 0.1
_LEAST_SLANT = 0.3
"""Sine of the angle between the normal and what the arrow points along, below which it points nowhere."""


@dataclass(frozen=True)
class Mark:
    """A mark in its place.

    Attributes:
        text: The part id.
        dots: The holes, their bases inside the body.
        openings: The same, each judged; all have the sentence of the mark.
        state: `allowed`, or `forced` if any dot is a rest.
        direction: Outward normal at its middle.
        position_mm: Its middle on the surface.
        reading: Unit vector along which the text is read, at the middle.
        arrow: Unit vector along which the arrow points, at the middle.
        size_mm: Width and height along the surface.
        com_clearance_mm: How far the COM may move before any dot becomes a rest.
        sentence: What a user should know about it.
    """

    text: str
    dots: tuple[Cylinder, ...]
    openings: tuple[PlacedOpening, ...]
    state: State
    direction: Vector
    position_mm: Vector
    reading: Vector
    arrow: Vector
    size_mm: tuple[float, float]
    com_clearance_mm: float
    sentence: str


def place_mark(
    body: Body,
    com_mm: Sequence[float] | Array,
    spec: MarkSpec,
    *,
    frame: RestFrame,
    min_wall_mm: float,
    wall_mm: float | None = None,
    pointing: Vector | None = None,
    seam_height_mm: float | None = None,
    side: Side = "any",
    keep_out: Sequence[Cylinder] = (),
    others: Sequence[PlacedOpening] = (),
) -> Mark:
    """Lay a mark on the surface, upright at rest.

    Args:
        body: A strictly convex body.
        com_mm: Centre of mass of the finished product.
        spec: Text, size of the dots and place.
        frame: Frame of the resting pose.
        min_wall_mm: Least material that the process can make: left between dots and behind them.
        wall_mm: Thickness of the wall behind the mark; None for a solid body.
        pointing: What the arrow is to point along; along the text, which is level then, if not given.
        seam_height_mm: Height of the seam over the body's origin, if there is one.
        side: Half of the body for `auto`, seen from the seam or, without one, from the body's origin.
        keep_out: Cylinders that dots must stay clear of.
        others: Openings that are there already.

    Raises:
        GeometryError: If the mark has no text, is too large or too deep, or has no place.
    """
    if not spec.text:
        raise GeometryError("A mark needs a text; give mark.text, or leave the mark out.")
    if wall_mm is not None and wall_mm - spec.depth_mm < min_wall_mm:
        raise GeometryError(
            f"Dots of the mark {spec.depth_mm:g} mm deep leave {wall_mm - spec.depth_mm:.3g} mm of a wall of "
            f"{wall_mm:.3g} mm, and {min_wall_mm:g} mm is needed; lower mark.depth_mm."
        )
    ground = _Ground(
        body=body,
        com_mm=np.asarray(com_mm, dtype=float),
        frame=frame,
        pointing=pointing,
        dot=Cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5 * spec.dot_mm, spec.depth_mm),
        land_mm=min_wall_mm,
        seam_height_mm=seam_height_mm,
        side=side,
        keep_out=(*keep_out, *(other.tool for other in others)),
    )
    layouts = mark_layouts(spec.text, _STRETCH * (spec.dot_mm + min_wall_mm))
    small = [layout for layout in layouts if layout.reach_mm <= _LARGEST_REACH * body.radius_mm]
    if not small:
        width, height = layouts[0].size_mm
        raise GeometryError(
            f"The mark {spec.text!r} would be {width:.3g} x {height:.3g} mm, too large for a body of "
            f"{body.diameter_mm:g} mm; use a shorter text, smaller dots or a process with thinner walls."
        )
    if spec.direction == "auto":
        return ground.mark(spec.text, *ground.best_place(spec.text, small))
    return ground.mark(spec.text, small[0], _unit_normal(spec.direction))


@dataclass(frozen=True, eq=False)
class _Ground:
    """The surface on which a mark is looked for, and the dot to be drilled there, as if along z."""

    body: Body
    com_mm: Array
    frame: RestFrame
    pointing: Vector | None
    dot: Cylinder
    land_mm: float
    seam_height_mm: float | None
    side: Side
    keep_out: tuple[Cylinder, ...]

    def best_place(self, text: str, layouts: Sequence[MarkLayout]) -> tuple[MarkLayout, Array]:
        """The layout, and the normal at its middle, for which the least |∇h| under it is largest.

        Raises:
            GeometryError: If no place is free and harmless.
        """
        everywhere = fibonacci_directions(_SITES)
        found = [(layout, self._best_of(layout, everywhere)) for layout in layouts]
        layout, (place, slope) = max(found, key=lambda item: item[1][1])
        width, height = layout.size_mm
        if slope < 0.0:
            raise GeometryError(
                f"There is no room for the mark {text!r} of {width:.3g} x {height:.3g} mm on "
                f"{SIDE_NAMES[self.side]}, clear of the seam, bosses and openings; use a shorter text or "
                "smaller dots."
            )
        near = self._best_of(layout, cap_directions(place, _NEARBY_ANGLE, _NEARBY))
        place, slope = max((place, slope), near, key=lambda item: item[1])
        if slope <= self.dot.radius_mm:
            raise GeometryError(
                f"Wherever on {SIDE_NAMES[self.side]} the mark {text!r} of {width:.3g} x {height:.3g} mm is "
                "put, one of its dots adds a rest; use a shorter text or smaller dots."
            )
        normal: Array = self.body.normal(place[None])[0]
        return layout, normal

    def mark(self, text: str, layout: MarkLayout, normal: Array) -> Mark:
        """The mark with its middle at an outward normal.

        Raises:
            GeometryError: If it points nowhere there, its dots come too near to each other, or they meet
                something.
        """
        site = unit(self.body.position_mm(touching_directions(self.body, normal[None])))
        reading, sign, slant = self._reading(normal[None])
        if slant[0] <= _LEAST_SLANT:
            raise GeometryError(
                f"The arrow of the mark {text!r} has no direction where the surface faces what it points "
                "along; put the mark on another side."
            )
        places, normals, _ = self._laid(site, reading, layout.dots_mm(sign[0])[None])
        self._require_clear(text, places, normals)
        openings = self._openings(text, places, normals)
        forced = [opening for opening in openings if opening.state == "forced"]
        clearance = min(opening.com_clearance_mm or 0.0 for opening in openings)
        width, height = layout.size_mm
        position = self.body.position_mm(site)[0]
        sentence = (
            f"The mark {text!r}, {width:.3g} x {height:.3g} mm of {len(openings)} dots at "
            f"{frame_place(self.frame, position)}, "
        )
        if forced:
            sentence += f"adds a rest at {len(forced)} of its dots; leave its place to the drill map."
        else:
            sentence += f"adds no rest until the centre of mass is off by {clearance:.3g} mm."
        openings = tuple(replace(opening, sentence=sentence) for opening in openings)
        return Mark(
            text=text,
            dots=tuple(opening.tool for opening in openings),
            openings=openings,
            state="forced" if forced else "allowed",
            direction=as_vector(normal),
            position_mm=as_vector(position),
            reading=as_vector(reading[0]),
            arrow=as_vector(sign[0] * reading[0]),
            size_mm=layout.size_mm,
            com_clearance_mm=clearance,
            sentence=sentence,
        )

    def _best_of(self, layout: MarkLayout, sites: Array) -> tuple[Array, float]:
        """Of surface parameters (n, 3) the best free one, and the least |∇h| there; −1 if none is free.

        The outline of the mark tells where all its dots are worth being laid.
        """
        reading, sign, slant = self._reading(self.body.normal(sites))
        sites, reading, sign = (values[slant > _LEAST_SLANT] for values in (sites, reading, sign))
        outlines = np.tile(layout.outline_mm(), (len(sites), 1, 1))
        promised = self._least_slopes(sites, reading, outlines)
        order = np.argsort(-promised, kind="stable")[: np.count_nonzero(promised > 0.0)]
        best, widest = sites[0], -1.0
        for start in range(0, len(order), _TRIED):
            rows = order[start : start + _TRIED]
            if promised[rows[0]] <= widest:
                break
            dots = np.stack([layout.dots_mm(turn) for turn in sign[rows]])
            slopes = self._least_slopes(sites[rows], reading[rows], dots)
            if slopes.max() > widest:
                best, widest = sites[rows[slopes.argmax()]], float(slopes.max())
        return best, widest

    def _least_slopes(self, sites: Array, reading: Array, dots_mm: Array) -> Array:
        """Least |∇h| under dots (n, k, 2) laid at n sites; −1 where they are not free, shape (n,)."""
        places, normals, slopes = self._laid(sites, reading, dots_mm)
        shape = dots_mm.shape[:2]
        free = self._free(places, normals).reshape(shape).all(axis=1)
        if self.seam_height_mm is not None:
            upper = (places @ np.array(self.frame.up) > self.seam_height_mm).reshape(shape)
            free &= upper.all(axis=1) | ~upper.any(axis=1)
        result: Array = np.where(free, slopes.reshape(shape).min(axis=1), -1.0)
        return result

    def _laid(self, sites: Array, reading: Array, dots_mm: Array) -> tuple[Array, Array, Array]:
        """Places, normals (n k, 3) and |∇h| (n k,) of dots (n, k, 2) laid at n sites."""
        across = np.cross(self.body.normal(sites), reading)
        ways = np.einsum("nka,nax->nkx", dots_mm, np.stack([reading, across], axis=1))
        starts = np.repeat(sites, dots_mm.shape[1], axis=0)
        points = self.body.surface(walked(self.body, starts, ways.reshape(-1, 3)))
        slopes = np.linalg.norm(support_about(points, self.com_mm)[1], axis=1)
        return points.position_mm, points.normal, slopes

    def _free(self, places: Array, normals: Array) -> BoolArray:
        """Which dots are on the side asked for and clear of the seam and of other things, shape (n,)."""
        free = np.ones(len(places), dtype=bool)
        above = places @ np.array(self.frame.up) - (self.seam_height_mm or 0.0)
        if self.seam_height_mm is not None:
            free &= np.abs(above) >= self.dot.radius_mm + self.land_mm
        if self.side != "any":
            free &= (above > 0.0) == (self.side == "upper")
        bases = places - self.dot.length_mm * normals
        for tool in self.keep_out:
            free &= gaps_mm(bases, places, self.dot.radius_mm, tool) >= self.land_mm
        return free

    def _require_clear(self, text: str, places: Array, normals: Array) -> None:
        """Refuse dots that meet something or each other.

        Raises:
            GeometryError: If they do.
        """
        if not self._free(places, normals).all():
            raise GeometryError(
                f"The mark {text!r} meets the seam, a boss or another opening, or is on the wrong side; give "
                "it another direction, or none."
            )
        land = least_spacing_mm(places) - 2.0 * self.dot.radius_mm
        if land < self.land_mm:
            raise GeometryError(
                f"The surface is so curved under the mark {text!r} that only {land:.3g} mm is left between "
                f"two of its dots and {self.land_mm:g} mm is needed; use a shorter text or smaller dots."
            )

    def _reading(self, normals: Array) -> tuple[Array, Array, Array]:
        """Reading directions (n, 3), signs of the arrow along them (n,), and sines of the slant (n,).

        Text is upright at rest, so the arrow may have to point against the reading direction.
        """
        up = np.array(self.frame.up)
        if self.pointing is None:
            along = np.cross(up, normals)
            # At the top and at the bottom every direction is level.
            along[np.linalg.norm(along, axis=1) <= _LEAST_SLANT] = self.frame.first
        else:
            along = np.tile(self.pointing, (len(normals), 1))
        along = along - np.einsum("nx,nx->n", along, normals)[:, None] * normals
        slant = np.linalg.norm(along, axis=1)
        forwards = along / np.maximum(slant, 1e-300)[:, None]
        sign = np.where(np.cross(normals, forwards) @ up >= -1e-9, 1.0, -1.0)
        return sign[:, None] * forwards, sign, slant

    def _openings(self, text: str, places: Array, normals: Array) -> tuple[PlacedOpening, ...]:
        """Each dot, judged on its own rim; without the sentence of the mark."""
        radius, depth = self.dot.radius_mm, self.dot.length_mm
        rims = hole_rims_mm(self.body, places, normals, np.full(len(places), radius))
        clearances = [rim_clearance_mm(rim, self.com_mm) for rim in rims]
        allowed = drill_limits(self.body, normals, self.com_mm).refined_radius_mm
        length = depth + OVERRUN_SHARE * self.body.radius_mm
        return tuple(
            PlacedOpening(
                name=f"dot {number} of the mark {text!r}",
                tool=Cylinder(as_vector(place - depth * normal), as_vector(normal), radius, length),
                rim_radius_mm=radius,
                allowed_radius_mm=float(limit),
                direction=as_vector(normal),
                position_mm=as_vector(place),
                state="allowed" if clearance > 0.0 else "forced",
                com_clearance_mm=clearance,
                sentence="",
                group=f"the mark {text!r}",
            )
            for number, (place, normal, clearance, limit) in enumerate(
                zip(places, normals, clearances, allowed, strict=True), start=1
            )
        )


def _unit_normal(direction: Vector) -> Array:
    """A given outward normal.

    Raises:
        GeometryError: If it has no length.
    """
    length = math.hypot(*direction)
    if not length > 0.0:
        raise GeometryError("mark.direction has no length; give an outward normal.")
    return np.array(direction, dtype=float) / length
