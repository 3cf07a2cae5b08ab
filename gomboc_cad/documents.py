"""The JSON documents that scripts rely on; docs/user-guide.md lists their keys."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gomboc_cad.body import catalogue_entries
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria import Census, Convexity, MeshEvidence
from gomboc_cad.equilibria.records import Rest

if TYPE_CHECKING:
    from pathlib import Path

    from gomboc_cad.equilibria.certificate import Certificate, Verification
    from gomboc_cad.equilibria.drill_map import DrillLimits, DrillMap
    from gomboc_cad.equilibria.zone import LoadingZone
    from gomboc_cad.search import Design
    from gomboc_cad.solid.check import PartCheck
    from gomboc_cad.solid.inspect import FileInspection


def catalog_document() -> dict[str, Any]:
    """Keys of `gomboc-cad catalog`."""
    bodies = [
        {
            "name": name,
            "family": entry.body.shape.family,
            "beta": entry.beta,
            "coefficients": dict(entry.coefficients),
            "status": entry.status,
            "reason": entry.reason,
            "source": entry.source,
            "s_margin": entry.evidence.s_margin,
            "u_margin": entry.evidence.u_margin,
            "min_curvature": entry.evidence.min_curvature,
        }
        for name, entry in catalogue_entries().items()
    ]
    return {"bodies": bodies}


def rest_document(rest: Rest) -> dict[str, Any]:
    """The key `rest` of census and build."""
    return {
        "direction": list(rest.direction),
        "height_mm": rest.height_mm,
        "stiffness_mm": list(rest.stiffness_mm),
        "stiffness_matrix_mm": [list(row) for row in rest.stiffness_matrix_mm],
        "tilt_deg_per_um": list(rest.tilt_deg_per_um),
        "soft_direction": list(rest.soft_direction),
        "stiff_direction": list(rest.stiff_direction),
        "tilt_matrix_deg_per_um": [list(row) for row in rest.tilt_matrix_deg_per_um],
    }


def census_verdict(census: Census) -> str:
    """One word for the counts."""
    if census.stable != 1:
        return "multistable"
    return "mono-monostatic" if census.unstable == 1 else "monostable"


def census_document(body: Body, census: Census) -> dict[str, Any]:
    """Keys of `gomboc-cad census`."""
    mass, margin, curvature = census.mass_properties, census.margin, census.convexity
    if mass is None or margin is None or curvature is None:
        raise TypeError("This document is for the census of a smooth body.")
    return {
        **_shape_document(body, curvature),
        "stable": census.stable,
        "unstable": census.unstable,
        "saddles": census.saddles,
        "volume_mm3": mass.volume_mm3,
        "centroid_mm": list(mass.com_mm),
        "com_mm": list(census.com_mm),
        "height_range_mm": census.height_range_mm,
        "margin_mm": margin.margin_mm,
        "s_margin_mm": margin.s_margin_mm,
        "u_margin_mm": margin.u_margin_mm,
        "rest": rest_document(census.rest),
        "equilibria": [
            {
                "kind": equilibrium.kind,
                "direction": list(equilibrium.direction),
                "height_mm": equilibrium.height_mm,
                "stiffness_mm": list(equilibrium.stiffness_mm or ()),
            }
            for equilibrium in census.equilibria
        ],
        "verdict": census_verdict(census),
    }


def hull_census_document(body: Body, census: Census) -> dict[str, Any]:
    """Keys of `gomboc-cad census` for a body that is not convex; what only a smooth census knows is null."""
    mass, curvature, mesh = census.mass_properties, census.convexity, census.mesh
    if mass is None or curvature is None or mesh is None:
        raise TypeError("This document is for the census of the hull of a body.")
    return {
        **_shape_document(body, curvature),
        "stable": census.stable,
        "unstable": census.unstable,
        "saddles": census.saddles,
        "raw": raw_document(mesh),
        "barrier_um": 1e3 * mesh.barrier_mm,
        "volume_mm3": mass.volume_mm3,
        "centroid_mm": list(mass.com_mm),
        "com_mm": list(census.com_mm),
        "height_range_mm": census.height_range_mm,
        **dict.fromkeys(("margin_mm", "s_margin_mm", "u_margin_mm")),
        "rest": {
            "direction": list(census.rest.direction),
            "height_mm": census.rest.height_mm,
            **dict.fromkeys(("stiffness_mm", "tilt_deg_per_um")),
        },
        "equilibria": [
            {
                "kind": equilibrium.kind,
                "direction": list(equilibrium.direction),
                "height_mm": equilibrium.height_mm,
                "barrier_um": _um(equilibrium.barrier_mm),
                "probability": equilibrium.probability,
            }
            for equilibrium in census.equilibria
        ],
        "verdict": census.verdict,
        "reason": (
            "Not strictly convex (principal curvature down to "
            f"{curvature.min_curvature_per_mm:.4g} per mm), so the body rests on its convex hull. "
            f"{census.reason}"
        ),
    }


def raw_document(mesh: MeshEvidence) -> dict[str, int]:
    """The key `raw`: equilibria of the polyhedron, however low their barriers."""
    return {"stable": mesh.raw_stable, "unstable": mesh.raw_unstable, "saddles": mesh.raw_saddles}


def check_document(found: PartCheck) -> dict[str, Any]:
    """Keys of `gomboc-cad check`."""
    census, mesh = found.census, found.census.mesh
    if mesh is None:
        raise TypeError("This document is for the census of a mesh.")
    return {
        "file": found.file,
        "kind": found.kind,
        "unit": found.unit,
        "watertight": found.watertight,
        "volume_mm3": found.volume_mm3,
        "com_mm": list(found.com_mm),
        "com_given": found.com_given,
        "centroid_mm": None if found.centroid_mm is None else list(found.centroid_mm),
        "size_mm": list(found.size_mm),
        "facets": found.facets,
        "hull_facets": mesh.facets,
        "raw": raw_document(mesh),
        "neutral": mesh.neutral,
        "sag_um": 1e3 * mesh.sag_mm,
        "barrier_um": 1e3 * mesh.barrier_mm,
        "lowest_counted_um": _um(mesh.lowest_counted_mm),
        "highest_uncounted_um": _um(mesh.highest_uncounted_mm),
        "uncounted_directions": [list(direction) for direction in mesh.uncounted_directions],
        "stable": census.stable,
        "unstable": census.unstable,
        "saddles": census.saddles,
        "height_range_mm": census.height_range_mm,
        "poses": [
            {
                "direction": list(pose.direction),
                "height_mm": pose.height_mm,
                "barrier_um": _um(pose.barrier_mm),
                "probability": pose.probability,
                "probability_error": pose.probability_error,
                "extent": pose.extent,
            }
            for pose in census.equilibria
            if pose.kind == "stable"
        ],
        "verdict": census.verdict,
        "reasons": [census.reason, *found.repairs, *found.notes],
    }


def certificate_document(made: Certificate, file: Path | None, seconds: float) -> dict[str, Any]:
    """Keys of `gomboc-cad certify`; lengths in units of the nominal radius R₀."""
    parameters = made.parameters
    return {
        "family": parameters.family,
        "beta": parameters.beta,
        "coefficients": dict(parameters.coefficients),
        "file": None if file is None else str(file),
        "status": made.status,
        "strictly_convex": made.strictly_convex,
        "stable": made.stable,
        "unstable": made.unstable,
        "com": None if made.com is None else list(made.com),
        "com_enclosure": [list(interval) for interval in made.com_enclosure],
        "volume_enclosure": list(made.volume_enclosure),
        "curvature_above": made.convexity.curvature_above if made.convexity else None,
        "com_margin": made.margin.com_margin if made.margin else None,
        "seconds": seconds,
        "reason": made.reason,
    }


def verification_document(read: Certificate, checked: Verification, seconds: float) -> dict[str, Any]:
    """Keys of `gomboc-cad certify --verify`; of a certificate that is rejected no claim is repeated."""
    document = certificate_document(read, None, seconds)
    if not checked.accepted:
        known = {"family", "beta", "coefficients", "seconds"}
        document = {key: value if key in known else None for key, value in document.items()}
        document["status"] = "undecided"
    return {**document, "accepted": checked.accepted, "reason": checked.reason}


def design_document(made: Design, file: Path, seconds: float) -> dict[str, Any]:
    """Keys of `gomboc-cad design`; lengths in units of the nominal radius R₀."""
    certificate, figures = made.certificate, made.figures
    return {
        "family": certificate.parameters.family,
        "beta": certificate.parameters.beta,
        "coefficients": dict(certificate.parameters.coefficients),
        "goal": {
            "objective": made.goal.objective,
            "min_curvature": made.goal.min_curvature,
            "min_margin": made.goal.min_margin,
        },
        "file": str(file),
        "status": certificate.status,
        "stable": made.census.stable,
        "unstable": made.census.unstable,
        "s_margin": figures.s_margin,
        "u_margin": figures.u_margin,
        "min_curvature": figures.min_curvature,
        "height_range": figures.height_range,
        "stiffness": figures.stiffness,
        "curvature_above": certificate.convexity.curvature_above if certificate.convexity else None,
        "com_margin": certificate.margin.com_margin if certificate.margin else None,
        "seconds": seconds,
        "verdict": "PASS" if made.accepted else "FAIL",
        "reasons": list(made.reasons),
    }


def zone_document(zone: LoadingZone, files: tuple[Path, ...]) -> dict[str, Any]:
    """Keys of `gomboc-cad zone`."""
    return {
        "body": zone.body.name,
        "diameter_mm": zone.body.diameter_mm,
        "com_mm": list(zone.com_mm),
        "s_margin_mm": zone.s_margin_mm,
        # A sphere whose centre of mass is lowered by s has the margin s.
        "equivalent_ballast_mm": zone.s_margin_mm,
        "nearest_best_com_mm": list(zone.nearest_best_com_mm),
        "nearest_best_s_margin_mm": zone.nearest_best_s_margin_mm,
        "best_com_mm": list(zone.best_com_mm),
        "best_s_margin_mm": zone.best_s_margin_mm,
        "zone_volume_mm3": zone.volume_mm3,
        "facets": len(zone.faces),
        "files": [str(file) for file in files],
    }


def drill_document(drilling: DrillMap, files: tuple[Path, ...]) -> dict[str, Any]:
    """Keys of `gomboc-cad drillmap`."""
    return {
        "body": drilling.body.name,
        "diameter_mm": drilling.body.diameter_mm,
        "com_mm": list(drilling.com_mm),
        "rest_direction": list(drilling.rest.direction),
        "max_radius_mm": drilling.max_radius_mm,
        "max_direction": list(drilling.max_direction),
        "best": _drill_sites(drilling.best),
        "sites": _drill_sites(drilling.sites),
        "facets": _facets(drilling.sites),
        "files": [str(file) for file in files],
    }


def _drill_sites(limits: DrillLimits) -> list[dict[str, Any]]:
    return [
        {
            "direction": direction,
            "position_mm": position,
            "radius_mm": radius,
            "refined_radius_mm": refined,
            "flat_depth_mm": depth,
        }
        for direction, position, radius, refined, depth in zip(
            limits.directions.tolist(),
            limits.positions_mm.tolist(),
            limits.radius_mm.tolist(),
            limits.refined_radius_mm.tolist(),
            limits.flat_depth_mm.tolist(),
            strict=True,
        )
    ]


def _facets(limits: DrillLimits) -> list[list[int]]:
    """Triangles between the sites, as indices into them; they lie on a convex surface."""
    from scipy.spatial import ConvexHull

    corners_of_a_solid = 4
    if len(limits.positions_mm) < corners_of_a_solid:
        return []
    facets: list[list[int]] = ConvexHull(limits.positions_mm).simplices.tolist()
    return facets


def _um(length_mm: float | None) -> float | None:
    return None if length_mm is None else 1e3 * length_mm


def _shape_document(body: Body, curvature: Convexity) -> dict[str, Any]:
    return {
        "body": body.name,
        "family": body.shape.family,
        "diameter_mm": body.diameter_mm,
        "strictly_convex": curvature.strictly_convex,
        "min_curvature_per_mm": curvature.min_curvature_per_mm,
        "min_gaussian_curvature_per_mm2": curvature.min_gaussian_curvature_per_mm2,
        "min_radius_of_curvature_mm": curvature.min_radius_of_curvature_mm,
    }


def file_document(file: FileInspection) -> dict[str, Any]:
    """An entry of the key `files`: a file of the output folder, and what was found when it was read back."""
    return {
        "path": file.name,
        "kind": file.kind,
        "sha256": file.sha256,
        "size_bytes": file.size_bytes,
        "ok": file.ok,
        "problems": list(file.problems),
        "max_distance_um": max(
            (p.distance_um for p in file.parts if p.distance_um is not None), default=None
        ),
    }
