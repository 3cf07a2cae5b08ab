"""A bare body of the catalogue."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from freecad.gomboc import cli, door, texts
from freecad.gomboc.errors import GombocCadError
from freecad.gomboc.lists import Lists

from . import files, parts, product, properties
from .computed import Computed
from .judgement import Judgement

DEFAULT_BODY, DEFAULT_DIAMETER_MM, DEFAULT_MATERIAL = "primary", 100.0, "PLA"
COLOR = (0.27, 0.51, 0.71)

_MATERIAL = properties.Setting("Material", "material", "", "choice", "materials")
_DENSITIES = {"Densities": "App::PropertyMap"}
SETTINGS = (*properties.BODY_SETTINGS, _MATERIAL)


@dataclass(frozen=True)
class Made:
    """What a body is, ready to be shown."""

    judgement: Judgement
    mass_g: float
    shape: Any
    archive: Path


class Body(Computed):
    """Proxy of a bare body, homogeneous and solid."""

    kind = "body"

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        properties.add_results(document_object, product.RESULTS)
        properties.add_results(document_object, _DENSITIES, properties.INTERNAL)

    def set_up(self, document_object: Any, lists: Lists) -> None:
        """Give a new object its settings."""
        bodies, materials = lists.choices["bodies"], lists.choices["materials"]
        for setting, default, choices in zip(
            SETTINGS, (DEFAULT_BODY, DEFAULT_DIAMETER_MM, DEFAULT_MATERIAL), (bodies, (), materials)
        ):
            properties.add_setting(document_object, setting, default, choices)
        document_object.Densities = {name: repr(value) for name, value in lists.density_g_cm3.items()}

    def settings(self, document_object: Any) -> list[properties.Setting]:
        """What a user sets."""
        return list(SETTINGS)

    def subject(self, document_object: Any) -> cli.Subject:
        """The body on a command line."""
        name, diameter = (properties.value_of(document_object, s) for s in properties.BODY_SETTINGS)
        return cli.Subject(name, diameter_mm=diameter)

    def inputs(self, document_object: Any) -> str:
        """The command line without its folder, and the material."""
        return "\n".join([*self.subject(document_object).arguments(), document_object.Material])

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """`gomboc-cad body`."""
        return cli.body(self.subject(document_object), folder / "files")

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> Made:
        """Read the one solid."""
        solids = [solid for step in (folder / "files").glob("*.step") for solid in door.read_solids(step)]
        if len(solids) != 1:
            raise GombocCadError(texts.tr(texts.WRONG_PARTS, file="STEP", reason=f"{len(solids)} solids"))
        density_g_cm3 = float(document_object.Densities[document_object.Material])
        return Made(
            Judgement.of_document(document, document["com_mm"]),
            1e-3 * density_g_cm3 * document["volume_mm3"],
            solids[0],
            files.pack(folder / "files"),
        )

    def show(self, document_object: Any, results: Made) -> None:
        """Show the solid, its datums and the verdict."""
        results.shape.Placement = document_object.Placement
        document_object.Shape = results.shape
        document_object.Mass = results.mass_g
        document_object.Files = str(results.archive)
        results.judgement.show(document_object)

    def onChanged(self, document_object: Any, name: str) -> None:
        """Called by FreeCAD when a property changed: the datums move with the body."""
        if name == "Placement" and "Restore" not in document_object.State:
            parts.move(document_object)
