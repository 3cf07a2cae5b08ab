"""Volumes, moments and lines of a body that masses are reckoned from, by quadrature and without solids."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gomboc_cad.body import Body, mass_properties, support_height_mm
from gomboc_cad.body.sphere import Array, tangent_frame, unit
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.equilibria.rim import ray_lengths_mm
from gomboc_cad.products.process import Process, known_tolerances
from gomboc_cad.tolerance.com_model import WeighedPart, spread_mm2

if TYPE_CHECKING:
    from gomboc_cad.products.placement import Parting

_NODES = 64
_SEAM_POINTS = 720
_WATER_G_MM3 = 1e-3


class GlueLine(NamedTuple):
    """The line along a seam that glue is put on.

    Attributes:
        length_mm: Its length.
        center_mm: Its centre, shape (3,).
        first_moments_mm: How the centre of mass of glue of `m (1 + u₁ cos φ + u₂ sin φ)` moves for a unit of
            u₁ and of u₂, to first order, shape (2, 3): half the radius on a circle.
    """

    length_mm: float
    center_mm: Array
    first_moments_mm: Array


def build_direction(process: Process, print_up: Vector) -> Vector:
    """Direction that points up where a part is made.

    Args:
        process: The process, which may have one direction for all parts.
        print_up: The part's own.
    """
    layers = known_tolerances(process).layers
    wanted = print_up if layers is None or layers.direction == "print_up" else layers.direction
    return as_vector(unit(np.array(wanted)))


def machine_axes(build_up: Vector) -> Array:
    """Unit vectors along x, y and the build direction of a machine as rows, shape (3, 3).

    Where the build direction is an axis of the body's frame, x and y are the two others.
    """
    up = np.array(build_up)
    first, second = tangent_frame(up[None])
    return np.stack([first[0], second[0], up])


def whole_body(body: Body, com_mm: Vector, build_up: Vector) -> WeighedPart:
    """A massive body as a part; what it weighs decides nothing, so it has the density of water.

    Args:
        body: The body.
        com_mm: Its centre of mass.
        build_up: Direction that points up where it is made.
    """
    mass = mass_properties(body)
    heights = support_height_mm(body, np.array([build_up, np.negative(build_up)]))
    return WeighedPart(
        name=body.name,
        role="shell",
        mass_g=_WATER_G_MM3 * mass.volume_mm3,
        com_mm=com_mm,
        build_up=build_up,
        height_mm=float(heights.sum()),
        spread_mm2=spread_mm2(mass),
        volume_mm3=mass.volume_mm3,
    )


def volume_above_mm3(body: Body, up: Array, height_mm: float) -> float:
    """Volume of the part of a body above a plane.

    The piece beyond a plane at a distance d from the origin has, along each direction u that reaches it, the
    volume `(r³ − (d/u·n)³)/3` for a unit of solid angle.

    Args:
        body: A convex body that holds the origin.
        up: Unit normal of the plane, shape (3,).
        height_mm: Its height over the origin along that.
    """
    if height_mm < 0.0:
        return mass_properties(body).volume_mm3 - volume_above_mm3(body, -up, -height_mm)
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    slant = np.repeat(0.5 * (nodes + 1.0), 2 * _NODES)
    angle = np.tile(np.pi * np.arange(2 * _NODES) / _NODES, _NODES)
    across = np.sqrt(1.0 - slant**2)
    first, second = (axis[0] for axis in tangent_frame(up[None]))
    directions = np.outer(slant, up) + np.outer(across * np.cos(angle), first)
    directions += np.outer(across * np.sin(angle), second)
    beyond = np.maximum(body.radius_at(directions) ** 3 - (height_mm / slant) ** 3, 0.0) / 3.0
    solid_angle = np.repeat(0.5 * weights, 2 * _NODES) * np.pi / _NODES
    return float(solid_angle @ beyond)


def glue_line(body: Body, parting: Parting, inset_mm: float) -> GlueLine:
    """The line that follows the section of a body with a plane, inside of it.

    Args:
        body: A convex body.
        parting: The plane; its point over the origin is inside of the body.
        inset_mm: How far the line is inside of the section.
    """
    angle = 2.0 * np.pi * np.arange(_SEAM_POINTS) / _SEAM_POINTS
    first, second, up = machine_axes(parting.up)
    cosine, sine = np.cos(angle), np.sin(angle)
    rays, middle = np.outer(cosine, first) + np.outer(sine, second), parting.height_mm * up
    length = ray_lengths_mm(body, middle, rays)
    line = middle + (length - inset_mm)[:, None] * rays
    steps = np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1)
    shares = 0.5 * (steps + np.roll(steps, 1)) / steps.sum()
    center = shares @ line
    uneven = np.stack([shares * cosine, shares * sine])
    return GlueLine(float(steps.sum()), center, uneven @ (line - center))
