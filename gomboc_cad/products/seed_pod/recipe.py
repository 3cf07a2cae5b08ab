"""The recipe of the seed pod: from a spec to parts whose centre of mass is where it should be.

Seed, substrate, chamber and closure are one rigid core. It is lighter than the shell's material that would
fill it, so moving it up brings the centre of mass down. The exit for the root stays at the rest point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.assembly import Assembly, Part
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.materials import Material, load_material
from gomboc_cad.products.placement import parting_of
from gomboc_cad.products.placing.com_placement import ComPlacement, CoreMove, com_target, converge, place_com
from gomboc_cad.products.placing.trim import trim_parts
from gomboc_cad.products.process import least_wall_mm
from gomboc_cad.products.seed_pod.casing import Casing, PluggedCasing, SplitCasing
from gomboc_cad.products.seed_pod.contents import (
    SEED,
    SUBSTRATE,
    Contents,
    contents_of,
    loads_of,
    substrate_of,
    uncertainties_of,
)
from gomboc_cad.products.seed_pod.layout import PodLayout, lay_out, trim_sites
from gomboc_cad.products.seed_pod.seeds import Seed, load_seed
from gomboc_cad.products.seed_pod.spec import SeedPodSpec
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid import hollow
from gomboc_cad.solid.hollow import HollowBody

NAME = "seed-pod"

_SHIFT_DECIMALS = 6

_NOT_MODELLED = (
    "The verdict holds on a hard, flat, level floor. Soil, grass, slopes, stones and wind are not modelled, "
    "nor what rain does: water that seed, substrate or shell take up and decay of the shell move the centre "
    "of mass and the surface."
)


@dataclass(frozen=True)
class _Pod:
    """All that is settled before the core's place."""

    spec: SeedPodSpec
    layout: PodLayout
    contents: Contents
    casing: Casing
    shell: Material

    def hollow(self, placement: ComPlacement | None) -> HollowBody:
        """The whole pod, without a placement with an unmoved core and no trim."""
        if placement is None:
            return self.layout.hollow()
        # To a nanometre, so that what is symmetric stays so and no edge becomes shorter than that.
        shift = as_vector(np.round(placement.core_shift_mm, _SHIFT_DECIMALS) + 0.0)
        return self.layout.hollow(shift, placement.core_holes, placement.fixed_holes)

    def parts(self, placement: ComPlacement | None) -> tuple[Part, ...]:
        """All parts in place, without meshes."""
        whole = self.hollow(placement)
        inside = tuple(part.moved(np.array(whole.core_shift_mm)) for part in self.contents.parts)
        trim = () if placement is None else trim_parts(placement.trims)
        return (*self.casing.parts(whole, self.shell), *inside, *trim)

    def assembly(self, placement: ComPlacement | None, target_mm: Vector) -> Assembly:
        """The same as an assembly."""
        return Assembly(NAME, self.parts(placement), target_mm)

    def placed(self, unmoved: Assembly, least_wall_mm: float) -> tuple[ComPlacement, Assembly]:
        """Bring the centre of mass of the really made parts to its target.

        Args:
            unmoved: The pod with an unmoved core.
            least_wall_mm: The least wall that may be left.

        Returns:
            The placement, and the pod made after it.
        """
        empty = self.shell.mass_g(hollow.void_properties(self.hollow(None)).volume_mm3)
        reach = min(self.layout.wall_mm - least_wall_mm, self.layout.reach_mm)
        placement = place_com(
            (unmoved.mass_g, unmoved.com_mm),
            unmoved.com_target_mm,
            CoreMove(self.contents.mass_g + self.casing.bought_mass_g - empty, reach),
            trim_sites(self.layout, least_wall_mm),
            self.spec.trim,
            self.shell.density_g_cm3,
        )
        trials = []

        def measure(trial: ComPlacement) -> tuple[float, Vector]:
            trials.append(self.assembly(trial, unmoved.com_target_mm))
            return trials[-1].mass_g, trials[-1].com_mm

        placement = converge(measure, placement)
        return placement, trials[-1]


