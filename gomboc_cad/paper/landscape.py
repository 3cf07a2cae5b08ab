"""The height of the COM over a mesh in every direction, with its slope."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gomboc_cad.body import SupportJet, mass_properties, support_jet
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import Array, fibonacci_directions, lengths
from gomboc_cad.paper.bodies import named_mesh, unit_body

_BLOCK = 1 << 17
_DIRECTIONS = 20_000


def heights_and_slopes(vertices: Array, com: Array, directions: Array) -> tuple[Array, Array]:
    """Height of the COM with each direction down, and `|∇h|`, the arm of the contact about it, shape (n,).

    Args:
        vertices: Corners of the body, shape (m, 3).
        com: Centre of mass, shape (3,).
        directions: Unit vectors, shape (n, 3).
    """
    arms = vertices - com
    step = max(1, _BLOCK // len(arms))
    contact = np.concatenate(
        [
            np.argmax(directions[start : start + step] @ arms.T, axis=1)
            for start in range(0, len(directions), step)
        ]
    )
    height = np.einsum("nx,nx->n", directions, arms[contact])
    return height, np.sqrt(np.maximum(0.0, lengths(arms[contact]) ** 2 - height**2))


@lru_cache(maxsize=8)
def mean_slope(name: str) -> float:
    """Mean of `|∇h|` over all orientations of a body of the paper's tables, about its centroid."""
    if name == "gomboc":
        return float(lengths(_supports("primary").gradient_mm).mean())
    mesh = named_mesh(name)
    com = np.array(mesh_mass(*mesh).com_mm)
    return float(heights_and_slopes(mesh.vertices, com, fibonacci_directions(_DIRECTIONS))[1].mean())


def mean_height(name: str) -> float:
    """Mean of the height over all orientations of the primary: half its mean width."""
    return float(_supports(name).height_mm.mean())


@lru_cache(maxsize=2)
def _supports(name: str) -> SupportJet:
    """Support function of a body of the catalogue about its centroid in all orientations."""
    body = unit_body(name)
    return support_jet(body, fibonacci_directions(_DIRECTIONS), np.array(mass_properties(body).com_mm))
