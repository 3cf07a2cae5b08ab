"""Two rings with an ISO metric thread: the female one glued into the lower part, the male into the upper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from bd_warehouse.thread import IsoThread
from build123d import Shape, Solid
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.closures.annular import AXIS, land
from gomboc_cad.products.closures.records import ClosureLayout, ClosureSite
from gomboc_cad.products.closures.spec import ThreadRingSpec
from gomboc_cad.products.closures.tessellation import solid_mesh
from gomboc_cad.products.materials import Material, load_material
from gomboc_cad.solid.hollow.brep_kernel import boolean
from gomboc_cad.solid.mass import solid_mass

FEMALE, MALE = "thread-ring-female", "thread-ring-male"
_COLORS = {FEMALE: (0.85, 0.55, 0.20), MALE: (0.95, 0.72, 0.40)}

_DIAMETERS_MM = (
    *range(8, 13),
    *(
        14,
        16,
        18,
        20,
        22,
        24,
        27,
        30,
        33,
        36,
        39,
        42,
        45,
        48,
        52,
        56,
        60,
        64,
        68,
        72,
        76,
        80,
        85,
        90,
        95,
        100,
    ),
    *range(105, 151, 5),
    *range(160, 301, 10),
    *range(320, 601, 20),
)
"""Thread diameters to choose from: first and second choice of ISO 261, and even sizes beyond."""

_ROOTS_MM = (0.4, 0.2, 0.3, 0.1, 0.5)
"""How far the thread's profile may run into its ring; by chance, OCCT fails to fuse them with some."""

_FUSED_TOLERANCE = 0.01
"""Of the thread's volume, to which a fused ring must hold what it is made of."""

_LEAST_TURNS = 3.0


@dataclass(frozen=True)
class _Rings:
    """Sizes of both rings; heights from the seam.

    Attributes:
        diameter_mm: Nominal thread diameter.
        outer_mm: Outer radius of both rings.
        core_mm: Outer radius of the male ring under its thread.
        inner_mm: Inner radius of the male ring.
    """

    diameter_mm: float
    outer_mm: float
    core_mm: float
    inner_mm: float

    @classmethod
    def of(cls, spec: ThreadRingSpec, diameter_mm: float) -> _Rings:
        core = IsoThread(diameter_mm, spec.pitch_mm, spec.pitch_mm, simple=True).min_radius
        core -= spec.thread_clearance_mm
        return cls(diameter_mm, 0.5 * diameter_mm + spec.ring_wall_mm, core, core - spec.ring_wall_mm)


def lay_out_thread_ring(spec: ThreadRingSpec, site: ClosureSite) -> ClosureLayout:
    """Choose the thread, make both rings and the land that they are glued into.

    Raises:
        SpecError: If the material of the rings is not known.
        GeometryError: If the rings do not fit at the seam, or the thread is too short.
    """
    if spec.length_mm < _LEAST_TURNS * spec.pitch_mm:
        raise GeometryError(
            f"closure.length_mm = {spec.length_mm:g} holds fewer than {_LEAST_TURNS:g} turns of a pitch of "
            f"{spec.pitch_mm:g} mm; make it longer or the pitch finer."
        )
    rings = _rings(spec, site)
    bore = rings.outer_mm + spec.glue_gap_mm
    reach = spec.length_mm + spec.shoulder_mm
    bosses, holes = land(site, bore - spec.shoulder_mm, reach, reach)
    material = load_material(spec.material)
    up, down = site.frame.up, as_vector(-np.array(site.frame.up))
    return ClosureLayout(
        site=site,
        seam=site.seam(),
        bosses=bosses,
        holes=(*holes, site.upright(AXIS, spec.length_mm, spec.length_mm, bore)),
        parts=(
            _part(FEMALE, _female(spec, rings), site, material, up),
            _part(MALE, _male(spec, rings), site, material, down),
        ),
        upper_parts=(MALE,),
        notes=(
            f"Screw the two rings (M{rings.diameter_mm:g} x {spec.pitch_mm:g}) together, glue them into "
            "both parts at once and line the parts up until the glue is hard: then the outer surfaces meet "
            "without a step whenever it is closed.",
        ),
    )


