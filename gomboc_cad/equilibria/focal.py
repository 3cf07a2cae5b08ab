"""Samples of the surfaces that bound the loading zone, as dense as the place asks for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gomboc_cad.body.sphere import Array, geodesic_triangulation, unit
from gomboc_cad.equilibria.cells import in_blocks
from gomboc_cad.errors import CensusError

_START_LEVEL = 4
_MAX_SAMPLES = 20_000_000


def image_samples(image: Callable[[Array], Array], spacing_mm: Callable[[Array], Array]) -> Array:
    """Sample the image of the sphere under a continuous map, however it folds.

    Triangles of directions are halved across the longest edge of their image until the images of the corners
    lie within the wanted spacing of the image of the centre; those centres are the samples. Halving keeps
    the images of even size where the map contracts one direction, as at the cusps of the focal surface.

    Args:
        image: Takes unit vectors (n, 3) to points in mm (n, 3).
        spacing_mm: Spacing wanted at points (n, 3), shape (n,).

    Returns:
        Points of the image, shape (k, 3).

    Raises:
        CensusError: If that would take more than twenty million points.
    """
    vertices, triangles = geodesic_triangulation(_START_LEVEL)
    directions, corners = vertices[triangles], image(vertices)[triangles]
    samples: list[Array] = []
    total = 0
    while len(directions):
        centers = in_blocks(image, unit(directions.sum(axis=1)))
        reach = _lengths(corners - centers[:, None]).max(axis=1)
        coarse = reach > spacing_mm(centers)
        samples.append(centers[~coarse])
        total += len(centers)
        if total > _MAX_SAMPLES:
            raise CensusError(
                "The centre of mass is too near to the edge of its loading zone for the zone to be drawn; "
                "move it farther inside."
            )
        directions, corners = _halved(directions[coarse], corners[coarse], reach[coarse], image)
    return np.concatenate(samples)


def _halved(
    directions: Array, corners: Array, reach: Array, image: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Halve triangles across the longest edge of the image, or of the directions where it is folded."""
    lengths = _edge_lengths(corners)
    folded = lengths.max(axis=1) < reach
    lengths[folded] = _edge_lengths(directions[folded])
    order = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3
    rows = np.arange(len(order))[:, None]
    (a, b, c), (ia, ib, ic) = (part[rows, order].transpose(1, 0, 2) for part in (directions, corners))
    m = unit(a + b)
    im = in_blocks(image, m)
    return (
        np.concatenate([np.stack([a, m, c], axis=1), np.stack([m, b, c], axis=1)]),
        np.concatenate([np.stack([ia, im, ic], axis=1), np.stack([im, ib, ic], axis=1)]),
    )


def _edge_lengths(corners: Array) -> Array:
    """Lengths of the edges 01, 12 and 20 of triangles (n, 3, 3), shape (n, 3)."""
    return _lengths(corners[:, [1, 2, 0]] - corners)


def _lengths(arms: Array) -> Array:
    """Lengths of vectors (n, 3, 3) along the last axis, shape (n, 3)."""
    x, y, z = arms.transpose(2, 0, 1)
    result: Array = np.sqrt(x * x + y * y + z * z)
    return result
