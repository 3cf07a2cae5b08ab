"""From any product's spec to its design."""

from __future__ import annotations

from pathlib import Path

from gomboc_cad.products.buoy.recipe import design_buoy
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.common_spec import ProductSpec
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.imu_housing.recipe import design_imu_housing
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.seed_pod.recipe import design_seed_pod
from gomboc_cad.products.seed_pod.spec import SeedPodSpec
from gomboc_cad.progress import Progress, silent


def design_product(
    spec: ProductSpec, spec_folder: Path | None = None, progress: Progress = silent
) -> ProductDesign:
    """Make a product's parts and place its centre of mass.

    Args:
        spec: A checked spec of any product.
        spec_folder: Folder that the names of a user's own data files start from.
        progress: Called with the name of each stage as it begins.

    Raises:
        SpecError: If a name or a size in the spec is not available.
        GeometryError: If something does not fit, or the centre of mass cannot be brought to its target.
    """
    if isinstance(spec, ImuHousingSpec):
        return design_imu_housing(spec, spec_folder, progress)
    if isinstance(spec, SeedPodSpec):
        return design_seed_pod(spec, spec_folder, progress)
    if isinstance(spec, BuoySpec):
        return design_buoy(spec, spec_folder, progress)
    raise TypeError(f"There is no recipe for {type(spec).__name__}.")