def design_seed_pod(
    spec: SeedPodSpec, spec_folder: Path | None = None, progress: Progress = silent
) -> ProductDesign:
    """Make a seed pod's parts and place its centre of mass.

    Args:
        spec: A checked spec.
        spec_folder: Folder that the names of a user's own data files start from.
        progress: Called with the name of each stage as it begins.

    Raises:
        SpecError: If a name or a size in the spec is not available.
        GeometryError: If something does not fit, or the centre of mass cannot be brought to its target.
        CensusError: If the body does not right itself, so that there is no best place.
    """
    progress("laying out the interior")
    body = spec.body.body()
    seed = load_seed(spec.seed.species, spec_folder)
    least_wall = least_wall_mm(spec.shell, spec_folder)
    target = com_target(spec.com.target, body)
    layout = lay_out(spec, body, seed, target, least_wall)
    contents = contents_of(spec, layout, seed, substrate_of(spec))
    pod = _Pod(spec, layout, contents, _casing(spec, layout), load_material(spec.shell.material))

    progress("making the solids")
    unmoved = pod.assembly(None, target)

    progress("placing the centre of mass")
    placement, assembly = pod.placed(unmoved, least_wall)

    progress("making the meshes")
    made = pod.casing.with_meshes(assembly.parts, pod.hollow(placement), spec.mesh.sag_um)
    assembly = replace(assembly, parts=made)
    loads = loads_of(spec, layout, seed, assembly)
    return ProductDesign(
        spec=spec,
        body=body,
        frame=layout.frame,
        assembly=assembly,
        placement=placement,
        openings=(layout.exit,),
        uncertainties=uncertainties_of(spec, layout, loads, assembly),
        loads=loads,
        upper_parts=pod.casing.upper_parts,
        parting_direction=layout.frame.up,
        parting=None
        if layout.way_in is not None
        else parting_of(layout.frame, spec.split, placement.core_shift_mm),
        summary={"pod": _summary(spec, layout, seed, assembly)},
        notes=_notes(spec, layout, seed),
    )


def _casing(spec: SeedPodSpec, layout: PodLayout) -> Casing:
    if layout.way_in is not None:
        return PluggedCasing(layout.way_in, layout.frame.up)
    assert layout.closure is not None
    return SplitCasing(layout.closure, parting_of(layout.frame, spec.split))


def _summary(spec: SeedPodSpec, layout: PodLayout, seed: Seed, assembly: Assembly) -> dict[str, Any]:
    """What `verdict.json` says of the pod's inside."""
    masses = {part.name: part.mass_g for part in assembly.parts}
    return {
        "species": seed.name,
        "seed_mass_g": masses[SEED],
        "substrate_mass_g": masses.get(SUBSTRATE, 0.0),
        "substrate_fill": spec.substrate.fill if spec.substrate.used else 0.0,
        "exit_diameter_mm": 2.0 * layout.exit.tool.radius_mm,
        "radicle_direction": [0.0 - component for component in layout.frame.up],
        "wall_before_shift_mm": layout.wall_mm,
    }


def _notes(spec: SeedPodSpec, layout: PodLayout, seed: Seed) -> tuple[str, ...]:
    notes = [
        f"The seed {seed.name!r} is set with its radicle down, over the exit of "
        f"{2.0 * layout.exit.tool.radius_mm:.3g} mm at the rest point.",
        _NOT_MODELLED,
    ]
    if not spec.substrate.used:
        notes.append(
            "Without substrate the seed is loose in its chamber: seed.play_mm should be all of its room."
        )
    elif spec.substrate.fill < 1.0:
        notes.append("The filling is loose and moves as the pod rolls; only a full one stays where it is.")
    if seed.size_scatter_mm > 2.0 * spec.seed.clearance_mm:
        notes.append(
            f"Seeds of a lot may be {seed.size_scatter_mm:g} mm larger than the mean and the chamber leaves "
            f"{2.0 * spec.seed.clearance_mm:g} mm: sieve them, or give seed.clearance_mm more."
        )
    return (*notes, *(layout.closure.notes if layout.closure is not None else ()))
