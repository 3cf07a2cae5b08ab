"""What a product's own spec says of the parts that are not exactly known."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gomboc_cad.products.batteries import load_battery
from gomboc_cad.products.buoy.contents import Contents
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.closures.spec import DowelsSpec, ThreadRingSpec
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.imu_housing.recipe import HousingDesign
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.seed_pod.contents import SEED, SUBSTRATE
from gomboc_cad.products.seed_pod.seeds import load_seed
from gomboc_cad.products.seed_pod.spec import SeedPodSpec


def uncertain_loads(design: ProductDesign, spec_folder: Path | None = None) -> tuple[UncertainLoad, ...]:
    """Contents of a product with their tolerances of mass and place.

    Args:
        design: The product.
        spec_folder: Folder that the names of a user's own data files start from.
    """
    spec = design.spec
    if isinstance(design, HousingDesign):
        return design.mounted.loads
    if isinstance(spec, BuoySpec):
        bought = tuple(part for part in design.assembly.parts if not part.made)
        return Contents(bought, ()).loads(spec, load_battery(spec.battery.type, spec_folder))
    if isinstance(spec, SeedPodSpec):
        return _pod_loads(design, spec, spec_folder)
    return ()


def com_error_mm(design: ProductDesign) -> float:
    """What the spec allows the centre of mass to be off along each axis besides; 0 if it says nothing."""
    spec = design.spec
    return 1e-3 * spec.tolerances.com_error_um if isinstance(spec, ImuHousingSpec) else 0.0


def is_glued(design: ProductDesign) -> bool:
    """Whether there is glue along the seam."""
    return isinstance(getattr(design.spec, "closure", None), DowelsSpec | ThreadRingSpec)


def _pod_loads(
    design: ProductDesign, spec: SeedPodSpec, spec_folder: Path | None
) -> tuple[UncertainLoad, ...]:
    """Seed and filling; a filling of less than all of the room settles to one side or another."""
    seed = load_seed(spec.seed.species, spec_folder)
    kernel = UncertainLoad(SEED, seed.mass_scatter_g, spec.seed.play_mm)
    filling = next((part for part in design.assembly.parts if part.name == SUBSTRATE), None)
    if filling is None:
        return (kernel,)
    settled_mm = 0.0
    if spec.substrate.fill < 1.0:
        settling = design.uncertainties[-1].com_error_mm
        settled_mm = float(np.linalg.norm(settling)) * design.assembly.mass_g / filling.mass_g
    return kernel, UncertainLoad(SUBSTRATE, spec.substrate.mass_scatter * filling.mass_g, settled_mm)
