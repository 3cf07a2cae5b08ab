"""Parts made of layers: real stair steps, and where a body stops on them.

A printed layer is the section of the part at its middle, extruded by the layer's height t. Its upper edge
reaches the hull where the surface faces up, its lower edge where it faces down. So the hull is that of the
surface, its upper half moved up by t/2 and its lower half down, taken at the heights of the sections only.
Between two edges lies a strip as long as the surface takes to climb by t; the body stops on it where the foot
of the perpendicular from the COM falls inside it. At the poles of the build direction lies a flat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, unit
from gomboc_cad.body.support import touching_directions
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import CensusError
from gomboc_cad.tolerance.geometry import MadePart, PartPoints
from gomboc_cad.tolerance.rebuilt import Rebuilt, come_to_rest, nominal_rest, sag_or_default_mm
from gomboc_cad.tolerance.refinement import (
    CURVATURE_SAFETY,
    Patches,
    Refined,
    Ruling,
    SampledPart,
    could_balance,
    refine,
)
from gomboc_cad.tolerance.variants import Nominal, Variants

_MOST_LAYERED_POINTS = 200_000
_STEEP = 4.0
"""Where the normal is so many t/R₀ or less from level, both edges of a layer may be on the hull."""

_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Layers:
    """How a part is cut into layers.

    Attributes:
        build_direction: Unit vector in which it grows.
        height_mm: Height of a layer.
        phase: Where the first section lies, in layers over the origin of the body's frame.
    """

    build_direction: Vector
    height_mm: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        """Raise CensusError if the height is no positive length, or the direction no unit vector."""
        if not 0.0 < self.height_mm < np.inf:
            raise CensusError(f"The height of a layer must be a positive length, not {self.height_mm!r}.")
        if not abs(np.linalg.norm(self.build_direction) - 1.0) < 1e-6:
            raise CensusError(f"The build direction must be a unit vector, not {self.build_direction!r}.")


def layered_rest(
    nominal: Nominal,
    variants: Variants,
    row: int,
    layers: Layers,
    barrier_mm: float | None = None,
    sag_mm: float | None = None,
) -> Rebuilt:
    """Build a variant of real layers and let it come to rest.

    Args:
        nominal: What is varied.
        variants: The variants.
        row: Which of them.
        layers: Its layers, of the whole part or of both halves alike; the rims of seam and holes are moved by
            half a layer, not stepped.
        barrier_mm: Rests with a lower barrier do not count; by default one and a half times the sag, so that
            every step of the stairs that holds the part is a rest.
        sag_mm: Sag of the edges of the layers; by default that of `rebuild`.

    Raises:
        GeometryError: If the parting plane or a hole does not cut the part as it should.
    """
    sag = sag_or_default_mm(nominal, sag_mm)
    sampled = sample_layers(MadePart.of(nominal, variants, row), layers, sag)
    return come_to_rest(sampled, nominal_rest(nominal, sag), barrier_mm)


def sample_layers(part: MadePart, layers: Layers, sag_mm: float) -> SampledPart:
    """Choose points of a layered part: edges of the layers where it could balance, some of them elsewhere.

    Raises:
        GeometryError: If the parting plane or a hole does not cut the part as it should.
    """

    def critical(made: MadePart, points: PartPoints, patches: Patches) -> BoolArray:
        return could_balance(made, points, patches) | _could_stop(points, patches, layers)

    refined = refine(part, sag_mm, critical, _MOST_LAYERED_POINTS)
    part, points = refined.part, refined.points
    surface = points.chosen(np.unique(refined.coarse)).and_also(_sections(refined, layers))
    kept = surface.chosen(np.flatnonzero(~part.in_mouth(surface.part_mm)))
    for rim in part.rims(refined.sag_mm):
        kept = kept.and_also(rim)
    return SampledPart(part, points, _edges_mm(kept, layers, part.body.radius_mm), refined.sag_mm)


def stair_dead_zone_mm(body: Body, build_direction: Vector, layer_mm: float, normals: Array) -> Array:
    """Largest `|∇h|` of the smooth body, place by place, at which layers can still stop it.

    A step spans a climb of t. It is bridged along the direction that is conjugate to the contour line of the
    layer, `A⁻¹ b`, A the shape operator and b the build direction in the tangent plane, so half of its chord
    is `t/2 |A⁻¹ b| / (bᵀ A⁻¹ b)`: on a sphere `t / (2 sinα)`, α the angle between normal and build direction.
    The edges lie t/2 farther out than the surface, which moves the foot of the perpendicular from the
    COM by `t/2 sinα` to the outside. So the body stops at a place only if `|∇h|` is below the sum of both.

    At a pole a section that just misses it leaves a flat of radius `sqrt(2 ρ t)`, ρ the larger radius of
    curvature; it takes the place of the steps as far as the first of them reaches.

    This is to be compared with `|∇h|` as the radius of a hole is: lay the poles of the build direction where
    the drill map allows the flat.

    Args:
        body: A strictly convex body.
        build_direction: Unit vector.
        layer_mm: Height t of a layer.
        normals: Outward unit normals of the places, shape (n, 3).

    Returns:
        Shape (n,).
    """
    layers = Layers(build_direction, layer_mm)
    surface = body.surface(touching_directions(body, normals))
    level = surface.tangents @ np.array(layers.build_direction)
    ruling = np.linalg.solve(surface.shape_operator_per_mm, level[:, :, None])[:, :, 0]
    climb = np.einsum("na,na->n", level, ruling)
    at_pole = climb <= 0.5 * layer_mm
    half_chord = 0.5 * layer_mm * np.linalg.norm(ruling, axis=1) / np.where(at_pole, 1.0, climb)
    flat = np.sqrt(2.0 * layer_mm / surface.principal_curvatures_per_mm()[:, 1])
    farther_out = 0.5 * layer_mm * np.linalg.norm(level, axis=1)
    result: Array = np.where(at_pole, flat, half_chord) + farther_out
    return result


def _could_stop(points: PartPoints, patches: Patches, layers: Layers) -> BoolArray:
    """Which triangles are so near to a balance that steps there, or a flat at a pole, may hold the part.

    In the metric of the curvature a step is t over the steepness long. That far its strips reach to any side:
    along the contour lines too, where edges of layers and points of the smooth surface meet.
    """
    height = (points.own_mm @ np.array(layers.build_direction))[patches.triangles]
    steepness = Ruling.across(patches, height).steepness
    # At a pole a layer is as deep as a cap of the surface.
    flat = np.sqrt(2.0 * layers.height_mm)
    step = CURVATURE_SAFETY * np.minimum(layers.height_mm / np.maximum(steepness, _TINY), flat)
    result: BoolArray = patches.imbalance <= step + patches.cap
    return result


def _sections(refined: Refined, layers: Layers) -> PartPoints:
    """Points of the sections at the middles of the layers, where they cross sides of the fine triangles."""
    part, points, fine = refined.part, refined.points, refined.fine
    up = np.array(layers.build_direction)
    sides = np.concatenate([fine[:, [0, 1]], fine[:, [1, 2]], fine[:, [2, 0]]])
    low, high = np.unique(np.sort(sides, axis=1), axis=0).T
    level = points.own_mm @ up / layers.height_mm - layers.phase
    low, high = np.where(level[low] <= level[high], (low, high), (high, low))
    first = np.ceil(level[low])
    crossings = np.maximum(0, np.floor(level[high]) - first + 1).astype(np.int64)
    side = np.repeat(np.arange(len(low)), crossings)
    number = np.arange(len(side)) - np.repeat(np.cumsum(crossings) - crossings, crossings)
    start, end = points.directions[low[side]], points.directions[high[side]]
    below, above = level[low[side]], level[high[side]]
    wanted = first[side] + number

    def at(share: Array) -> PartPoints:
        return part.at(unit(start + share[:, None] * (end - start)))

    span = np.where(above > below, above - below, 1.0)
    share = (wanted - below) / span
    # One step of the secant is enough: along a side the height is a parabola as flat as the sag.
    share += (wanted - (at(share).own_mm @ up / layers.height_mm - layers.phase)) / span
    found = at(np.clip(share, 0.0, 1.0))
    # A section is flat to the last digit, or the flat at a pole would be a heap of facets.
    missed = (wanted + layers.phase) * layers.height_mm - found.own_mm @ up
    return found._replace(position_mm=found.position_mm + missed[:, None] * up)


def _edges_mm(points: PartPoints, layers: Layers, radius_mm: float) -> Array:
    """Where the edges of the layers are that have their sections at these points, shape (n, 3)."""
    up = np.array(layers.build_direction)
    facing = points.normal @ up
    steep = _STEEP * layers.height_mm / radius_mm
    half = 0.5 * layers.height_mm * up
    tops, bottoms = points.position_mm[facing > -steep] + half, points.position_mm[facing < steep] - half
    return np.concatenate([tops, bottoms])
