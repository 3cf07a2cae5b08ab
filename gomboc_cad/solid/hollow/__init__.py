"""Hollow bodies: one description, evaluated by two kernels that share no code, B-rep and mesh."""

from gomboc_cad.solid.hollow.brep_kernel import brep, split_brep, void_properties
from gomboc_cad.solid.hollow.description import HollowBody
from gomboc_cad.solid.hollow.mesh_kernel import mesh, split_mesh
from gomboc_cad.solid.hollow.plug import plug_brep, plug_mesh
from gomboc_cad.solid.hollow.seam import Seam
from gomboc_cad.solid.hollow.tools import Box, Cylinder, Ellipsoid, Tool
from gomboc_cad.solid.mesh import Mesh

__all__ = [
    "Box",
    "Cylinder",
    "Ellipsoid",
    "HollowBody",
    "Mesh",
    "Seam",
    "Tool",
    "brep",
    "mesh",
    "plug_brep",
    "plug_mesh",
    "split_brep",
    "split_mesh",
    "void_properties",
]
