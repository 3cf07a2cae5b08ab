"""The JSON documents that scripts rely on; docs/user-guide.md lists their keys."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gomboc_cad.body import catalogue_entries
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria import Census, Convexity
from gomboc_cad.equilibria.records import Rest

if TYPE_CHECKING:
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


def not_convex_document(body: Body, curvature: Convexity, reason: str) -> dict[str, Any]:
    """Keys of `gomboc-cad census` for a body that has no smooth census: what cannot be known is null."""
    counts = ("stable", "unstable", "saddles", "equilibria", "rest")
    lengths = ("height_range_mm", "margin_mm", "s_margin_mm", "u_margin_mm")
    return {
        **_shape_document(body, curvature),
        **dict.fromkeys(counts + lengths),
        "verdict": "not convex",
        "reason": reason,
    }


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
