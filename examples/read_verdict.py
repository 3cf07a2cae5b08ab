"""Read the verdict of a build: what a script needs to decide whether to machine the part.

Run it with `python examples/read_verdict.py demo-housing/`.
"""

import json
import sys
from pathlib import Path


def main(folder: Path) -> None:
    verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    print(f"{verdict['product']}: {verdict['verdict']}")
    for reason in verdict["reasons"]:
        print(f"  {reason}")
    soft, _ = verdict["rest"]["tilt_deg_per_um"]
    wanted_deg = 1.0
    needed_um = wanted_deg / soft
    print(f"To rest within {wanted_deg:g}°, its centre of mass may be off by {needed_um:.2g} µm at most.")
    for item in verdict["sensitivities"]:
        print(f"  {item['source']}: {item['com_error_um']:.3g} µm, {item['tilt_deg']:.2g}°")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "demo-housing"))
