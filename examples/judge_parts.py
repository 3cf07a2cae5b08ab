"""A mesh judged by its barriers, a body proven, and its proof checked again.

Run it with `python examples/judge_parts.py`.
"""

from gomboc_cad import catalog
from gomboc_cad.body.catalogue import exact_parameters
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import mesh_census
from gomboc_cad.equilibria.certificate import certify, verify


def main() -> None:
    # Any triangles will do: here two bodies of the catalogue with 82,000 facets each.
    directions, faces = geodesic_triangulation(6)
    for name in ("primary", "second"):
        census = mesh_census(catalog()[name].position_mm(directions), faces)
        print(
            f"{name}: {census.verdict}; {census.mesh.raw_stable} stable facets before barriers are asked for"
        )
        for pose in census.equilibria:
            if pose.kind == "stable":
                print(f"  a rest, left by raising the centre of mass by {1e3 * pose.barrier_mm:.1f} µm")

    certificate = certify(exact_parameters("primary"))
    print(certificate.reason)
    print("Checked again:", "accepted" if verify(certificate).accepted else "rejected")


if __name__ == "__main__":
    main()
