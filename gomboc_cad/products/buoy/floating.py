"""How the finished buoy floats: a verdict of its own beside that of the flat floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.hydrostatics import (
    FRESH_WATER,
    SEA_WATER,
    FloatingCensus,
    FloatingPose,
    FloatingState,
    RightingCurve,
    Water,
    floating_census,
    floating_state,
    righting_curve,
)
from gomboc_cad.products.assembly import Assembly
from gomboc_cad.products.buoy.spec import WaterSpec
from gomboc_cad.products.verdict import Verdict
from gomboc_cad.solid import hollow
from gomboc_cad.solid.hollow import HollowBody, Tool

NOT_MODELLED = (
    "waves, wind and current",
    "mooring and towing loads",
    "motion, damping and added mass",
    "water that enters, and liquids that move inside",
    "air trapped in recesses that open downwards: all recesses are taken as flooded",
    "growth, wear and water taken up by the material",
)

_SAG_SHARE = 1e-3
"""How coarse the wetted surface is, in units of R₀: the volume is good to about the same share."""

_LEVEL = 4
_UPRIGHT_DEG = 5.0
"""A pose within this angle of the intended one counts as upright."""


@dataclass(frozen=True, eq=False)
class Floating:
    """How a buoy floats.

    Attributes:
        water: What it floats in.
        up: Direction of the body that points up where the mooring is below.
        capacity_g: Mass of the water that it displaces when it is wholly under it.
        upright: How it floats when it is held with the mooring below.
        census: All its floating poses.
        gm_with_air_mm: Smaller metacentric height upright, were every recess full of air.
        righting: Righting arms from the intended pose to upside down.
    """

    water: Water
    up: Vector
    capacity_g: float
    upright: FloatingState
    census: FloatingCensus
    gm_with_air_mm: float
    righting: RightingCurve

    @property
    def lowest(self) -> FloatingPose:
        """The stable pose of least energy."""
        return next(pose for pose in self.census.poses if pose.kind == "stable")

    def heel_deg(self, pose: FloatingPose) -> float:
        """Angle between a pose and the intended one."""
        return float(np.degrees(np.arccos(np.clip(np.dot(pose.up, self.up), -1.0, 1.0))))

    @property
    def sentence(self) -> str:
        """What comes of it, in words."""
        stable = [pose for pose in self.census.poses if pose.kind == "stable"]
        head = f"Floating in {self.water.name}, which is apart from the verdict on the flat floor: "
        if self.census.verdict == "undecided":
            return f"{head}undecided; {self.census.reason}"
        state = self.lowest.state
        heel = self.heel_deg(self.lowest)
        attitude = "upright, the mooring below," if heel < _UPRIGHT_DEG else f"heeled by {heel:.0f}°"
        figures = (
            f"{state.draft_mm:.1f} mm deep, with {state.freeboard_mm:.1f} mm of freeboard, a metacentric "
            f"height of {state.gm_mm[0]:.3g} mm and {100.0 * state.reserve_buoyancy:.0f} % of its volume in "
            "reserve"
        )
        if len(stable) == 1:
            return f"{head}one stable pose, {attitude} {figures}."
        return (
            f"{head}{len(stable)} stable poses, the lowest {attitude} {figures}; lower the centre of mass if "
            "it is to float in one."
        )


def water_of(spec: WaterSpec) -> Water:
    """The water that a spec names."""
    if spec.density_g_cm3 is not None:
        return Water("water", spec.density_g_cm3)
    return SEA_WATER if spec.kind == "sea" else FRESH_WATER


def check_displacement(mass_g: float, volume_mm3: float, water: Water) -> None:
    """Refuse a buoy that sinks.

    Raises:
        GeometryError: With both masses.
    """
    capacity = 1e-3 * volume_mm3 * water.density_g_cm3
    if mass_g >= capacity:
        raise GeometryError(
            f"The buoy is heavier than its displacement: it weighs {mass_g:.0f} g and can displace "
            f"{capacity:.0f} g of {water.name}; take a thinner wall, less ballast, a lighter battery or a "
            "larger diameter."
        )


def float_buoy(
    body: Body, recesses: tuple[Tool, ...], assembly: Assembly, up: Vector, water: Water
) -> Floating:
    """Take the floating census of a finished buoy.

    Args:
        body: Its outer shape.
        recesses: What water enters.
        assembly: Its parts.
        up: Direction of the body that is to point up.
        water: What it floats in.

    Raises:
        GeometryError: If it sinks.
    """
    sag_um = 1e3 * _SAG_SHARE * body.radius_mm
    dry = hollow.mesh(HollowBody(body, None), sag_um)
    wet = hollow.mesh(HollowBody(body, None, openings=recesses), sag_um)
    mass_g, com_mm = assembly.mass_g, assembly.com_mm
    check_displacement(mass_g, wet.mass().volume_mm3, water)
    with_air = floating_state(dry.vertices_mm, dry.faces, mass_g, com_mm, up, water)
    return Floating(
        water=water,
        up=up,
        capacity_g=1e-3 * wet.mass().volume_mm3 * water.density_g_cm3,
        upright=floating_state(wet.vertices_mm, wet.faces, mass_g, com_mm, up, water),
        census=floating_census(wet.vertices_mm, wet.faces, mass_g, com_mm, water, level=_LEVEL),
        gm_with_air_mm=with_air.gm_mm[0],
        righting=righting_curve(wet.vertices_mm, wet.faces, mass_g, com_mm, up, water),
    )


def floating_summary(floating: Floating) -> dict[str, Any]:
    """The key `floating` of `verdict.json`."""
    census = floating.census
    return {
        "water": floating.water.name,
        "verdict": census.verdict,
        "stable": census.stable,
        "depth_mm": census.depth_mm,
        "upright": {
            "draft_mm": floating.upright.draft_mm,
            "freeboard_mm": floating.upright.freeboard_mm,
            "gm_mm": list(floating.upright.gm_mm),
            "reserve_buoyancy": floating.upright.reserve_buoyancy,
        },
        "sentence": floating.sentence,
    }


def hydrostatics_document(floating: Floating, assembly: Assembly, verdict: Verdict) -> dict[str, Any]:
    """`hydrostatics.json`: the floating poses, with the verdict on the flat floor beside them."""
    census, evidence = floating.census, floating.census.evidence
    return {
        "water": {"name": floating.water.name, "density_g_cm3": floating.water.density_g_cm3},
        "mass_g": assembly.mass_g,
        "com_mm": list(assembly.com_mm),
        "displacement_capacity_g": floating.capacity_g,
        "floating": {
            "verdict": census.verdict,
            "reason": census.reason,
            "stable": census.stable,
            "saddles": census.saddles,
            "unstable": census.unstable,
            "depth_mm": census.depth_mm,
            "poses": [_pose_document(floating, pose) for pose in census.poses],
        },
        "upright": {
            **_state_document(floating.upright),
            "righting_arm_mm": floating.upright.righting_arm_mm,
            "waterline_mm": [np.round(loop, 4).tolist() for loop in floating.upright.waterline_mm],
            "gm_with_air_in_recesses_mm": floating.gm_with_air_mm,
        },
        "righting": floating.righting.document(),
        "flat_floor": {
            "verdict": verdict.verdict,
            "stable": None if verdict.census is None else verdict.census.stable,
        },
        "evidence": {
            "orientations": evidence.orientations,
            "spacing_deg": evidence.spacing_deg,
            "resolution_mm": evidence.resolution_mm,
            "sag_mm": evidence.sag_mm,
            "barrier_mm": evidence.barrier_mm,
            "highest_uncounted_mm": evidence.highest_uncounted_mm,
            "complete": evidence.complete,
        },
        "not_modelled": list(NOT_MODELLED),
    }


def _pose_document(floating: Floating, pose: FloatingPose) -> dict[str, Any]:
    return {
        "kind": pose.kind,
        "extent": pose.extent,
        "heel_deg": floating.heel_deg(pose),
        "barrier_mm": pose.barrier_mm,
        "barrier_mj": pose.barrier_mj,
        **_state_document(pose.state),
    }


def _state_document(state: FloatingState) -> dict[str, Any]:
    return {
        "up": list(state.up),
        "displaced_volume_mm3": state.displaced_volume_mm3,
        "draft_mm": state.draft_mm,
        "freeboard_mm": state.freeboard_mm,
        "reserve_buoyancy": state.reserve_buoyancy,
        "center_of_buoyancy_mm": list(state.center_of_buoyancy_mm),
        "waterplane_area_mm2": state.waterplane_area_mm2,
        "gm_mm": list(state.gm_mm),
        "bm_mm": list(state.bm_mm),
        "com_over_buoyancy_mm": state.com_over_buoyancy_mm,
    }
