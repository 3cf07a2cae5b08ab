"""A product: IMU housing, seed pod or buoy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Sequence

from freecad.gomboc import cli, door, texts
from freecad.gomboc.errors import GombocCadError
from freecad.gomboc.lists import Lists

from . import files, parts, properties
from .computed import Computed, vector
from .judgement import Judgement

CENTROID, BEST, POINT = "centroid", "best", "point"
"""Where the centre of mass is to be: of the homogeneous body, where it forgives most, or given."""

_VOLUME_AGREES = 1e-3
"""Relative; FreeCAD's own integral is good to 2.4e-4 on these surfaces."""

RESULTS = {
    "SMargin": "App::PropertyFloat",
    "Mass": "App::PropertyFloat",
    "CentreOfMass": "App::PropertyVector",
    "RestDirection": "App::PropertyVector",
    "Parts": "App::PropertyLink",
    "Files": "App::PropertyFileIncluded",
}
"""Of products and bodies."""


@dataclass(frozen=True)
class Built:
    """What a build gave, ready to be shown."""

    judgement: Judgement
    mass_g: float
    com_error_um: float
    parts: Sequence[parts.PartShape]
    archive: Path


class Product(Computed):
    """Proxy of a product."""

    kind = "product"

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        properties.add_results(document_object, _OF_PRODUCTS)
        properties.add_results(document_object, RESULTS)

    def set_up(self, document_object: Any, name: str, lists: Lists) -> None:
        """Give a new object the settings that this product has, with the values of its template."""
        document_object.Product = name
        spec = lists.products[name]
        for setting in properties.PRODUCT_SETTINGS:
            default = properties.default_of(spec, setting.key)
            if default is not None:
                choices = lists.choices.get(setting.choices, ())
                properties.add_setting(document_object, setting, default, choices)
        properties.add(document_object, "App::PropertyEnumeration", "ComTarget")
        document_object.ComTarget = [BEST, CENTROID, POINT]
        properties.add(document_object, "App::PropertyVector", "ComTargetPoint")
        set_target(document_object, properties.default_of(spec, "com.target") or BEST)
        properties.add(document_object, "App::PropertyStringList", "Overrides")

    def settings(self, document_object: Any) -> list[properties.Setting]:
        """The settings that this product has."""
        return [s for s in properties.PRODUCT_SETTINGS if s.name in document_object.PropertiesList]

    def subject(self, document_object: Any) -> cli.Subject:
        """The product on a command line."""
        changes = {s.key: properties.value_of(document_object, s) for s in self.settings(document_object)}
        target: Any = document_object.ComTarget
        if target == POINT:
            target = [properties.exact_mm(entry) for entry in document_object.ComTargetPoint]
        changes["com.target"] = target
        overrides = [cli.check_override(line) for line in document_object.Overrides if line.strip()]
        return cli.Subject(document_object.Product, changes=changes, overrides=overrides)

    def inputs(self, document_object: Any) -> str:
        """The command line without its folder."""
        return "\n".join(self.subject(document_object).arguments())

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """`gomboc-cad build`."""
        return cli.build(self.subject(document_object), folder / "files")

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> Built:
        """Read the assembly, and see that its parts are those of the verdict."""
        step = folder / "files" / f"{document['product']}.step"
        shapes = _named_solids(step)
        told = document["parts"]
        if sorted(shapes) != sorted(part["name"] for part in told):
            raise _wrong(step, ", ".join(shapes))
        for part in told:
            found, expected = shapes[part["name"]].Volume, part["volume_mm3"]
            if abs(found - expected) > _VOLUME_AGREES * expected:
                raise _wrong(step, f"{part['name']}: {found:.6g} mm³, {expected:.6g} mm³")
        made = [
            parts.PartShape(p["name"], p["material"], p["mass_g"], tuple(p["color"]), shapes[p["name"]])
            for p in told
        ]
        assembly = document["assembly"]
        return Built(
            Judgement.of_document(document, assembly["com_mm"]),
            assembly["mass_g"],
            assembly["com_residual_um"],
            made,
            files.pack(folder / "files"),
        )

    def show(self, document_object: Any, results: Built) -> None:
        """Show parts, datums and verdict."""
        whole = door.Part.makeCompound([part.shape for part in results.parts])
        whole.Placement = document_object.Placement
        document_object.Shape = whole
        document_object.Mass, document_object.ComError = results.mass_g, results.com_error_um
        document_object.Files = str(results.archive)
        parts.show_parts(document_object, results.parts)
        results.judgement.show(document_object)

    def onChanged(self, document_object: Any, name: str) -> None:
        """Called by FreeCAD when a property changed: the parts move with the product."""
        if name == "Placement" and "Restore" not in document_object.State:
            parts.move(document_object)


def set_target(document_object: Any, target: Any) -> None:
    """Set where the centre of mass is to be: `best`, `centroid`, or a point in mm.

    Raises:
        GombocCadError: If it is something else.
    """
    if target in (BEST, CENTROID):
        document_object.ComTarget = target
    else:
        document_object.ComTargetPoint = vector(properties.point("com_target", target))
        document_object.ComTarget = POINT


_OF_PRODUCTS = {"Product": "App::PropertyString", "ComError": "App::PropertyFloat"}


def _named_solids(step: Path) -> dict[str, Any]:
    """The solids of an assembly by name; both in the order of the file."""
    _assembly, *names = files.product_names(step.read_text(encoding="latin-1"))
    solids = door.read_solids(step)
    if len(names) != len(solids) or len(set(names)) != len(names):
        raise _wrong(step, f"{len(solids)} solids, {len(names)} names")
    return dict(zip(names, solids))


def _wrong(step: Path, reason: str) -> GombocCadError:
    return GombocCadError(texts.tr(texts.WRONG_PARTS, file=step.name, reason=reason))
