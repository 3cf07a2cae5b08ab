"""Hollow bodies: one description, evaluated by two kernels that share no code, B-rep and mesh."""

from gomboc_cad.solid.hollow.brep_kernel import brep, split_brep, void_properties
from gomboc_cad.solid.hollow.description import Cylinder, HollowBody
from gomboc_cad.solid.hollow.mesh_kernel import mesh, split_mesh
from gomboc_cad.solid.mesh import Mesh

__all__ = [
    "Cylinder",
    "HollowBody",
    "Mesh",
    "brep",
    "mesh",
    "split_brep",
    "split_mesh",
    "void_properties",
]
