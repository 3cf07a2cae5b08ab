"""The casing of a seed pod: one piece and its plug, or two halves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from build123d import Solid

from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.closures.records import ClosureLayout
from gomboc_cad.products.materials import Material
from gomboc_cad.products.placement import Parting
from gomboc_cad.products.seed_pod.layout import WayIn
from gomboc_cad.solid import hollow
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import Cylinder, HollowBody
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.step import Color

BODY, PLUG = "seed-pod-body", "seed-pod-plug"
LOWER, UPPER = "seed-pod-lower", "seed-pod-upper"

_Shape = tuple[Mesh, Boundary, Vector]

_GREEN, _PALE = (0.45, 0.56, 0.30), (0.72, 0.78, 0.55)


class Casing(ABC):
    """What is made of the shell's material, and what closes it."""

    @property
    def bought_mass_g(self) -> float:
        """Mass of bought parts, which move with the core."""
        return 0.0

    @property
    def upper_parts(self) -> frozenset[str]:
        """Names of the parts that go with the upper half."""
        return frozenset()

    @abstractmethod
    def parts(self, pod: HollowBody, shell: Material) -> tuple[Part, ...]:
        """Made and bought parts in place, without meshes.

        Args:
            pod: The whole pod.
            shell: Material of the made parts.
        """

    @abstractmethod
    def with_meshes(self, parts: tuple[Part, ...], pod: HollowBody, sag_um: float) -> tuple[Part, ...]:
        """Give the same parts, the made ones with mesh, boundary and printing direction.

        Args:
            parts: All parts of the pod.
            pod: The whole pod.
            sag_um: Largest distance of a facet from the surface.
        """


@dataclass(frozen=True)
class PluggedCasing(Casing):
    """One piece with an opening at the top and a plug.

    Attributes:
        way_in: Opening and plug before the core's shift.
        up: Upwards at rest.
    """

    way_in: WayIn
    up: Vector

    def parts(self, pod: HollowBody, shell: Material) -> tuple[Part, ...]:
        """The body and its plug."""
        plug = hollow.plug_brep(pod.body, self._plug(pod))
        return (_made(BODY, hollow.brep(pod), shell, _GREEN), _made(PLUG, plug, shell, _PALE))

    def with_meshes(self, parts: tuple[Part, ...], pod: HollowBody, sag_um: float) -> tuple[Part, ...]:
        """Both printed upright: the plug stands on its flat end, the body on its exit."""
        plug = self._plug(pod)
        shapes = {
            BODY: (hollow.mesh(pod, sag_um), Boundary.of_hollow(pod), self.up),
            PLUG: (hollow.plug_mesh(pod.body, plug, sag_um), Boundary.of_plug(pod.body, plug), self.up),
        }
        return _shaped(parts, shapes)

    def _plug(self, pod: HollowBody) -> Cylinder:
        return self.way_in.plug.moved(pod.core_shift_mm)


@dataclass(frozen=True)
class SplitCasing(Casing):
    """Two halves.

    Attributes:
        closure: How they are closed, before the core's shift.
        parting: The seam.
    """

    closure: ClosureLayout
    parting: Parting

    @property
    def bought_mass_g(self) -> float:
        """Mass of the pins."""
        return sum(part.mass_g for part in self.closure.parts)

    @property
    def upper_parts(self) -> frozenset[str]:
        """The upper half and what stays in it."""
        return frozenset({UPPER, *self.closure.upper_parts})

    def parts(self, pod: HollowBody, shell: Material) -> tuple[Part, ...]:
        """The halves and what the closure brings."""
        closure = self.closure.moved(np.array(pod.core_shift_mm))
        lower, upper = hollow.split_brep(hollow.brep(pod), closure.seam)
        offset = np.array(self.parting.shift_mm)
        brought = (part.moved(offset) if part.name in closure.upper_parts else part for part in closure.parts)
        halves = _made(LOWER, lower, shell, _GREEN), _made(UPPER, upper, shell, _PALE).moved(offset)
        return (*halves, *brought)

    def with_meshes(self, parts: tuple[Part, ...], pod: HollowBody, sag_um: float) -> tuple[Part, ...]:
        """Each half is printed on its seam."""
        seam = self.closure.moved(np.array(pod.core_shift_mm)).seam
        meshes = hollow.split_mesh(hollow.mesh(pod, sag_um), seam, sag_um)
        lower, upper = zip(meshes, Boundary.of_hollow(pod).split(seam), strict=True)
        down, offset = as_vector(-np.array(self.parting.up)), np.array(self.parting.shift_mm)
        mesh, boundary = upper
        raised = replace(mesh, vertices_mm=mesh.vertices_mm + offset), boundary.moved(self.parting.shift_mm)
        shapes = {LOWER: (*lower, down), UPPER: (*raised, self.parting.up)}
        return _shaped(parts, shapes)


def _made(name: str, solid: Solid, shell: Material, color: Color) -> Part:
    return Part.homogeneous(name, solid, shell, color)


def _shaped(parts: Sequence[Part], shapes: Mapping[str, _Shape]) -> tuple[Part, ...]:
    """Give made parts their mesh, boundary and printing direction by name."""
    result = []
    for part in parts:
        if part.name in shapes:
            mesh, boundary, print_up = shapes[part.name]
            part = replace(part, mesh=mesh, boundary=boundary, print_up=print_up)
        result.append(part)
    return tuple(result)
