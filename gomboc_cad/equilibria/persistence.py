"""Persistence of minima on a graph: which basins are real, and what it takes to leave them.

Water rises over a landscape whose low points are nodes and whose passes are edges. Each minimum starts a
lake; when two lakes meet at a pass, the one with the higher bottom ends there (the elder rule). The rise
from its bottom to that pass is its persistence: the smallest change of the landscape that could remove
it. Source: Edelsbrunner, Letscher, Zomorodian, Discrete Comput. Geom. 28 (2002) 511.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree

from gomboc_cad.body.sphere import Array, BoolArray, IntArray

NEVER = np.inf


@dataclass(frozen=True, eq=False)
class MergeTree:
    """The basins of a landscape and the passes at which they meet, lowest first.

    Attributes:
        bottom: The node at the bottom of each basin, rising height, shape (b,).
        basin: The basin that each node drains into, shape (n,).
        persistence: Rise from each bottom to the pass at which it ends; infinite for the deepest, shape (b,).
        survivor: The deeper basin that it joins there; itself for the deepest.
        pass_edge: The edge of that pass; −1 for the deepest.
        ends: The two basins that each of the passes connects directly, shape (b − 1, 2).
        pass_height: Heights of those passes, rising, shape (b − 1,).
    """

    bottom: IntArray
    basin: IntArray
    persistence: Array
    survivor: IntArray
    pass_edge: IntArray
    ends: IntArray
    pass_height: Array

    def counted(self, barrier: float) -> BoolArray:
        """Which basins have a persistence of at least the barrier; the deepest always has."""
        result: BoolArray = self.persistence >= barrier
        return result

    def homes(self, counted: BoolArray) -> IntArray:
        """The counted basin that each basin drains into once the others are ignored, shape (b,)."""
        home = np.where(counted, np.arange(len(counted)), self.survivor)
        while np.any(home != home[home]):
            home = home[home]
        return home

    def climb(self, heights: Array, counted: BoolArray) -> Array:
        """Rise from the bottom of each counted basin to the lowest pass into another counted one, shape (b,).

        Infinite if there is no other; of no meaning for basins that are not counted.
        """
        home = self.homes(counted)
        union = _Union(len(counted))
        alone = np.ones(len(counted), dtype=bool)
        rise = np.full(len(counted), NEVER)
        for (a, b), height in zip(home[self.ends].tolist(), self.pass_height.tolist(), strict=True):
            a, b = union.find(a), union.find(b)
            if a == b:
                continue
            for lake in (a, b):
                if alone[lake]:
                    # Every lake is led by a counted basin, and while it is alone, by that one.
                    rise[lake] = height - heights[self.bottom[lake]]
            alone[union.join(a, b)] = False
        return rise


def merge_tree(heights: Array, edges: IntArray, edge_heights: Array, downhill: IntArray) -> MergeTree:
    """Find the basins of a graph and merge them by rising water.

    Args:
        heights: Height of each node, shape (n,).
        edges: Nodes that each edge connects, shape (m, 2).
        edge_heights: Height of each edge, not below its nodes, shape (m,).
        downhill: A neighbour that the water flows to from each node, without circles; the node itself
            where it is a minimum, shape (n,).
    """
    sink = downhill
    while np.any(sink != sink[sink]):
        sink = sink[sink]
    bottom = np.flatnonzero(downhill == np.arange(len(heights)))
    bottom = bottom[np.argsort(heights[bottom], kind="stable")]
    number = np.full(len(heights), -1)
    number[bottom] = np.arange(len(bottom))
    basin = number[sink]
    ends, chosen = _spanning_passes(basin[edges], edge_heights, len(bottom))
    return _merge(bottom, basin, ends, edge_heights[chosen], chosen, heights[bottom])


def _spanning_passes(ends: IntArray, heights: Array, count: int) -> tuple[IntArray, IntArray]:
    """The passes that a rising water table needs to connect all basins, lowest first, and their edges."""
    crossing = np.flatnonzero(ends[:, 0] != ends[:, 1])
    pair = np.sort(ends[crossing], axis=1)
    order = np.lexsort((heights[crossing], pair[:, 1], pair[:, 0]))
    crossing, pair = crossing[order], pair[order]
    first = np.ones(len(pair), dtype=bool)
    first[1:] = np.any(pair[1:] != pair[:-1], axis=1)
    crossing, pair = crossing[first], pair[first]
    # Ranks instead of heights: the tree of scipy takes a weight of zero for no edge.
    rank = np.empty(len(crossing))
    rank[np.argsort(heights[crossing], kind="stable")] = np.arange(1, len(crossing) + 1)
    graph = coo_array((rank, (pair[:, 0], pair[:, 1])), shape=(count, count)).tocsr()
    tree = np.sort(minimum_spanning_tree(graph).data).astype(np.int64)
    by_rank = np.empty(len(crossing), dtype=np.int64)
    by_rank[rank.astype(np.int64) - 1] = np.arange(len(crossing))
    kept = by_rank[tree - 1]
    return pair[kept], crossing[kept]


def _merge(
    bottom: IntArray, basin: IntArray, ends: IntArray, heights: Array, edges: IntArray, floor: Array
) -> MergeTree:
    """Apply the elder rule; basins are numbered by rising bottoms, so the elder has the smaller number."""
    count = len(bottom)
    union = _Union(count)
    persistence = np.full(count, NEVER)
    survivor, pass_edge = np.arange(count), np.full(count, -1)
    for (a, b), height, edge in zip(ends.tolist(), heights.tolist(), edges.tolist(), strict=True):
        elder, younger = sorted((union.find(a), union.find(b)))
        persistence[younger] = height - floor[younger]
        survivor[younger] = elder
        pass_edge[younger] = edge
        union.join(elder, younger)
    return MergeTree(bottom, basin, persistence, survivor, pass_edge, ends, heights)


class _Union:
    """Disjoint sets, each led by its smallest member."""

    def __init__(self, count: int) -> None:
        self._leader = list(range(count))

    def find(self, member: int) -> int:
        leader = self._leader
        while leader[member] != member:
            leader[member] = leader[leader[member]]
            member = leader[member]
        return member

    def join(self, a: int, b: int) -> int:
        """Join the sets of two leaders and return the leader of both."""
        leader, other = min(a, b), max(a, b)
        self._leader[other] = leader
        return leader
