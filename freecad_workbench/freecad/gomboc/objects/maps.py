"""What a body or product allows: where its centre of mass may be, how large a hole, how badly it is made."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Sequence

from freecad.gomboc import cli, door, texts
from freecad.gomboc.errors import GombocCadError

from . import files, properties
from .computed import Computed, assign_results, kind_of, vector

AS_DESIGNED = "as designed"
"""The process of a study that is that of the product itself."""

DRILL_SITES = 3000
"""So many places that the narrow valley along which a body rolls is seen whole."""

MOST_VARIANTS = 1_000_000

_SITES_RANGE = (100, 20_000, 500)
"""Fewest, most, and step in the property editor."""


class About(Computed):
    """Proxy of an object that is about a body or product of the document."""

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        properties.add(document_object, "App::PropertyLink", "Subject")

    def inputs(self, document_object: Any) -> str:
        """The subject's command line."""
        return "\n".join(subject_of(document_object).arguments())

    def execute(self, document_object: Any) -> None:
        """Called by FreeCAD's recompute: go where the subject is, and compute what changed."""
        subject = document_object.Subject
        if subject is not None and hasattr(document_object, "Placement"):
            document_object.Placement = subject.Placement
        super().execute(document_object)


class Zone(About):
    """Proxy of a loading zone."""

    kind = "zone"

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        properties.add_results(document_object, _ZONE_RESULTS)

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """`gomboc-cad zone`."""
        return cli.zone(subject_of(document_object), folder / "zone.stl")

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> Any:
        """Read the zone's surface."""
        mesh = door.Mesh.Mesh(str(folder / "zone.stl"))
        if not mesh.CountFacets:
            raise GombocCadError(texts.tr(texts.NO_ANSWER, reason="zone.stl"))
        values = {
            "SMargin": document["s_margin_mm"],
            "NearestBestSMargin": document["nearest_best_s_margin_mm"],
            "NearestBestCom": vector(document["nearest_best_com_mm"]),
            "BestSMargin": document["best_s_margin_mm"],
            "BestCom": vector(document["best_com_mm"]),
            "ZoneVolume": document["zone_volume_mm3"],
            "Good": document["s_margin_mm"] > 0.0,
        }
        return values, mesh

    def show(self, document_object: Any, results: Any) -> None:
        """Show the zone where its subject is."""
        values, mesh = results
        document_object.Mesh = mesh
        document_object.Placement = document_object.Subject.Placement
        assign_results(document_object, values)


class DrillMap(About):
    """Proxy of a drill map."""

    kind = "drillmap"

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        if properties.add(document_object, "App::PropertyIntegerConstraint", "Sites"):
            document_object.Sites = (DRILL_SITES, *_SITES_RANGE)
        properties.add_results(document_object, _DRILL_RESULTS)
        properties.add_results(document_object, _DRILL_INTERNALS, properties.INTERNAL)

    def inputs(self, document_object: Any) -> str:
        """The subject's command line, and how many places are looked at."""
        return f"{super().inputs(document_object)}\n{document_object.Sites}"

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """`gomboc-cad drillmap`."""
        return cli.drill_map(subject_of(document_object), document_object.Sites)

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> Any:
        """Draw the triangles between the sites, each with the smallest radius at its corners."""
        corners = [vector(site["position_mm"]) for site in document["sites"]]
        radii = [site["radius_mm"] for site in document["sites"]]
        faces = [_triangle([corners[i] for i in facet]) for facet in document["facets"]]
        values = {
            "Radii": [min(radii[i] for i in facet) for facet in document["facets"]],
            "MaxRadius": document["max_radius_mm"],
            "MaxDirection": vector(document["max_direction"]),
            "Good": document["max_radius_mm"] > 0.0,
        }
        return values, door.Part.makeCompound(faces)

    def show(self, document_object: Any, results: Any) -> None:
        """Show the map where its subject is; the view provider colours the faces by `Radii`."""
        values, shape = results
        shape.Placement = document_object.Subject.Placement
        assign_results(document_object, values)
        document_object.Shape = shape


