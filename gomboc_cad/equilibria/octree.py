"""A graded octree, cut into tetrahedra that meet face to face, and the boundary of a part of it.

Cells are addressed by level and integer place. Neighbours differ by one level at most, corners and edges
included. Each cell is the union of cones from its centre over its faces. A face is cut along a diagonal, or
from its own centre if finer cells touch one of its edges; a face next to finer cells is made of theirs. So
the tetrahedra of different cells share whole faces, and the boundary of any set of nodes is closed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray

_BITS = 21
_FINEST = 19
"""Deepest level: places in half cells of this level still fit into `_BITS`."""

_CORNERS = np.array(list(product((0, 1), repeat=3)))
_AROUND = np.array([p for p in product((-1, 0, 1), repeat=3) if any(p)])


@dataclass(frozen=True)
class Octree:
    """Leaves of a graded octree.

    Attributes:
        origin_mm: Lowest corner of the root cube, shape (3,).
        side_mm: Edge of the root cube.
        split: For each level the keys of the cells that are split, sorted.
    """

    origin_mm: Array
    side_mm: float
    split: tuple[IntArray, ...]

    @classmethod
    def refined(
        cls,
        center_mm: Array,
        side_mm: float,
        start_level: int,
        wanted: Callable[[Array, float], BoolArray],
    ) -> Octree:
        """Split cells from the root on while `wanted(centres (n, 3), edge)` says so, and grade the result.

        Args:
            center_mm: Middle of the root cube.
            side_mm: Its edge.
            start_level: Level up to which everything is split.
            wanted: Which cells of one size to split.
        """
        origin = center_mm - 0.5 * side_mm
        places = np.zeros((1, 3), dtype=np.int64)
        split = []
        for level in range(_FINEST):
            edge = side_mm / 2**level
            if level >= start_level:
                places = places[wanted(origin + edge * (places + 0.5), edge)]
            if len(places) == 0:
                break
            split.append(_key(places))
            places = _children(places)
        return cls(origin, side_mm, _graded(split))

    def leaves(self) -> Iterator[tuple[int, IntArray]]:
        """Level and places (n, 3) of the cells that are not split, level by level."""
        for level in range(1, len(self.split) + 1):
            places = _children(_place(self.split[level - 1]))
            yield level, places[~self._is_split(level, places)]

    def _is_split(self, level: int, places: IntArray) -> BoolArray:
        if level >= len(self.split):
            return np.zeros(len(places), dtype=bool)
        size = 2**level
        within = np.all((places >= 0) & (places < size), axis=1)
        result: BoolArray = within & _contains(self.split[level], _key(np.clip(places, 0, size - 1)))
        return result

    def edge_mm(self, level: int) -> float:
        """Edge of the cells of a level."""
        return self.side_mm / float(1 << level)

    def centers_mm(self, level: int, places: IntArray) -> Array:
        """Centres of cells, shape (n, 3)."""
        result: Array = self.origin_mm + self.edge_mm(level) * (places + 0.5)
        return result

    def node_positions_mm(self, nodes: IntArray) -> Array:
        """Positions of nodes, shape (n, 3)."""
        result: Array = self.origin_mm + self.side_mm / 2 ** (_FINEST + 1) * _place(nodes)
        return result

    def corner_nodes(self, level: int, places: IntArray) -> IntArray:
        """Nodes at the corners of cells, shape (n, 8)."""
        return _node(2 * places[:, None] + 2 * _CORNERS, level)

    def center_nodes(self, level: int, places: IntArray) -> IntArray:
        """Nodes at the centres of cells, shape (n,)."""
        return _node(2 * places + 1, level)

    def tetrahedra(self, level: int, places: IntArray) -> IntArray:
        """Cut cells into tetrahedra of positive volume; four nodes each, shape (m, 4)."""
        return np.concatenate(
            [self._face_cones(level, places, axis, side) for axis in range(3) for side in (0, 1)]
        )

    def _face_cones(self, level: int, places: IntArray, axis: int, side: int) -> IntArray:
        """Cones over one face of each cell: from the cell's centre over the triangles of the face."""
        outward, first, second = (np.roll(axis_vector, axis) for axis_vector in np.eye(3, dtype=np.int64))
        outward = outward if side else -outward
        # A face from corner to corner counter-clockwise, the same diagonal on both sides of it.
        if not side:
            first, second = second, first
        square = [-first - second, first - second, first + second, second - first]
        turns = [(square[k], square[(k + 1) % 4]) for k in range(4)]
        halves = [(square[0], square[1], square[2]), (square[2], square[3], square[0])]

        fine = self._is_split(level, places + outward)
        bent = np.stack([self._edge_is_split(level, places, outward, (a + b) // 2) for a, b in turns])
        plain = ~fine & ~bent.any(axis=0)
        # In quarters of a cell.
        apex = 4 * places + 2
        cones = [
            _cone(level, apex[plain], *(apex[plain] + 2 * (outward + corner) for corner in half))
            for half in halves
        ]
        for quarter in square:
            middle = apex[fine] + 2 * outward + quarter
            cones += [_cone(level, apex[fine], *(middle + corner for corner in half)) for half in halves]
        for edge_is_bent, (a, b) in zip(bent, turns, strict=True):
            for rows, path in ((~edge_is_bent, (2 * a, 2 * b)), (edge_is_bent, (2 * a, a + b, 2 * b))):
                start = apex[~fine & ~plain & rows]
                middle = start + 2 * outward
                for near, far in pairwise(path):
                    cones.append(_cone(level, start, middle, middle + near, middle + far))
        return np.concatenate(cones)

    def _edge_is_split(
        self, level: int, places: IntArray, outward: IntArray, sideward: IntArray
    ) -> BoolArray:
        """Whether a finer cell touches the edge between two faces; that beyond `outward` is not finer."""
        result: BoolArray = self._is_split(level, places + sideward)
        result |= self._is_split(level, places + sideward + outward)
        return result


def _cone(level: int, apex: IntArray, *base: IntArray) -> IntArray:
    """Tetrahedra from places in quarter cells."""
    return np.stack([_node(corner, level, quarters=True) for corner in (apex, *base)], axis=-1)


def _node(halves: IntArray, level: int, quarters: bool = False) -> IntArray:
    """Key of a node given in half or quarter cells of a level: its place in half cells of the finest."""
    shift = _FINEST - level
    # Quarter cells occur beside finer cells only, or are even.
    fine: IntArray = halves << shift
    return _key(fine >> 1 if quarters else fine)


def _key(places: IntArray) -> IntArray:
    """Pack places (…, 3) into one integer each."""
    result: IntArray = (places[..., 0] << 2 * _BITS) | (places[..., 1] << _BITS) | places[..., 2]
    return result


def _place(keys: IntArray) -> IntArray:
    """Unpack `_key`, shape (n, 3)."""
    mask = 2**_BITS - 1
    return np.stack([keys >> 2 * _BITS, keys >> _BITS & mask, keys & mask], axis=-1)


def _children(places: IntArray) -> IntArray:
    result: IntArray = (2 * places[:, None] + _CORNERS).reshape(-1, 3)
    return result


def distinct(keys: IntArray) -> IntArray:
    """Sort keys (n,) and drop repetitions: with integers several times as fast as `np.unique`."""
    ordered = np.sort(keys)
    first = np.ones(len(ordered), dtype=bool)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    return ordered[first]


def _contains(keys: IntArray, wanted: IntArray) -> BoolArray:
    """Which of the wanted keys are among sorted keys."""
    index = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    result: BoolArray = keys[index] == wanted
    return result


def _graded(split: list[IntArray]) -> tuple[IntArray, ...]:
    """Split whatever is needed so that all 26 neighbours of a split cell exist."""
    graded = [distinct(keys) for keys in split]
    for level in range(len(graded) - 1, 0, -1):
        around = (_place(graded[level])[:, None] + _AROUND).reshape(-1, 3)
        around = around[np.all((around >= 0) & (around < 2**level), axis=1)]
        graded[level - 1] = distinct(np.concatenate([graded[level - 1], _key(around >> 1)]))
    return tuple(graded)


@dataclass(frozen=True, eq=False)
class Crossing:
    """The boundary between chosen and other nodes of tetrahedra.

    Attributes:
        edges: Indices (chosen node, other node) of each edge that it crosses, shape (n, 2).
        faces: Triangles of crossings, counter-clockwise seen from the other nodes, shape (m, 3).
    """

    edges: IntArray
    faces: IntArray


def boundary(tetrahedra: IntArray, chosen: BoolArray) -> Crossing:
    """Separate chosen nodes from the others by a closed surface through the tetrahedra.

    Args:
        tetrahedra: Node indices of tetrahedra of positive volume that meet face to face, shape (n, 4).
        chosen: Whether a node is on the inner side, shape (k,).

    Source: Doi, Koide, "An efficient method of triangulating equi-valued surfaces by using tetrahedral
    cells", IEICE Trans. E74 (1991).
    """
    count = chosen[tetrahedra].sum(axis=1)
    mixed = tetrahedra[(count > 0) & (count < 4)]
    # An even permutation brings the chosen corners to the front.
    pattern = chosen[mixed] @ np.array([1, 2, 4, 8])
    mixed = np.take_along_axis(mixed, _EVEN_ORDER[pattern], axis=1)
    inner = chosen[mixed].sum(axis=1)
    a, b, c, d = mixed.T
    one, two, three = inner == 1, inner == 2, inner == 3
    corners = [
        _triangles([(a, b), (a, c), (a, d)], one),
        _triangles([(a, d), (b, d), (c, d)], three),
        _triangles([(a, c), (a, d), (b, d)], two),
        _triangles([(a, c), (b, d), (b, c)], two),
    ]
    pairs = np.concatenate(corners)
    keys = pairs[..., 0] * len(chosen) + pairs[..., 1]
    unique = distinct(keys.ravel())
    faces = np.searchsorted(unique, keys)
    return Crossing(np.stack(np.divmod(unique, len(chosen)), axis=-1), faces)


def _triangles(pairs: list[tuple[IntArray, IntArray]], rows: BoolArray) -> IntArray:
    """Triangles whose corners are edges (inner node, outer node), shape (n, 3, 2)."""
    return np.stack([np.stack([a[rows], b[rows]], axis=-1) for a, b in pairs], axis=1)


def _even_orders() -> IntArray:
    """For each pattern of chosen corners an even permutation that brings them to the front."""
    orders = np.zeros((16, 4), dtype=np.int64)
    for pattern in range(16):
        order = sorted(range(4), key=lambda corner: not pattern >> corner & 1)
        odd = sum(order[i] > order[j] for i in range(4) for j in range(i + 1, 4)) % 2
        inner = pattern.bit_count()
        if odd:
            # Two corners of the same side change places.
            i = 0 if inner >= 2 else 2
            order[i], order[i + 1] = order[i + 1], order[i]
        orders[pattern] = order
    return orders


_EVEN_ORDER = _even_orders()
