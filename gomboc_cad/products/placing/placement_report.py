"""What it costs to bring the centre of mass to its target, or why it cannot be done, in numbers and words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.products.placing.moment_balance import Balance, Use

if TYPE_CHECKING:
    from gomboc_cad.products.placing.com_placement import ComPlacement

_AT_LIMIT = 1e-6
_IDLE_LEVER = 0.02
"""Share of the whole mass under which moving the core does next to nothing."""


@dataclass(frozen=True)
class Cost:
    """What one variable does for the centre of mass.

    Attributes:
        variable: What it is: `core`, or a site and what is in it.
        amount: How much of it is used: the core's displacement, the depth of a mass's middle or of a pocket.
        unit: Unit of amount and limit.
        mass_g: Mass that it adds, its hole taken off; negative for a pocket.
        com_effect_um: How far the centre of mass would be from the target without it alone.
        limit: The most that there is.
        at_limit: Whether there is no more: the core is as far as it may go, the mass the heaviest that fits.
    """

    variable: str
    amount: float
    unit: str
    mass_g: float
    com_effect_um: float
    limit: float
    at_limit: bool


def costs_of(balance: Balance, uses: Sequence[Use]) -> tuple[Cost, ...]:
    """The costs of the core's place, if it can move, and of each trim mass or pocket."""
    mass = balance.mass_with_g(uses)
    costs = []
    if balance.core is not None:
        way = float(np.linalg.norm(balance.shift_mm(uses)))
        effect = 1e3 * abs(balance.lever_with_g(uses)) * way / mass
        limit = balance.limit_mm
        costs.append(Cost("core", way, "mm", 0.0, effect, limit, _reaches(way, limit)))
    for use in uses:
        site, item = use.choice.site, use.choice.item
        added = use.choice.added_mass_g(use.depth_mm)
        moment = use.choice.moment_g_mm(use.depth_mm, balance.target_mm)
        moment += use.choice.moved_mass_g(use.depth_mm) * balance.shift_mm(uses)
        alike = [c for c in balance.choices if c.site == site and (c.item is None or c.item == item)]
        heaviest = max(c.cost_g(c.high_mm) for c in balance.choices if c.site == site)
        costs.append(
            Cost(
                variable=f"{site.name}: {item.standard if item else f'pocket {use.choice.diameter_mm:g} mm'}",
                amount=use.depth_mm,
                unit="mm",
                mass_g=added,
                com_effect_um=1e3 * float(np.linalg.norm(moment)) / (mass - added),
                limit=max(c.high_mm for c in alike),
                at_limit=_reaches(use.choice.cost_g(use.depth_mm), heaviest),
            )
        )
    return tuple(costs)


def sentence_of(costs: Sequence[Cost]) -> str:
    """The costs in words."""
    said = []
    for cost in costs:
        effect = f"which moves the centre of mass by {_micrometres(cost.com_effect_um)}"
        if cost.variable == "core":
            of = f"of {cost.limit:.3g} mm allowed"
            said.append(f"the cavity and its contents are moved by {cost.amount:.3g} mm {of}, {effect}")
        else:
            verb = "adds" if cost.mass_g >= 0.0 else "takes away"
            said.append(
                f"{cost.variable} at a depth of {cost.amount:.2f} mm {verb} {abs(cost.mass_g):.3g} g, "
                + effect
            )
    if not said:
        return "The centre of mass is on its target as it is; nothing is moved and nothing is added."
    text = "; ".join(said)
    return f"The centre of mass is brought to its target: {text}."


def out_of_reach(balance: Balance, uses: Sequence[Use]) -> str:
    """Why the target cannot be reached: how far the centre of mass can be brought, and what is at its limit.

    Args:
        balance: The equation that has no solution.
        uses: The trim that comes nearest.
    """
    start = float(np.linalg.norm(balance.moment_g_mm)) / balance.mass_g
    left = balance.off_mm(uses)
    share = math.floor(100.0 * (1.0 - left / start) + 1e-9)
    return (
        f"The centre of mass cannot be brought to its target: as it is, it lies {start:.3g} mm away, and it "
        f"can be brought to within {left:.3g} mm, {share} % of the way, with "
        f"{_limits(balance, uses)}; {_advice(balance)}."
    )


def _limits(balance: Balance, uses: Sequence[Use]) -> str:
    """The variables that are at their limits."""
    said = []
    if balance.core is not None:
        idle = abs(balance.lever_with_g(uses)) < _IDLE_LEVER * balance.mass_with_g(uses)
        why = ", which hardly counts because its contents weigh as much as the material it displaces"
        said.append(f"the cavity at its limit of {balance.limit_mm:.3g} mm" + why * idle)
    for cost in costs_of(balance, uses)[len(said) :]:
        said += [f"{cost.variable} at its limit"] * cost.at_limit
    return " and ".join(said) if said else "the best choice of trim"


def _advice(balance: Balance) -> str:
    trim = "allow larger trim (trim.max_diameter_mm)" if balance.choices else "allow trim (trim.kind)"
    return f"make the wall thicker or the payload lighter, {trim}, or put com.target nearer"


def placement_document(placement: ComPlacement) -> dict[str, Any]:
    """The key `placement` of `verdict.json`."""
    return {
        "target_mm": list(placement.target_mm),
        "core_shift_mm": list(placement.core_shift_mm),
        "residual_um": placement.residual_um,
        "trims": [
            {
                "name": trim.name,
                "site": trim.site.name,
                "standard": trim.standard,
                "material": trim.material,
                "mass_g": trim.mass_g,
                "position_mm": list(trim.position_mm),
                "diameter_mm": trim.diameter_mm,
                "length_mm": trim.length_mm,
                "depth_mm": trim.depth_mm,
            }
            for trim in (*placement.trims, *placement.pockets)
        ],
        "costs": [asdict(cost) for cost in placement.costs],
        "sentence": placement.sentence,
    }


def _reaches(amount: float, limit: float) -> bool:
    return amount >= (1.0 - _AT_LIMIT) * limit


def _micrometres(length_um: float) -> str:
    return f"{length_um:.3g} µm" if length_um < 1e3 else f"{1e-3 * length_um:.3g} mm"
