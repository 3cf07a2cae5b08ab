"""The bodies of the paper at its size, as it meshes them, and their censuses, each made once."""

from __future__ import annotations

from functools import lru_cache

from scipy.spatial import ConvexHull

from gomboc_cad.body import Body, make_body
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.equilibria import Census, convexity, hull_census, smooth_census
from gomboc_cad.equilibria.drainage import DrainageResult, drainage_count
from gomboc_cad.equilibria.drainage_shapes import PaperShape, TriangleMesh, paper_shape, ring_mesh
from gomboc_cad.paper.records import Evidence

RINGS, SEGMENTS = 101, 200
"""What the paper calls a 100 × 200 mesh."""

CONVEX_RATIO = 0.999
"""The paper takes a body for convex above this ratio of the volume of its mesh to that of its hull."""


def unit_body(name: str) -> Body:
    """A catalogue body with R₀ = 1, the paper's unit."""
    return named_body(name, diameter_mm=2.0)


def sloan2(beta: float) -> Body:
    """Sloan's second body with R₀ = 1."""
    return make_body("sloan2", beta, diameter_mm=2.0)


def body_mesh(body: Body, bands: int = RINGS - 1, segments: int = SEGMENTS) -> TriangleMesh:
    """A body as the paper meshes it: bands between parallels × meridians."""
    return ring_mesh(body.position_mm, bands + 1, segments)


@lru_cache(maxsize=8)
def named_mesh(name: str) -> TriangleMesh:
    """The mesh of a row: of the primary for `gomboc`, else of a simple solid."""
    if name == "gomboc":
        return body_mesh(unit_body("primary"))
    shape: PaperShape = name  # type: ignore[assignment]  # other names are refused
    return paper_shape(shape)


@lru_cache(maxsize=8)
def reading(name: str) -> DrainageResult:
    """What the paper's oracle reads off the mesh of a row."""
    return drainage_count(*named_mesh(name))


@lru_cache(maxsize=32)
def exact_census(body: Body) -> Census:
    """The smooth census of a strictly convex body, without margins; the census of its hull otherwise."""
    return smooth_census(body, margins=False) if convexity(body).strictly_convex else hull_census(body)


def census_evidence(census: Census) -> Evidence:
    """What a census of a body rests on."""
    return "smooth census" if census.mesh is None else "mesh census"


def spoken(name: str) -> str:
    """A key of the paper's tables as a word."""
    return "Gömböc" if name == "gomboc" else name.capitalize()


def volume_ratio(mesh: TriangleMesh) -> float:
    """Volume of a mesh over that of its convex hull, the paper's measure of convexity."""
    return mesh_mass(*mesh).volume_mm3 / float(ConvexHull(mesh.vertices).volume)


def convex_by_volume(body: Body) -> str:
    """What the paper's measure says of a body."""
    return yes(volume_ratio(body_mesh(body)) > CONVEX_RATIO)


def yes(flag: bool) -> str:
    """A truth value as the paper prints it."""
    return "yes" if flag else "no"
