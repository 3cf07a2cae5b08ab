"""Hand a solid over to CadQuery, drill it there, and take it back: nothing is converted, nothing is lost.

Needs the extra `cadquery`; see "CadQuery" in the user guide.

Run it with `python examples/to_cadquery.py`.
"""

from cadquery import Workplane

from gomboc_cad import catalog
from gomboc_cad.solid.exchange import from_cadquery, to_cadquery
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.patches import body_solid


def main() -> None:
    solid = body_solid(catalog()["primary"])
    there = to_cadquery(solid)
    print(f"CadQuery sees {there.solids().size()} solid with {there.faces().size()} faces.")

    back = from_cadquery(there)
    lost_mm3 = solid_mass(solid).volume_mm3 - solid_mass(back).volume_mm3
    print(f"Lost on the way there and back: {lost_mm3:g} mm³")

    drill = Workplane("XY").circle(4.0).extrude(60.0, both=True)
    drilled = from_cadquery(there.cut(drill))
    removed = solid_mass(solid).volume_mm3 - solid_mass(drilled).volume_mm3
    print(f"An 8 mm hole through the middle, drilled by CadQuery, took away {removed:.1f} mm³.")


if __name__ == "__main__":
    main()