class Study(About):
    """Proxy of a tolerance study."""

    kind = "tolerance"

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        properties.add(document_object, "App::PropertyIntegerConstraint", "Variants")
        properties.add(document_object, "App::PropertyIntegerConstraint", "Seed")
        if properties.add(document_object, "App::PropertyBool", "Answers"):
            document_object.Answers = True
        properties.add_results(document_object, _STUDY_RESULTS)

    def set_up(self, document_object: Any, subject: Any, processes: Sequence[str]) -> None:
        """Give a new object its subject and choices; a bare body has no process of its own."""
        document_object.Subject = subject
        properties.add(document_object, "App::PropertyEnumeration", "Process")
        of_subject = [AS_DESIGNED] if kind_of(subject) == "product" else []
        document_object.Process = [*of_subject, *processes]
        document_object.Variants = (2048, 1, MOST_VARIANTS, 1024)
        document_object.Seed = (0, 0, 2**31 - 1, 1)

    def inputs(self, document_object: Any) -> str:
        """The subject's command line, and how it is studied."""
        return "\n".join([super().inputs(document_object), *_study(document_object).arguments()])

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """`gomboc-cad tolerance`."""
        subject = subject_of(document_object)
        if subject.diameter_mm is not None:
            file = folder / f"{subject.name}.toml"
            file.write_text(cli.body_file(subject), encoding="utf-8")
            subject = cli.Subject(str(file))
        return cli.tolerance(subject, folder / "files", _study(document_object))

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> Any:
        """The yields, and what to change if that was asked for."""
        answers = ("budget_summary", "recommend", "baseline")
        said = {key: document[key]["sentence"] for key in answers if key in document}
        said.update({key: document[key] for key in ("no_answer",) if key in document})
        return {
            "Verdict": document["verdict"],
            "Good": document["verdict"] == "PASS",
            "YieldMonostable": document["yield_monostable"]["estimate"],
            "YieldTilt": document["yield_tilt"]["estimate"],
            "Recommend": said.get("recommend", ""),
            "Reasons": [
                texts.tr(texts.ONE_REST, **_percent(document["yield_monostable"])),
                texts.tr(texts.GOOD_PARTS, **_percent(document["yield_tilt"])),
                *said.values(),
            ],
            "Files": str(files.pack(folder / "files")),
        }

    def show(self, document_object: Any, results: dict[str, Any]) -> None:
        """Show the yields and what to change."""
        assign_results(document_object, results)


def is_subject(document_object: Any) -> bool:
    """Whether it is a body or product of the workbench."""
    return kind_of(document_object) in ("body", "product")


def subject_of(about: Any) -> cli.Subject:
    """The body or product that an object is about, on a command line.

    Raises:
        GombocCadError: If it is none.
    """
    subject: Any | None = about.Subject
    if subject is None or not is_subject(subject):
        label = about.Label if subject is None else subject.Label
        raise GombocCadError(texts.tr(texts.NO_SUBJECT, label=label))
    found: cli.Subject = subject.Proxy.subject(subject)
    return found


def _percent(share: dict[str, float]) -> dict[str, float]:
    return {key: 100.0 * share[key] for key in ("estimate", "low", "high")}


def _study(document_object: Any) -> cli.Study:
    process = "" if document_object.Process == AS_DESIGNED else document_object.Process
    return cli.Study(process, document_object.Variants, document_object.Seed, bool(document_object.Answers))


def _triangle(corners: Sequence[Any]) -> Any:
    return door.Part.Face(door.Part.makePolygon([*corners, corners[0]]))


_ZONE_RESULTS = {
    "SMargin": "App::PropertyFloat",
    "NearestBestSMargin": "App::PropertyFloat",
    "NearestBestCom": "App::PropertyVector",
    "BestSMargin": "App::PropertyFloat",
    "BestCom": "App::PropertyVector",
    "ZoneVolume": "App::PropertyFloat",
}
_DRILL_RESULTS = {"MaxRadius": "App::PropertyFloat", "MaxDirection": "App::PropertyVector"}
_DRILL_INTERNALS = {"Radii": "App::PropertyFloatList"}
_STUDY_RESULTS = {
    "YieldMonostable": "App::PropertyFloat",
    "YieldTilt": "App::PropertyFloat",
    "Recommend": "App::PropertyString",
    "Files": "App::PropertyFileIncluded",
}
