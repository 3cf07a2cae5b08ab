"""Simple solids from manifold3d as meshes."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from gomboc_cad.solid.mesh import Mesh


def mesh_of(manifold: Manifold) -> Mesh:
    """The mesh of a solid."""
    arrays = manifold.to_mesh64()
    return Mesh(np.array(arrays.vert_properties[:, :3]), np.array(arrays.tri_verts, dtype=np.int64))


def block(x: float, y: float, z: float) -> Manifold:
    """A block centred at the origin."""
    return Manifold.cube([x, y, z], True)


def rod(radius: float, length: float, segments: int = 96) -> Manifold:
    """A rod along z centred at the origin."""
    return Manifold.cylinder(length, radius, radius, segments, True)