def _rings(spec: ThreadRingSpec, site: ClosureSite) -> _Rings:
    reach = spec.length_mm + spec.shoulder_mm
    room = site.widest_ring_mm(reach, reach, site.shell.wall_mm) - spec.glue_gap_mm
    largest = 2.0 * (room - spec.ring_wall_mm)
    if spec.diameter_mm == "auto":
        diameter = max((float(size) for size in _DIAMETERS_MM if size <= largest), default=0.0)
        if not diameter:
            raise GeometryError(
                f"The room at the seam takes a thread of {max(0.0, largest):.3g} mm at most, and the "
                f"smallest ring is M{_DIAMETERS_MM[0]}; take a thinner closure.ring_wall_mm, a shorter "
                "closure.length_mm or a larger diameter."
            )
    else:
        diameter = spec.diameter_mm
        if diameter > largest:
            raise GeometryError(
                f"A thread of closure.diameter_mm = {diameter:g} does not fit: the room at the seam takes "
                f"{largest:.4g} mm at most; take a smaller one or a larger body."
            )
    rings = _Rings.of(spec, diameter)
    least = max(site.bore_radius_mm or 0.0, spec.pitch_mm)
    if rings.inner_mm < least:
        raise GeometryError(
            f"The thread M{diameter:g} x {spec.pitch_mm:g} with a ring wall of {spec.ring_wall_mm:g} mm "
            f"leaves a bore of {max(0.0, 2.0 * rings.inner_mm):.3g} mm where {2.0 * least:.3g} mm are "
            "needed; take a larger thread or thinner rings."
        )
    return rings


def _female(spec: ThreadRingSpec, rings: _Rings) -> Solid:
    """The female ring, its top at z = 0."""

    def thread(root_mm: float) -> IsoThread:
        return IsoThread(
            rings.diameter_mm,
            spec.pitch_mm,
            spec.length_mm,
            external=False,
            end_finishes=("fade", "fade"),
            interference=root_mm,
        )

    ring = _tube(rings.outer_mm, 0.5 * rings.diameter_mm, 0.0, spec.length_mm)
    return _threaded(ring, thread, spec).translate((0.0, 0.0, -spec.length_mm))


def _male(spec: ThreadRingSpec, rings: _Rings) -> Solid:
    """The male ring, its collar above z = 0 and its thread below, half a pitch off the female one."""
    length, half_turn = spec.length_mm, 0.5 * spec.pitch_mm

    def thread(root_mm: float) -> IsoThread:
        return IsoThread(
            rings.diameter_mm,
            spec.pitch_mm,
            length - 2.0 * half_turn,
            external=True,
            end_finishes=("fade", "fade"),
            interference=root_mm,
            manufacturing_compensation=spec.thread_clearance_mm,
        ).translate((0.0, 0.0, half_turn))

    sleeve = _tube(rings.core_mm, rings.inner_mm, half_turn, 2.0 * length)
    collar = _tube(rings.outer_mm, rings.inner_mm, length, 2.0 * length)
    ring = _single(sleeve.fuse(collar))
    return _threaded(ring, thread, spec).translate((0.0, 0.0, -length))


def _threaded(ring: Solid, thread: Callable[[float], IsoThread], spec: ThreadRingSpec) -> Solid:
    """Fuse a ring and its thread; its root changes nothing but whether OCCT succeeds."""
    crest = sum(turn.volume for turn in thread(0.0).solids())
    for root in (root for root in _ROOTS_MM if root < spec.ring_wall_mm):
        turns = [turn.wrapped for turn in thread(root).solids()]
        solids = Shape.cast(boolean(BRepAlgoAPI_Fuse(), [ring.wrapped], turns)).solids()
        if len(solids) == 1 and solids[0].is_valid:
            added = solid_mass(solids[0]).volume_mm3 - solid_mass(ring).volume_mm3
            if abs(added - crest) < _FUSED_TOLERANCE * crest:
                return solids[0]
    raise GeometryError(
        f"OCCT cannot make the thread M{spec.diameter_mm} x {spec.pitch_mm:g}; choose another "
        "closure.diameter_mm or closure.pitch_mm."
    )


def _tube(outer_mm: float, inner_mm: float, start_mm: float, end_mm: float) -> Solid:
    height = end_mm - start_mm
    tube = _single(Solid.make_cylinder(outer_mm, height).cut(Solid.make_cylinder(inner_mm, height)))
    return tube.translate((0.0, 0.0, start_mm))


def _single(shape: Solid) -> Solid:
    solids = shape.solids()
    if len(solids) != 1:
        raise GeometryError("OCCT cannot make the thread ring; choose another closure.diameter_mm.")
    return solids[0]


def _part(name: str, solid: Solid, site: ClosureSite, material: Material, print_up: Vector) -> Part:
    placed = solid.moved(site.location(AXIS, 0.0))
    part = Part.homogeneous(name, placed, material, _COLORS[name])
    return replace(part, mesh=solid_mesh(placed, site.sag_um), print_up=print_up)
