"""Pure mathematics of the outer shape: families, surface derivatives, mass integrals, catalogue."""

from gomboc_cad.body.catalogue import CatalogueEntry, Evidence, catalog, catalogue_entries, make_body
from gomboc_cad.body.families import FourierSloan, Harmonic, ShapeFunction, Sloan1
from gomboc_cad.body.mass import MassProperties, mass_properties
from gomboc_cad.body.support import SupportJet, depth_mm, support_height_mm, support_jet
from gomboc_cad.body.surface import Body, RadialJet, SurfacePoints

__all__ = [
    "Body",
    "CatalogueEntry",
    "Evidence",
    "FourierSloan",
    "Harmonic",
    "MassProperties",
    "RadialJet",
    "ShapeFunction",
    "Sloan1",
    "SupportJet",
    "SurfacePoints",
    "catalog",
    "catalogue_entries",
    "depth_mm",
    "make_body",
    "mass_properties",
    "support_height_mm",
    "support_jet",
]
