"""Outer surfaces that float, and the census of one that floats with a share of its volume."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gomboc_cad.body import catalog
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.hydrostatics import FloatingCensus, FloatingState, Water, floating_census, floating_state
from tests.equilibria.polyhedra import Array, Mesh, hull_mesh, platonic

UNIT_WATER = Water("water of unit density", 1.0)


def box(length: float, beam: float, depth: float) -> Mesh:
    """About the origin; length along x, depth along z."""
    return hull_mesh(platonic(6) * (np.array([length, beam, depth]) / 2.0))


def ball(level: int = 4, radius: float = 1.0) -> Mesh:
    """An icosphere with its corners on the sphere."""
    directions, faces = geodesic_triangulation(level)
    return Mesh(directions * radius, faces)


def sloan(level: int, diameter_mm: float = 100.0) -> Mesh:
    """The catalogue's primary body."""
    directions, faces = geodesic_triangulation(level)
    radii = catalog()["primary"].with_diameter(diameter_mm).radius_at(directions)
    return Mesh(directions * radii[:, None], faces)


def revolution(profile: Array, sides: int = 128) -> Mesh:
    """The convex hull of a profile of (radius, height), shape (n, 2), turned about z."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [np.column_stack([r * circle, np.full(sides, z)]) for r, z in profile if r > 0.0]
    tips = [np.array([[0.0, 0.0, z]]) for r, z in profile if r == 0.0]
    return hull_mesh(np.concatenate(rings + tips))


def mass_for(mesh: Mesh, share: float) -> float:
    """Mass in g that puts a share of the volume under water of unit density."""
    return 1e-3 * share * mesh_mass(*mesh).volume_mm3


def float_with(mesh: Mesh, share: float, com: Sequence[float] | Array, up: Sequence[float]) -> FloatingState:
    """How it floats with a share of its volume under water."""
    return floating_state(*mesh, mass_for(mesh, share), com, up, UNIT_WATER)


def census_with(
    mesh: Mesh, share: float, com: Sequence[float] | Array | None = None, **options: Any
) -> FloatingCensus:
    """Its floating census, homogeneous unless a COM is given."""
    center = mesh_mass(*mesh).com_mm if com is None else com
    return floating_census(*mesh, mass_for(mesh, share), center, UNIT_WATER, **({"level": 4} | options))
