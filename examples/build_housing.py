"""A housing from a spec: the template with another size and material, built and rechecked.

Run it with `python examples/build_housing.py out-housing/`.
"""

import sys
from pathlib import Path

from gomboc_cad.products.build import build_product


def main(folder: Path) -> None:
    # A mesh this fine is enough for a printer, and quicker to make and to read back.
    changes = ["body.diameter_mm=80", "shell.material=PA12", "mesh.sag_um=50", "mark.text="]
    built = build_product(
        "imu-housing", folder, changes=changes, progress=lambda stage: print(f"... {stage}")
    )

    assembly = built["assembly"]
    print(f"{built['verdict']}: {assembly['mass_g']:.1f} g, S-margin {built['s_margin_mm']:.3f} mm")
    print(f"The centre of mass is {assembly['com_residual_um']:.4f} µm from its target.")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out-housing"))
