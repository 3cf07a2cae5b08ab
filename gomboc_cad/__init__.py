"""gomboc-cad: bodies that right themselves, made real.

Verified parameters of mono-monostatic bodies become watertight solids with cavities, mounts and
closures, and every solid is rechecked by an equilibrium oracle.
"""

from gomboc_cad.body import Body, catalog
from gomboc_cad.errors import GombocError

__version__ = "0.1.0"

__all__ = ["Body", "GombocError", "__version__", "catalog"]
