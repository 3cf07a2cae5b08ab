"""Ballast as the paper has it: the COM is moved by the part w of the way to the lowest vertex."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, get_args

import numpy as np

from gomboc_cad.body import mass_properties
from gomboc_cad.body.catalogue import catalogue_entries, named_body
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.equilibria import mesh_census
from gomboc_cad.equilibria.ballast import BallastShape, ballast_subject, rest_changes
from gomboc_cad.equilibria.drainage import drainage_count
from gomboc_cad.paper.bodies import spoken
from gomboc_cad.paper.published import published
from gomboc_cad.paper.records import Row, Table, judged
from gomboc_cad.paper.truths import true_rests
from gomboc_cad.progress import Progress

SHAPES: tuple[BallastShape, ...] = get_args(BallastShape)
FRACTIONS = tuple(round(0.01 * step, 2) for step in range(31))
"""Ballast fractions w, as far as the paper goes."""

_BALL = 4.0 * np.pi / 3.0


@dataclass(frozen=True)
class BallastSeries:
    """A body against ballast.

    Attributes:
        name: The body.
        fractions: Ballast fractions w.
        ecs: What the paper's oracle counts.
        boa: What it gives for the share of the largest basin.
        rests: True number of stable rests, a ring or sphere of neutral ones being one.
    """

    name: BallastShape
    fractions: tuple[float, ...]
    ecs: tuple[int, ...]
    boa: tuple[float, ...]
    rests: tuple[int, ...]

    @property
    def first_one(self) -> float | None:
        """Smallest fraction at which the oracle counts one."""
        return next((w for w, count in zip(self.fractions, self.ecs, strict=True) if count == 1), None)


@lru_cache(maxsize=len(SHAPES))
def ballast_series(name: BallastShape) -> BallastSeries:
    """Count a body at every fraction, by the oracle and truly."""
    subject = ballast_subject(name)
    # The paper starts from the centroid of the mesh.
    centroid, lowest = np.array(mesh_mass(*subject.mesh).com_mm), np.array(subject.lowest_mm)
    found = [drainage_count(*subject.mesh, (1.0 - w) * centroid + w * lowest) for w in FRACTIONS]
    return BallastSeries(
        name,
        FRACTIONS,
        tuple(result.ecs for result in found),
        tuple(result.boa for result in found),
        tuple(len(subject.rests(subject.com_mm(w))) for w in FRACTIONS),
    )


def ballast(progress: Progress) -> Table:
    """Count without ballast, least ballast for one rest, and what the paper concludes."""
    figures = published()["ballast"]
    rows: list[Row] = []
    for name in SHAPES:
        progress(f"ballast: {name}")
        series = ballast_series(name)
        rows += [_bare(series, figures["ecs_at_0"][name]), _least_ballast(series, figures["min_w"].get(name))]
    progress("ballast: the Gömböc at every level")
    rows += [_at_all_levels(), _what_persists(), _falling_basin()]
    progress("ballast: the catalogue")
    return Table(
        "ballast",
        "Geometry against ballast",
        (
            "COM at (1 − w) centroid + w lowest vertex, w from 0 to 0.30 in steps of 0.01. The lowest "
            "vertex is taken along z in the frame of each mesh, since the paper does not say.",
            "A sphere with the part w of its mass moved from the centre to the surface has the S-margin w "
            f"R. What a homogeneous body of the catalogue is worth in such ballast: {_equivalents()}.",
        ),
        tuple(rows),
    )


def _equivalents() -> str:
    """S-margin of each catalogue body over the radius of the sphere of its volume."""
    worth = []
    for name, entry in catalogue_entries().items():
        if entry.evidence.s_margin is not None:
            volume = mass_properties(named_body(name, diameter_mm=2.0)).volume_mm3
            worth.append(f"{name} {100.0 * entry.evidence.s_margin / (volume / _BALL) ** (1.0 / 3.0):.2f} %")
    return ", ".join(worth)


def _bare(series: BallastSeries, paper: int) -> Row:
    truth = true_rests(series.name, paper)
    return judged(
        f"{spoken(series.name)}: ECS at w = 0",
        paper,
        series.ecs[0],
        truth.shown,
        truth.evidence,
        "As in the tables above.",
        refuted=truth.refutes,
    )


class _Least(NamedTuple):
    """What is true of the least ballast for one rest, in closed form for the bodies of `drainage_shapes`."""

    fraction: float | str
    refuted: bool
    why: str


_LEAST = {
    "gomboc": _Least(0.0, False, "It has one stable rest without ballast."),
    "sphere": _Least(
        "any w > 0",
        True,
        "A sphere with its COM lowered by s has one stable rest for every s > 0, of stiffness s; what a "
        "count needs depends on the facets, and here it is 1 %.",
    ),
    "ellipsoid": _Least(
        (1.0 / 0.7) ** 2 - 1.0,
        True,
        "The COM would have to be lowered by b²/c − c, to beyond the surface, so it has two rests at every "
        "w; the oracle reads 2 too as soon as ballast makes them unequal.",
    ),
    "capsule": _Least(
        5.0 / 7.0,
        True,
        "Ballast along the axis leaves the ring of neutral poses until the COM is in the cap, at w = 5/7.",
    ),
    "cylinder": _Least(
        "never",
        False,
        "Right, and for every place of the ballast: the foot of the COM is inside both ends wherever the "
        "COM is.",
    ),
    "cube": _Least(
        "never",
        False,
        "Right, and for every place of the ballast: the foot of the COM is inside all six faces wherever it "
        "is.",
    ),
}


def _least_ballast(series: BallastSeries, paper: float | None) -> Row:
    known = _LEAST[series.name]
    return judged(
        f"{spoken(series.name)}: least w for ECS = 1",
        "never" if paper is None else paper,
        "never" if series.first_one is None else series.first_one,
        known.fraction,
        true_rests(series.name, 1).evidence,
        known.why,
        refuted=known.refuted,
        digits=2,
    )


def _at_all_levels() -> Row:
    changes = rest_changes(ballast_subject("gomboc"), FRACTIONS[0], FRACTIONS[-1], accuracy=1e-5)
    series = ballast_series("gomboc")
    misread = [w for w, count in zip(series.fractions, series.ecs, strict=True) if count > 1]
    return judged(
        "Gömböc: ballast levels up to 0.30 with more than one rest",
        "none",
        ", ".join(f"{w:g}" for w in misread) or "none",
        " to ".join(f"{change.fraction:.4f}" for change in changes) or "none",
        "smooth census",
        "The COM leaves the loading zone on its way and enters it again; in the window the body has two "
        "rests.",
        refuted=bool(changes),
    )


def _what_persists() -> Row:
    return judged(
        "Cylinder: what ballast cannot remove",
        "the ring of its side",
        None,
        "its two ends",
        "closed form",
        "With the COM at the rim's side of the axis the ring breaks into one rest at once; with the COM on "
        "the axis it stays: either way the flat ends are what no ballast removes.",
        refuted=True,
    )


def _falling_basin() -> Row:
    """The share of the side of the cylinder, read and true, at the highest level."""
    subject = ballast_subject("cylinder")
    census = mesh_census(*subject.mesh, subject.com_mm(FRACTIONS[-1]))
    read = ballast_series("cylinder").boa
    return judged(
        "Cylinder: BOA at w = 0.30",
        "falls, as the ring fragments",
        read[-1],
        max(pose.probability or 0.0 for pose in census.equilibria if pose.kind == "stable"),
        "mesh census",
        f"The oracle's share falls from {read[0]:.3f}, because it counts facets of the side as rests; the "
        "ring does not fragment but becomes one rest, with nearly the same share.",
        refuted=True,
    )
