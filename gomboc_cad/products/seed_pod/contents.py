"""What is in a seed pod, and how far it may be off: the seed and the substrate around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from build123d import Shape, Solid
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from scipy.stats import qmc

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.products.assembly import Assembly, Part
from gomboc_cad.products.design import Uncertainty
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.materials import Material, load_material
from gomboc_cad.products.seed_pod.layout import PodLayout
from gomboc_cad.products.seed_pod.seeds import Seed
from gomboc_cad.products.seed_pod.spec import SeedPodSpec
from gomboc_cad.solid.hollow.brep_tools import boolean, tool_shape
from gomboc_cad.solid.mass import solid_mass

SEED, SUBSTRATE = "seed", "substrate"

_SEED_COLOR, _SUBSTRATE_COLOR = (0.55, 0.37, 0.20), (0.30, 0.22, 0.16)
_SAMPLES_LOG2 = 14


@dataclass(frozen=True)
class Contents:
    """Seed and substrate where the unmoved core has them.

    Attributes:
        seed: The seed.
        substrate: The substrate, None if there is none.
    """

    seed: Part
    substrate: Part | None

    @property
    def parts(self) -> tuple[Part, ...]:
        """Both, or the seed alone."""
        return (self.seed,) if self.substrate is None else (self.seed, self.substrate)

    @property
    def mass_g(self) -> float:
        """Their mass together."""
        return sum(part.mass_g for part in self.parts)


def substrate_of(spec: SeedPodSpec) -> Material | None:
    """The substrate with the density that it is packed to; None if there is none.

    Raises:
        SpecError: If there is no such material.
    """
    if not spec.substrate.used:
        return None
    material = load_material(spec.substrate.material)
    if spec.substrate.density_g_cm3 is None:
        return material
    return material.model_copy(update={"density_g_cm3": spec.substrate.density_g_cm3})


def contents_of(spec: SeedPodSpec, layout: PodLayout, seed: Seed, substrate: Material | None) -> Contents:
    """Make the solids of seed and substrate.

    Args:
        spec: What is asked for.
        layout: Where they go.
        seed: The seed.
        substrate: The substrate as it is packed, None if there is none.
    """
    kernel = Solid(tool_shape(layout.seed))
    seed_part = Part(
        SEED,
        seed.name,
        seed.mass_g,
        layout.seed.center_mm,
        kernel,
        solid_mass(kernel),
        False,
        "natural",
        _SEED_COLOR,
    )
    if substrate is None:
        return Contents(seed_part, None)
    filling = _filling(layout, kernel)
    measured = solid_mass(filling)
    substrate_part = Part(
        SUBSTRATE,
        substrate.name,
        spec.substrate.fill * substrate.mass_g(measured.volume_mm3),
        measured.com_mm,
        filling,
        measured,
        False,
        f"{100.0 * spec.substrate.fill:.0f} % filled",
        _SUBSTRATE_COLOR,
    )
    return Contents(seed_part, substrate_part)


def loads_of(
    spec: SeedPodSpec, layout: PodLayout, seed: Seed, assembly: Assembly
) -> tuple[UncertainLoad, ...]:
    """Seed and filling with their tolerances; a filling of less than all of the room settles to one side.

    Args:
        spec: What is asked for.
        layout: Where things are.
        seed: The seed.
        assembly: The finished pod.
    """
    kernel = UncertainLoad(SEED, seed.mass_scatter_g, spec.seed.play_mm)
    filling = next((part for part in assembly.parts if part.name == SUBSTRATE), None)
    if filling is None:
        return (kernel,)
    settled_mm = loose_shift_mm(layout, spec.substrate.fill) if spec.substrate.fill < 1.0 else 0.0
    return kernel, UncertainLoad(SUBSTRATE, spec.substrate.mass_scatter * filling.mass_g, settled_mm)


def uncertainties_of(
    spec: SeedPodSpec, layout: PodLayout, loads: Sequence[UncertainLoad], assembly: Assembly
) -> tuple[Uncertainty, ...]:
    """What moves the centre of mass of a pod from one to the next.

    Args:
        spec: What is asked for.
        layout: Where things are.
        loads: What `loads_of` gives: the seed, and the filling if there is one.
        assembly: The finished pod.
    """
    soft = np.array(layout.rest.soft_direction)
    by_mass = [as_vector(load.com_error_by_mass_mm(assembly)) for load in loads]
    by_place = [as_vector(load.com_error_by_place_mm(assembly) * soft) for load in loads]
    found = [
        Uncertainty(
            f"a seed that is {loads[0].mass_tolerance_g:.3g} g lighter or heavier",
            by_mass[0],
            "sort the seeds by mass, and give a smaller mass_scatter_g in the seed's file",
        ),
        Uncertainty(
            f"a seed that lies {spec.seed.play_mm:g} mm off its place",
            by_place[0],
            "pack the substrate more tightly, and give a smaller seed.play_mm",
        ),
    ]
    if len(loads) > 1:
        found.append(
            Uncertainty(
                f"a filling that is {100.0 * spec.substrate.mass_scatter:.0f} % lighter or heavier",
                by_mass[1],
                "weigh the filling of each pod, and give a smaller substrate.mass_scatter",
            )
        )
    if len(loads) > 1 and spec.substrate.fill < 1.0:
        found.append(
            Uncertainty(
                f"a filling of {100.0 * spec.substrate.fill:.0f} % that settles to one side",
                by_place[1],
                "fill the room completely",
            )
        )
    return tuple(found)


def loose_shift_mm(layout: PodLayout, fill: float) -> float:
    """How far the centroid of a loose filling can be from where it is spread evenly, on the worst side.

    The filling is taken to lie on one side of a plane; the seed stays where it is. By quasi-random points.

    Args:
        layout: Where things are.
        fill: Share of the room that is filled, more than 0 and at most 1.
    """
    points = _room_points_mm(layout)
    heights = (points - points.mean(axis=0)) @ layout.frame.matrix().T
    count = max(1, round(fill * len(points)))
    ordered = np.sort(heights, axis=0)
    return float(max(-ordered[:count].mean(axis=0).min(), ordered[-count:].mean(axis=0).max()))


def _room_points_mm(layout: PodLayout) -> Array:
    """Points spread evenly over the room around the seed, shape (n, 3)."""
    hull = np.concatenate([tool.hull_mm() for tool in layout.room])
    low, high = hull.min(axis=0), hull.max(axis=0)
    box = low + (high - low) * qmc.Sobol(3, rng=0).random_base2(_SAMPLES_LOG2)
    inside = np.any([tool.contains(box) for tool in layout.room], axis=0)
    result: Array = box[inside & ~layout.seed.contains(box)]
    return result


def _filling(layout: PodLayout, kernel: Solid) -> Solid:
    """The room without the seed."""
    first, *others = [tool_shape(tool) for tool in layout.room]
    room = boolean(BRepAlgoAPI_Fuse(), [first], others) if others else first
    pieces = Shape.cast(boolean(BRepAlgoAPI_Cut(), [room], [kernel.wrapped])).solids()
    return Solid(max(pieces, key=lambda piece: piece.volume).wrapped)
