"""The cells: tetrahedra that fill the cube without gaps, and closed boundaries of any set of nodes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.equilibria.octree import Octree, boundary
from tests.body.shapes import Array

CENTER = np.array([0.1, 0.2, 0.05])
RADIUS = 0.3


def shell(centers: Array, edge: float) -> Array:
    """Cells near a sphere, much finer near the plane x = 0."""
    near = np.abs(np.linalg.norm(centers - CENTER, axis=1) - RADIUS) < edge
    return near & (edge > 0.02 + 0.1 * np.abs(centers[:, 0]))


@pytest.fixture(scope="module")
def filled() -> tuple[Array, Array]:
    """Positions of the nodes, and the tetrahedra of a graded octree over the cube [−1, 1]³."""
    octree = Octree.refined(np.zeros(3), 2.0, 2, shell)
    nodes, index = np.unique(
        np.concatenate([octree.tetrahedra(level, places) for level, places in octree.leaves()]),
        return_inverse=True,
    )
    assert len({level for level, places in octree.leaves() if len(places)}) == 5
    return octree.node_positions_mm(nodes), index.reshape(-1, 4)


def test_tetrahedra_of_cells_of_different_size_fill_the_cube(filled: tuple[Array, Array]) -> None:
    positions, tetrahedra = filled
    volumes = np.linalg.det(positions[tetrahedra[:, 1:]] - positions[tetrahedra[:, :1]]) / 6.0
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(8.0, rel=1e-12)


def test_tetrahedra_share_whole_faces(filled: tuple[Array, Array]) -> None:
    positions, tetrahedra = filled
    faces = np.concatenate([np.delete(tetrahedra, k, axis=1) for k in range(4)])
    unique, shared = np.unique(np.sort(faces, axis=1), axis=0, return_counts=True)
    assert shared.max() == 2
    alone = np.abs(positions[unique[shared == 1]])
    assert np.all(np.any(np.all(alone == 1.0, axis=1), axis=1))


def test_the_boundary_of_a_ball(filled: tuple[Array, Array]) -> None:
    positions, tetrahedra = filled
    crossing = boundary(tetrahedra, np.linalg.norm(positions - CENTER, axis=1) < RADIUS)
    mesh = trimesh.Trimesh(positions[crossing.edges].mean(axis=1), crossing.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 2
    assert mesh.volume == pytest.approx(4.0 / 3.0 * np.pi * RADIUS**3, rel=0.01)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(0.02, 0.98))
def test_the_boundary_of_any_nodes_is_closed(filled: tuple[Array, Array], seed: int, share: float) -> None:
    positions, tetrahedra = filled
    chosen = np.random.default_rng(seed).random(len(positions)) < share
    chosen &= np.abs(positions).max(axis=1) < 1.0
    crossing = boundary(tetrahedra, chosen)
    mesh = trimesh.Trimesh(positions[crossing.edges].mean(axis=1), crossing.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert np.all(chosen[crossing.edges[:, 0]])
    assert not np.any(chosen[crossing.edges[:, 1]])
