"""A press fit: a tongue a little wider than its socket.

The pressure between two rings of the same material follows from Lamé's thick-walled cylinders (S. Timoshenko,
Strength of Materials, part II; DIN 7190-1). With the interference δ and the diameters d of the joint, D
outside and dᵢ of the bore it is

    p = E δ / (d ((D² + d²)/(D² − d²) + (d² + dᵢ²)/(d² − dᵢ²))).

The socket bears the hoop stress `p (D² + d²)/(D² − d²)` besides the pressure; the tongue bears
`2 p d² / (d² − dᵢ²)` at its bore. The larger of both by Tresca's criterion is held against the limit.
"""

from __future__ import annotations

from dataclasses import dataclass

from gomboc_cad.errors import GeometryError
from gomboc_cad.products.closures.annular import AXIS, land, outer_radius_mm
from gomboc_cad.products.closures.elasticity import Elasticity, load_elasticity
from gomboc_cad.products.closures.fits import Interference, iso_fit
from gomboc_cad.products.closures.records import ClosureLayout, ClosureSite
from gomboc_cad.products.closures.spec import PressSpec


@dataclass(frozen=True)
class PressStress:
    """What a press fit does to its parts.

    Attributes:
        pressure_mpa: Pressure in the joint.
        socket_mpa: Equivalent stress of the socket at the joint.
        tongue_mpa: Equivalent stress of the tongue at its bore.
    """

    pressure_mpa: float
    socket_mpa: float
    tongue_mpa: float

    @property
    def largest_mpa(self) -> float:
        """The larger equivalent stress."""
        return max(self.socket_mpa, self.tongue_mpa)


def press_stress(
    modulus_mpa: float, interference_um: float, bore_mm: float, joint_mm: float, outside_mm: float
) -> PressStress:
    """Stress of a press fit of two rings of the same material, by Lamé.

    Args:
        modulus_mpa: Modulus of elasticity.
        interference_um: Interference of the diameters.
        bore_mm: Inner diameter of the tongue.
        joint_mm: Diameter of the joint.
        outside_mm: Outer diameter of the socket.
    """
    socket = (outside_mm**2 + joint_mm**2) / (outside_mm**2 - joint_mm**2)
    tongue = (joint_mm**2 + bore_mm**2) / (joint_mm**2 - bore_mm**2)
    pressure = modulus_mpa * 1e-3 * interference_um / (joint_mm * (socket + tongue))
    return PressStress(
        pressure_mpa=pressure,
        socket_mpa=pressure * (socket + 1.0),
        tongue_mpa=2.0 * pressure * joint_mm**2 / (joint_mm**2 - bore_mm**2),
    )


def lay_out_press(spec: PressSpec, site: ClosureSite) -> ClosureLayout:
    """Find the diameter of a press fit, and check what it does to the material.

    Raises:
        SpecError: If the fit, or the elasticity of the shell's material, is not known.
        GeometryError: If it does not fit or stresses the material too much.
    """
    material = load_elasticity(site.shell.material)
    root = spec.tongue_wall_mm
    room = site.widest_ring_mm(spec.height_mm + spec.end_gap_mm, root, site.shell.wall_mm)
    wanted = None if spec.diameter_mm == "auto" else 0.5 * spec.diameter_mm
    radius = outer_radius_mm(site, "press fit", wanted, room, spec.tongue_wall_mm, 0.0)
    inner = radius - spec.tongue_wall_mm
    interference = _interference(spec, 2.0 * radius)
    outside = 2.0 * (room + site.shell.wall_mm)
    stress = press_stress(material.modulus_mpa, interference.most_um, 2.0 * inner, 2.0 * radius, outside)
    limit = spec.stress_limit_mpa or material.stress_limit_mpa
    _check_stress(site, interference, stress, limit)

    # Under the flange, or in the bore, the groove runs out into the open.
    open_end = 0.5 * spec.end_gap_mm if site.bore_radius_mm is None else 2.0 * spec.end_gap_mm
    bosses, holes = land(site, inner, spec.height_mm + open_end, root)
    excess = 0.25e-3 * interference.mean_um
    tongue = site.upright(AXIS, spec.height_mm, 0.5 * root, radius + excess)
    groove = site.upright(AXIS, spec.height_mm + spec.end_gap_mm, 0.5 * root, radius - excess)
    return ClosureLayout(
        site=site,
        seam=site.seam((tongue,), (groove,)),
        bosses=bosses,
        holes=holes,
        notes=(_note(site, material, radius, interference, stress, limit),),
    )


def _interference(spec: PressSpec, diameter_mm: float) -> Interference:
    if spec.interference_um is not None:
        return Interference(spec.interference_um, spec.interference_um)
    return iso_fit(spec.fit, diameter_mm)


def _check_stress(
    site: ClosureSite, interference: Interference, stress: PressStress, limit_mpa: float
) -> None:
    if stress.largest_mpa > limit_mpa:
        allowed = interference.most_um * limit_mpa / stress.largest_mpa
        raise GeometryError(
            f"The press fit's interference of {interference.most_um:.3g} µm stresses the "
            f"{site.shell.material} to {stress.largest_mpa:.3g} MPa, and {limit_mpa:.3g} MPa is "
            f"permissible; take at most {allowed:.3g} µm in closure.interference_um, or a larger diameter."
        )


def _note(
    site: ClosureSite,
    material: Elasticity,
    radius: float,
    interference: Interference,
    stress: PressStress,
    limit: float,
) -> str:
    return (
        f"The tongue of the press fit is made {interference.mean_um:.3g} µm wider than its socket at a "
        f"diameter of {2.0 * radius:.4g} mm, so the two solids overlap by that; at the most, "
        f"{interference.most_um:.3g} µm, the pressure is {stress.pressure_mpa:.2g} MPa and the stress "
        f"{stress.largest_mpa:.3g} MPa of {limit:.3g} MPa ({site.shell.material} with a modulus of "
        f"{material.modulus_mpa:.4g} MPa; plastics relax with time)."
    )
