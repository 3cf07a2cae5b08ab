"""Census of a body that is not convex: it rests on its convex hull, which is censused as a fine mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gomboc_cad.body.mass import mass_properties
from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.convexity import convexity
from gomboc_cad.equilibria.heights import BodyHeights
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import Census

_LEVELS = (6, 7)


def hull_census(body: Body, com: Sequence[float] | Array | None = None) -> Census:
    """Count the equilibria of the convex hull of a body, above the barrier that its mesh resolves.

    A mesh of 82,000 facets is taken, and one of 328,000 where that does not decide.

    Args:
        body: The body, dented or not.
        com: Centre of mass in mm, shape (3,); by default the homogeneous centroid of the body, not of its
            hull.

    Raises:
        CensusError: If the COM is not a finite point inside the hull.
    """
    mass = mass_properties(body)
    for level in _LEVELS:
        directions, faces = geodesic_triangulation(level)
        census = mesh_census(body.position_mm(directions), faces, mass.com_mm if com is None else com)
        if census.verdict != "undecided":
            break
    return replace(
        census,
        mass_properties=mass,
        convexity=convexity(body),
        height_at=BodyHeights(body, np.array(census.com_mm)),
    )
