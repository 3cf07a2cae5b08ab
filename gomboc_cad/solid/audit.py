"""A second opinion on meshes by PyMeshLab, which is under the GPL and therefore an extra."""

from __future__ import annotations

from types import ModuleType

from gomboc_cad.errors import GombocError
from gomboc_cad.solid.mesh import Mesh


def audit_mesh(mesh: Mesh) -> list[str]:
    """Look for non-manifold and open edges, non-manifold vertices and self-intersections.

    Returns:
        One clause for each kind of fault found, such as `has 2 boundary edges`.

    Raises:
        GombocError: If PyMeshLab is not installed.
    """
    pymeshlab = require_pymeshlab()
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(mesh.vertices_mm, mesh.faces))
    measures = meshes.get_topological_measures()
    meshes.compute_selection_by_self_intersections_per_face()
    counts = {
        "non-manifold edges": measures["non_two_manifold_edges"],
        "non-manifold vertices": measures["non_two_manifold_vertices"],
        "boundary edges": measures["boundary_edges"],
        "self-intersecting facets": meshes.current_mesh().selected_face_number(),
    }
    return [f"has {count} {what}" for what, count in counts.items() if count]


def require_pymeshlab() -> ModuleType:
    """Import PyMeshLab.

    Raises:
        GombocError: If it is not installed.
    """
    try:
        import pymeshlab
    except ImportError as error:
        raise GombocError(
            "The audit needs PyMeshLab; install it with: pip install 'gomboc-cad[audit]'."
        ) from error
    return pymeshlab
