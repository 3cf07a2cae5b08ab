"""All critical points of the floating energy, and how the passes join the poses: its Morse skeleton.

Every sample whose Newton step is no longer than the samples are apart starts a Newton run; the points found
have to satisfy S − H + U = 2 (Poincaré–Hopf). From each saddle two descents of the exact energy lead to the
minima that it joins: any descending path stays in one component of a sublevel set, so the tree of the
merging minima, and with it every barrier, is exact. Maxima are the minima of the energy upside down.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.equilibria.persistence import MergeTree, merge_tree
from gomboc_cad.equilibria.records import Kind
from gomboc_cad.hydrostatics.landscape import FloatingLandscape, Samples, kinds, newton_steps, refine

_NEAR = 1.5
"""Newton starts from samples whose first step is no longer than this many spacings."""

_MOST_STARTS = 2000
"""More are near a critical point only where the part floats neutrally."""

_SAME_POSE = 1e-5
_ARRIVED = 1e-3
_DESCENT_STEPS = 400
_LONGEST_STEP = 0.1


class CriticalPoints(NamedTuple):
    """Directions up of all floating poses, each of shape (k, 3)."""

    stable: Array
    saddle: Array
    unstable: Array

    def of(self, kind: Kind) -> Array:
        """Those of one kind."""
        result: Array = getattr(self, kind)
        return result

    @property
    def complete(self) -> bool:
        """Whether S − H + U = 2."""
        return len(self.stable) - len(self.saddle) + len(self.unstable) == 2


def critical_points(landscape: FloatingLandscape, samples: Samples, spacing: float) -> CriticalPoints | None:
    """Find every pose that Newton reaches from a sample near one; None if there are too many starts.

    Args:
        landscape: The landscape.
        samples: Its samples.
        spacing: Largest angle between neighbouring ones.
    """
    steps = np.linalg.norm(newton_steps(samples.jet), axis=1)
    starts = samples.ups[steps <= _NEAR * spacing]
    if not 0 < len(starts) <= _MOST_STARTS:
        return None
    ups, settled = refine(landscape, starts, spacing)
    found = _distinct(ups[settled])
    if not len(found):
        return None
    names = np.array(kinds(landscape.jet(found)))
    return CriticalPoints(*(found[names == kind] for kind in CriticalPoints._fields))


def _distinct(ups: Array) -> Array:
    """Keep the first of each group of directions that are the same pose."""
    kept = np.ones(len(ups), dtype=bool)
    if len(ups) > 1:
        kept[cKDTree(ups).query_pairs(_SAME_POSE, output_type="ndarray").max(axis=1)] = False
    result: Array = ups[kept]
    return result


def pose_tree(landscape: FloatingLandscape, points: CriticalPoints, kind: Kind) -> MergeTree | None:
    """Merge the minima (`stable`) or maxima (`unstable`) over the saddles.

    Nodes and edges are numbered as the points are.

    Returns:
        The tree, in heights upside down for maxima; None if a descent does not end at a known pose.
    """
    sign = -1.0 if kind == "unstable" else 1.0
    poses = points.of(kind)
    if not len(poses):
        return None
    floors = sign * landscape.jet(poses).height_mm
    jet = landscape.jet(points.saddle) if len(points.saddle) else None
    ends, passes = np.empty((0, 2), dtype=np.int64), np.empty(0)
    if jet is not None:
        _, axes = np.linalg.eigh(sign * jet.hessian_mm)
        across = np.einsum("ka,kax->kx", axes[:, :, 0], jet.immersion.frame)
        starts = np.stack([unit(points.saddle + side * _ARRIVED * across) for side in (1.0, -1.0)])
        bottoms = _descend(landscape, starts.reshape(-1, 3), sign)
        distance, pose = cKDTree(poses).query(bottoms)
        if np.any(distance > _ARRIVED):
            return None
        ends, passes = pose.reshape(2, -1).T.astype(np.int64), sign * jet.height_mm
    tree = merge_tree(floors, ends, passes, np.arange(len(floors)))
    return tree if np.isinf(tree.persistence).sum() == 1 else None


def _descend(landscape: FloatingLandscape, starts: Array, sign: float) -> Array:
    """Follow descending paths of the energy, or of its negative, to their ends, shape (k, 3)."""
    ups = starts.copy()
    reach = np.full(len(ups), _LONGEST_STEP)
    active = np.arange(len(ups))
    jet = landscape.jet(ups)
    for _ in range(_DESCENT_STEPS):
        values, vectors = np.linalg.eigh(sign * jet.hessian_mm)
        slopes = sign * np.einsum("kab,ka->kb", vectors, jet.gradient_mm)
        # Newton's step where the energy is convex; elsewhere still downhill.
        along = -slopes / np.maximum(np.abs(values), 1e-9 * np.abs(values).max(axis=1, keepdims=True))
        step = np.einsum("kab,kb->ka", vectors, along)
        length = np.linalg.norm(step, axis=1)
        going = (length > 0.1 * _ARRIVED) | (values[:, 0] < 0.0)
        active, step, length = active[going], step[going], length[going]
        jet = jet.rows(going)
        if not len(active):
            break
        step *= np.minimum(1.0, reach[active] / np.maximum(length, 1e-300))[:, None]
        there = unit(ups[active] + np.einsum("ka,kax->kx", step, jet.immersion.frame))
        fresh = landscape.jet(there, np.einsum("kx,kx->k", jet.immersion.flotation_mm, there))
        lower = sign * fresh.height_mm < sign * jet.height_mm
        ups[active[lower]] = there[lower]
        reach[active] = np.where(lower, np.minimum(2.0 * reach[active], _LONGEST_STEP), 0.25 * reach[active])
        jet = fresh if lower.all() else landscape.jet(ups[active])
    return ups
