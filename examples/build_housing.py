"""A housing from a spec: the template with another size and material, built and rechecked.

Run it with `python examples/build_housing.py out-housing/`.
"""

import sys
import tempfile
from pathlib import Path

from gomboc_cad.products.build import build_product
from gomboc_cad.resources import template_folder


def main(folder: Path) -> None:
    spec = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")
    spec = spec.replace("diameter_mm = 100.0", "diameter_mm = 80.0")
    spec = spec.replace('material = "PLA"', 'material = "PA12"')
    # A mesh this fine is enough for a printer, and quicker to make and to read back.
    spec = spec.replace("sag_um = 10.0", "sag_um = 50.0")
    with tempfile.TemporaryDirectory() as scratch:
        mine = Path(scratch) / "my-housing.toml"
        mine.write_text(spec, encoding="utf-8")
        built = build_product(str(mine), folder, progress=lambda stage: print(f"... {stage}"))

    assembly = built["assembly"]
    print(f"{built['verdict']}: {assembly['mass_g']:.1f} g, S-margin {built['s_margin_mm']:.3f} mm")
    print(f"The centre of mass is {assembly['com_residual_um']:.4f} µm from its target.")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out-housing"))
