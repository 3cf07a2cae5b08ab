"""Bringing the centre of mass to its target by the core's place and by trim, and saying what that costs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria import convexity
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.equilibria.zone import best_com_nearby
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.common_spec import TrimSpec
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.placing.moment_balance import Balance, Choice, CoreMove, Use
from gomboc_cad.products.placing.placement_report import Cost, costs_of, out_of_reach, sentence_of
from gomboc_cad.products.placing.trim import PlacedTrim, TrimSite, trim_items
from gomboc_cad.products.placing.trim_choice import chosen, nearest
from gomboc_cad.solid.hollow import Cylinder

__all__ = ["ComPlacement", "CoreMove", "Cost", "com_target", "converge", "place_com"]

_POCKET_STEPS = 16
_REACHED_MM = 1e-5
_CONVERGED_UM = 0.1
_ROUNDS = 12


@dataclass(frozen=True)
class ComPlacement:
    """How the centre of mass is brought to its target.

    Attributes:
        target_mm: Where it is wanted.
        core_shift_mm: Displacement of the core.
        trims: Masses in their places.
        pockets: Pockets in their places.
        costs: What each variable costs.
        mass_g: Total mass.
        com_mm: The centre of mass that follows; after `converge`, as measured.
        residual_um: Its distance from the target.
        sentence: The same in words.
        balance: The equation behind it.
        uses: Its solution.
    """

    target_mm: Vector
    core_shift_mm: Vector
    trims: tuple[PlacedTrim, ...]
    pockets: tuple[PlacedTrim, ...]
    costs: tuple[Cost, ...]
    mass_g: float
    com_mm: Vector
    residual_um: float
    sentence: str
    balance: Balance
    uses: tuple[Use, ...]

    @property
    def core_holes(self) -> tuple[Cylinder, ...]:
        """Holes and pockets in the core, before its shift: for `HollowBody.holes`."""
        return tuple(t.hole for t in (*self.trims, *self.pockets) if t.site.moves_with_core)

    @property
    def fixed_holes(self) -> tuple[Cylinder, ...]:
        """Holes and pockets that stay where they are: for `HollowBody.openings`."""
        return tuple(t.hole for t in (*self.trims, *self.pockets) if not t.site.moves_with_core)


def com_target(target: str | Vector, body: Body) -> Vector:
    """The place in mm that `com.target` of a spec stands for.

    Args:
        target: `centroid`, `best` or a point. A body that is not strictly convex has no loading zone, and its
            best place is the centroid.
        body: The outer shape.

    Raises:
        CensusError: If the best place is asked for and the body does not right itself about its centroid.
    """
    if target == "centroid" or (target == "best" and not convexity(body).strictly_convex):
        return mass_properties(body).com_mm
    if target == "best":
        # The loading zone scales with the body.
        place = _best_com_of_unit_body(body.with_diameter(2.0))
        return as_vector(body.radius_mm * np.array(place))
    x, y, z = (float(value) for value in target)
    return x, y, z


@lru_cache(maxsize=16)
def _best_com_of_unit_body(body: Body) -> Vector:
    return best_com_nearby(body)[0]


def place_com(
    fixed: tuple[float, Vector],
    target_mm: Vector,
    core: CoreMove | None,
    sites: Sequence[TrimSite] = (),
    spec: TrimSpec | None = None,
    density_g_cm3: float = 0.0,
) -> ComPlacement:
    """Bring the centre of mass to its target by the core's place and, if that does not do, by trim.

    Args:
        fixed: Mass in g and centre of mass in mm of the assembly without trim, the core not moved.
        target_mm: Where the centre of mass is wanted.
        core: What the core's place does; None for a core that cannot move.
        sites: Where trim may go.
        spec: What kind of trim is allowed; none if not given.
        density_g_cm3: Density of the shell, of which holes and pockets take away.

    Raises:
        GeometryError: If the target cannot be reached; the sentence says how far the centre of mass can be
            brought and which variables are at their limits.
        SpecError: If the material of the trim masses is not known.
    """
    mass, com = fixed
    spec = spec or TrimSpec()
    choices = tuple(choice for site in sites for choice in _choices(site, spec, density_g_cm3))
    moment = as_vector(mass * np.subtract(com, target_mm))
    return _solved(Balance(target_mm, mass, moment, core, choices))


def converge(
    measure: Callable[[ComPlacement], tuple[float, Vector]], placement: ComPlacement
) -> ComPlacement:
    """Correct a placement by what the finished solids weigh, until the centre of mass is on its target.

    Openings that are fixed to the body, and whatever else the prediction leaves out, make the true moment
    differ from the predicted one. The difference hardly changes with the core's place, so it counts as fixed.

    Args:
        measure: Gives the mass in g and the centre of mass in mm of the whole assembly made by a placement.
        placement: From `place_com`.

    Raises:
        GeometryError: If the target cannot be reached, or the measured residual does not fall to 0.1 µm.
    """
    for _ in range(_ROUNDS):
        mass, com = measure(placement)
        residual_um = 1e3 * float(np.linalg.norm(np.subtract(com, placement.target_mm)))
        if residual_um <= _CONVERGED_UM:
            return replace(placement, mass_g=mass, com_mm=com, residual_um=residual_um)
        placement = _corrected(placement, mass, com)
    raise GeometryError(
        f"The centre of mass stays {residual_um:.3g} µm from its target, although it was corrected {_ROUNDS} "
        "times; use fewer or smaller openings, or lighter contents."
    )


def _corrected(placement: ComPlacement, mass_g: float, com_mm: Vector) -> ComPlacement:
    """Solve again with the measured moment in place of the predicted one; the same trim, if it still does."""
    target, old = np.array(placement.target_mm), placement.balance
    missing = mass_g * (com_mm - target) - placement.mass_g * (placement.com_mm - target)
    balance = replace(
        old,
        mass_g=old.mass_g + mass_g - placement.mass_g,
        moment_g_mm=as_vector(old.moment_g_mm + missing),
    )
    uses = balance.drawn_near(placement.uses)
    return _placed(balance, uses) if balance.off_mm(uses) <= _REACHED_MM else _solved(balance)


def _solved(balance: Balance) -> ComPlacement:
    """The core alone if that does, else with trim."""
    if balance.off_mm(()) <= _REACHED_MM:
        return _placed(balance, ())
    uses = chosen(balance)
    if uses is None or balance.off_mm(uses) > _REACHED_MM:
        uses = nearest(balance)
    if balance.off_mm(uses) > _REACHED_MM:
        raise GeometryError(out_of_reach(balance, uses))
    return _placed(balance, uses)


def _choices(site: TrimSite, spec: TrimSpec, density_g_cm3: float) -> list[Choice]:
    """All ways to use a site."""
    if spec.kind == "none":
        return []
    density_g_mm3 = 1e-3 * density_g_cm3 * site.solid
    if spec.kind == "pockets":
        diameter = min(spec.max_diameter_mm, site.max_diameter_mm)
        hole = _area_mm2(diameter) * density_g_mm3
        depths = np.linspace(0.0, site.length_mm, _POCKET_STEPS + 1).tolist()
        return [Choice(site, None, diameter, low, high, 0.0, hole) for low, high in pairwise(depths)]
    material = load_material(spec.material)
    return [
        Choice(
            site,
            item,
            item.diameter_mm,
            low_mm=0.5 * item.length_mm,
            high_mm=site.length_mm - 0.5 * item.length_mm,
            item_mass_g=material.mass_g(item.volume_mm3),
            hole_g_mm=_area_mm2(item.diameter_mm) * density_g_mm3,
            material=spec.material,
        )
        for item in trim_items(spec, site)
    ]


def _area_mm2(diameter_mm: float) -> float:
    return float(0.25 * np.pi * diameter_mm**2)


def _placed(balance: Balance, uses: tuple[Use, ...]) -> ComPlacement:
    shift, com = balance.shift_mm(uses), balance.com_mm(uses)
    placed = [_trim(use, index, shift) for index, use in enumerate(uses, start=1)]
    costs = costs_of(balance, uses)
    return ComPlacement(
        target_mm=balance.target_mm,
        core_shift_mm=as_vector(shift),
        trims=tuple(trim for trim in placed if trim.item is not None),
        pockets=tuple(trim for trim in placed if trim.item is None),
        costs=costs,
        mass_g=balance.mass_with_g(uses),
        com_mm=as_vector(com),
        residual_um=1e3 * balance.off_mm(uses),
        sentence=sentence_of(costs),
        balance=balance,
        uses=uses,
    )


def _trim(use: Use, index: int, shift_mm: Array) -> PlacedTrim:
    """A choice as a thing in its place."""
    (site, item), depth = (use.choice.site, use.choice.item), use.depth_mm
    mouth = np.array(site.base_mm) + (shift_mm if site.moves_with_core else 0.0)
    if item is None:
        middle = as_vector(mouth + 0.5 * depth * site.direction)
        return PlacedTrim(
            site,
            name=f"pocket-{index}",
            item=None,
            standard="",
            material="",
            mass_g=-use.choice.cost_g(depth),
            position_mm=middle,
            middle_mm=middle,
            diameter_mm=use.choice.diameter_mm,
            length_mm=depth,
            depth_mm=0.0,
        )
    return PlacedTrim(
        site,
        name=f"trim-{item.kind}-{index}",
        item=item,
        standard=item.standard,
        material=use.choice.material,
        mass_g=use.choice.item_mass_g,
        position_mm=as_vector(mouth + (depth + item.com_below_middle_mm) * site.direction),
        middle_mm=as_vector(mouth + depth * site.direction),
        diameter_mm=item.diameter_mm,
        length_mm=item.length_mm,
        depth_mm=depth - 0.5 * item.length_mm,
    )
