"""Whether a body rests in one pose or neutrally in a whole ring of them.

The orientations from which the body cannot leave a rest without its COM rising by a barrier form a
region around it: a disc around an ordinary rest, an annulus along a neutral ring (a cylinder on its
side), the whole sphere for a ball about its centre. They are told apart by what is left of the sphere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.equilibria.records import Extent

_ISLAND = 3.0
"""Height over the region, in barriers, that makes an island; the facets themselves reach about one."""


@dataclass(frozen=True, eq=False)
class Relief:
    """A height function on the cells of the sphere, each not below the ones on its rim.

    Attributes:
        node_height_mm: Heights of the points, shape (n,).
        cell_height_mm: Largest heights of the areas, shape (c,).
        edge_height_mm: Largest heights of the arcs, shape (m,).
        edge_nodes: The points at the ends of each arc, shape (m, 2).
        edge_cells: The areas on both sides of each arc, shape (m, 2).
    """

    node_height_mm: Array
    cell_height_mm: Array
    edge_height_mm: Array
    edge_nodes: IntArray
    edge_cells: IntArray

    def extent(self, bottom: int, barrier_mm: float) -> Extent:
        """Shape of the region around a minimum that lies less than a barrier above it.

        An island in it counts only if it rises well above the region, so that the roughness of
        a mesh does not make rings.

        Args:
            bottom: A node that is a minimum.
            barrier_mm: The barrier.
        """
        level = self.node_height_mm[bottom] + barrier_mm
        low = self.edge_height_mm <= level
        lakes = _components(self.edge_nodes[low], len(self.node_height_mm))
        wet = lakes == lakes[bottom]
        shore = ~(low & wet[self.edge_nodes[:, 0]])
        lands = _components(self.edge_cells[shore], len(self.cell_height_mm))
        dry = np.full(lands.max() + 1, -np.inf)
        np.maximum.at(dry, lands, self.cell_height_mm)
        count = int((dry > level + _ISLAND * barrier_mm).sum())
        return "point" if count == 1 else "ring" if count else "sphere"


def _components(pairs: IntArray, count: int) -> IntArray:
    links = (np.ones(len(pairs), dtype=bool), (pairs[:, 0], pairs[:, 1]))
    labels = connected_components(coo_array(links, shape=(count, count)), directed=False)[1]
    return labels.astype(np.int64)
