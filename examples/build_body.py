"""A bare body: its census, then STEP, STL and 3MF files that were read back and checked.

Run it with `python examples/build_body.py out-body/`.
"""

import sys
from pathlib import Path

from gomboc_cad import catalog
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.products.bare_body import write_body


def main(folder: Path) -> None:
    body = catalog()["primary"].with_diameter(60.0)
    census = smooth_census(body)
    counts = f"{census.stable} stable, {census.unstable} unstable"
    print(f"{body.name}: {counts}, S-margin {census.margin.s_margin_mm:.3f} mm")

    written = write_body(body, folder, ("step", "stl", "3mf"), sag_um=20.0)
    print(f"Largest deviation of the STEP file from the mathematics: {written['max_deviation_um']:.3f} µm")
    for file in written["files"]:
        print(f"  {file['path']}: {'in order' if file['ok'] else file['problems']}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out-body"))
