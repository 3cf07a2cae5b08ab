"""How a part floats in one orientation."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gomboc_cad.body.arrays import finite_vector
from gomboc_cad.body.sphere import Array, IntArray, unit
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.hydrostatics.immersion import waterline_edges
from gomboc_cad.hydrostatics.landscape import FloatingLandscape
from gomboc_cad.hydrostatics.records import STANDARD_GRAVITY_M_S2, FloatingState, energy_mj
from gomboc_cad.hydrostatics.surface import WettedSurface, wetted_surface
from gomboc_cad.hydrostatics.water import SEA_WATER, Water


def floating_state(
    vertices: Array,
    faces: IntArray,
    mass_g: float,
    com_mm: Sequence[float] | Array,
    up: Sequence[float] | Array,
    water: Water = SEA_WATER,
) -> FloatingState:
    """Let a part float in one orientation, turned neither by its weight nor by its buoyancy.

    Args:
        vertices: Corners of the outer surface in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, counter-clockwise from outside, shape (m, 3).
        mass_g: Mass of the part with all that it carries.
        com_mm: Its centre of mass, shape (3,).
        up: Body direction that points up, of any length, shape (3,).
        water: What it floats in.

    Raises:
        GeometryError: If the surface is not closed and oriented outwards, the part is too heavy to
            float or has no positive mass, or the COM or the direction is not finite.
    """
    direction = _as_vector(up, "direction that points up")
    if not np.any(direction):
        raise GeometryError("The direction that points up must not be zero.")
    landscape = floating_landscape(vertices, faces, mass_g, com_mm, water)
    return state_at(landscape, unit(direction), mass_g, water)


def floating_landscape(
    vertices: Array, faces: IntArray, mass_g: float, com_mm: Sequence[float] | Array, water: Water
) -> FloatingLandscape:
    """Check what is given and make the landscape of the energy.

    Raises:
        GeometryError: As `floating_state`.
    """
    center = _as_vector(com_mm, "centre of mass")
    surface = wetted_surface(vertices, faces)
    if not (math.isfinite(mass_g) and mass_g > 0.0):
        raise GeometryError(f"The mass must be a positive number of grams, not {mass_g!r}.")
    volume = water.displaced_volume_mm3(mass_g)
    if volume >= surface.volume_mm3:
        most = 1e-3 * surface.volume_mm3 * water.density_g_cm3
        raise GeometryError(
            f"The part sinks: it weighs {mass_g:.6g} g and displaces at most {most:.6g} g of {water.name}; "
            "make it lighter or larger."
        )
    return FloatingLandscape(surface, center - surface.pivot_mm, volume)


def _as_vector(values: Sequence[float] | Array, name: str) -> Array:
    vector = finite_vector(values)
    if vector is None:
        raise GeometryError(f"The {name} must be three finite numbers, not {values!r}.")
    return vector


def state_at(landscape: FloatingLandscape, up: Array, mass_g: float, water: Water) -> FloatingState:
    """Describe how a part floats in the orientation of a unit direction, shape (3,)."""
    surface, volume = landscape.surface, landscape.volume_mm3
    jet = landscape.jet(up[None])
    at = jet.immersion
    level, buoyancy, flotation = float(at.level_mm[0]), at.buoyancy_mm[0], at.flotation_mm[0]
    second, vectors = np.linalg.eigh(at.second_mm4[0])
    # Heeling about an axis weighs the distances from it, along the other axis.
    heel_axes = np.cross(up, vectors.T @ at.frame[0])
    height = float(jet.height_mm[0])
    arm = buoyancy - landscape.com_mm
    weight_n = 1e-3 * mass_g * STANDARD_GRAVITY_M_S2
    heights = surface.corners_mm @ up
    low, high = (float(value) for value in second)
    return FloatingState(
        up=as_vector(up),
        water=water,
        displaced_volume_mm3=volume,
        reserve_buoyancy=1.0 - volume / surface.volume_mm3,
        draft_mm=level - float(heights.min()),
        freeboard_mm=float(heights.max()) - level,
        waterline_mm=_waterline_loops(surface, up, level),
        center_of_buoyancy_mm=as_vector(buoyancy + surface.pivot_mm),
        center_of_flotation_mm=as_vector(flotation + surface.pivot_mm),
        waterplane_area_mm2=float(at.area_mm2[0]),
        second_moments_mm4=(low, high),
        heel_axes=(as_vector(heel_axes[0]), as_vector(heel_axes[1])),
        bm_mm=(low / volume, high / volume),
        gm_mm=(low / volume - height, high / volume - height),
        com_over_buoyancy_mm=height,
        energy_mj=energy_mj(mass_g, height),
        righting_arm_mm=float(np.linalg.norm(jet.gradient_mm[0])),
        restoring_torque_n_mm=as_vector(weight_n * np.cross(arm, up)),
    )


def _waterline_loops(surface: WettedSurface, up: Array, level: float) -> tuple[Array, ...]:
    """Chain the cuts of the facets over the edges that they share; the longest loop first."""
    heights = surface.corners_mm @ up
    count = len(heights)
    start, end = waterline_edges(surface, up, level) @ np.array([count, 1])
    following = dict(zip(start.tolist(), end.tolist(), strict=True))
    loops = []
    while following:
        edge = next(iter(following))
        edges = []
        while edge in following:
            edges.append(edge)
            edge = following.pop(edge)
        one, other = np.divmod(np.array(edges), count)
        share = (level - heights[one]) / (heights[other] - heights[one])
        a, b = surface.corners_mm[one], surface.corners_mm[other]
        loops.append(a + share[:, None] * (b - a) + surface.pivot_mm)
    return tuple(sorted(loops, key=len, reverse=True))
