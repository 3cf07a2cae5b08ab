"""3MF files: a zip archive of XML models, whose build items are placed meshes in a stated unit.

Source: 3MF Consortium, Core Specification 1.3 and Production Extension 1.1.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.formats.archive import Archive, open_archive
from gomboc_cad.solid.formats.content import (
    MAX_CORNERS,
    MAX_FACETS,
    FileMesh,
    check_count,
    check_indices,
)

THREE_MF = "a 3MF file"

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
_MATERIAL = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
_RELATIONSHIPS = "http://schemas.openxmlformats.org/package/2006/relationships"
_MODEL_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_GEOMETRY_KEPT = {_CORE, _PRODUCTION, _MATERIAL}
"""Extensions that a reader of plain meshes may be required to know without missing any geometry."""

_MAX_DEPTH = 16
_MAX_OBJECTS = 10_000
_MAX_PLACEMENTS = 10_000
_MAX_MODELS = 200


class _Reference(NamedTuple):
    """An object used as a component or as a build item."""

    path: str
    id: str
    transform: Array


@dataclass
class _Object:
    """An object of a model while it is read: a mesh, or components."""

    name: str
    kind: str
    coordinates: array = field(default_factory=lambda: array("d"))
    corners: array = field(default_factory=lambda: array("q"))
    components: list[_Reference] = field(default_factory=list)


@dataclass
class _Model:
    """What one model file says."""

    unit: str = "millimeter"
    objects: dict[str, _Object] = field(default_factory=dict)
    items: list[_Reference] = field(default_factory=list)


def read_3mf(path: Path, name: str) -> FileMesh:
    """Read the build items of a 3MF file, in place.

    Raises:
        InspectionError: If the file is damaged, not to be trusted, too large, or needs an extension that
            changes geometry.
    """
    with open_archive(path, name) as archive:
        return _Reader(name, archive).read()


class _Reader:
    """Follows the references from the build items of the root model to meshes."""

    def __init__(self, name: str, archive: Archive):
        self._name = name
        self._archive = archive
        self._models: dict[str, _Model] = {}
        self._vertices: list[Array] = []
        self._faces: list[IntArray] = []
        self._placed = 0

    def read(self) -> FileMesh:
        root = self._root_path()
        model = self._model(root)
        items = [(item, self._object(item.path or root, item.id)) for item in model.items]
        parts = [(item, found) for item, found in items if found.kind == "model"]
        for item, _ in parts:
            self._place(item.path or root, item.id, item.transform, 0)
        left_out = len(items) - len(parts)
        notes = (f"{left_out} build items that are supports or the like were left out.",) if left_out else ()
        names = tuple(found.name or f"object {item.id}" for item, found in parts)
        empty_vertices, empty_faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        return FileMesh(
            THREE_MF,
            np.concatenate([empty_vertices, *self._vertices]),
            np.concatenate([empty_faces, *self._faces]),
            parts=names,
            unit=model.unit,
            notes=notes,
        )

    def _root_path(self) -> str:
        """The model that the package names as its first part."""
        targets: list[str] = []

        def start(tag: str, attributes: dict[str, str]) -> None:
            if tag == f"{_RELATIONSHIPS} Relationship" and attributes.get("Type") == _MODEL_TYPE:
                targets.append(attributes.get("Target", "").lstrip("/"))

        _parse_xml(self._name, self._archive, "_rels/.rels", start)
        if len(targets) != 1:
            raise InspectionError(f"{self._name} is damaged: it names {len(targets)} root models, not one.")
        return targets[0]

    def _model(self, path: str) -> _Model:
        if path not in self._models:
            check_count(self._name, "models", len(self._models), _MAX_MODELS)
            self._models[path] = _read_model(self._name, self._archive, path)
        return self._models[path]

    def _object(self, path: str, object_id: str) -> _Object:
        found = self._model(path).objects.get(object_id)
        if found is None:
            raise InspectionError(
                f"{self._name} is damaged: it uses an object {object_id!r} that is not there."
            )
        return found

    def _place(self, path: str, object_id: str, transform: Array, depth: int) -> None:
        """Add an object and what it is made of, under limits that a few nested doublings would exceed."""
        self._placed += 1
        check_count(self._name, "placed objects", self._placed, _MAX_PLACEMENTS)
        check_count(self._name, "levels of components", depth, _MAX_DEPTH)
        found = self._object(path, object_id)
        if len(found.corners):
            vertices = np.array(found.coordinates, dtype=float).reshape(-1, 3)
            faces = np.array(found.corners, dtype=np.int64).reshape(-1, 3)
            check_indices(self._name, faces, len(vertices))
            total = sum(map(len, self._faces)) + len(faces)
            check_count(self._name, "facets", total, MAX_FACETS)
            total_vertices = sum(map(len, self._vertices))
            check_count(self._name, "vertices", total_vertices + len(vertices), MAX_CORNERS)
            mirrored = np.linalg.det(transform[:3]) < 0.0
            self._faces.append((faces[:, ::-1] if mirrored else faces) + total_vertices)
            with np.errstate(over="ignore", invalid="ignore"):  # numbers beyond all sizes are refused later
                self._vertices.append(vertices @ transform[:3] + transform[3])
        for component in found.components:
            placed = np.concatenate([component.transform, [[0.0], [0.0], [0.0], [1.0]]], axis=1)
            outer = np.concatenate([transform, [[0.0], [0.0], [0.0], [1.0]]], axis=1)
            self._place(component.path or path, component.id, (placed @ outer)[:, :3], depth + 1)


def _read_model(name: str, archive: Archive, path: str) -> _Model:
    """Parse one model file; meshes go straight into arrays of numbers."""
    model = _Model()
    current = _Object("", "model")
    namespaces: dict[str, str] = {}
    vertex, triangle = f"{_CORE} vertex", f"{_CORE} triangle"

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal current
        if tag == vertex:
            get = attributes.__getitem__
            current.coordinates.extend((float(get("x")), float(get("y")), float(get("z"))))
            check_count(name, "vertices", len(current.coordinates) // 3, MAX_CORNERS)
        elif tag == triangle:
            get = attributes.__getitem__
            current.corners.extend((int(get("v1")), int(get("v2")), int(get("v3"))))
            check_count(name, "facets", len(current.corners) // 3, MAX_FACETS)
        elif tag == f"{_CORE} model":
            model.unit = attributes.get("unit", "millimeter")
            _check_extensions(name, attributes.get("requiredextensions", "").split(), namespaces)
        elif tag == f"{_CORE} object":
            current = _Object(attributes.get("name", ""), attributes.get("type", "model"))
            check_count(name, "objects", len(model.objects) + 1, _MAX_OBJECTS)
            if model.objects.setdefault(attributes["id"], current) is not current:
                raise ValueError("two objects have one id")
        elif tag == f"{_CORE} component":
            current.components.append(_reference(attributes))
            check_count(name, "components", len(current.components), _MAX_PLACEMENTS)
        elif tag == f"{_CORE} item":
            model.items.append(_reference(attributes))
            check_count(name, "build items", len(model.items), _MAX_PLACEMENTS)

    _parse_xml(name, archive, path, start, namespaces)
    return model


def _reference(attributes: dict[str, str]) -> _Reference:
    numbers = [float(word) for word in attributes.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()]
    transform = np.array(numbers).reshape(4, 3)
    if not np.all(np.isfinite(transform)) or np.linalg.det(transform[:3]) == 0.0:
        raise ValueError("a transform has no inverse")
    path = attributes.get(f"{_PRODUCTION} path", "").lstrip("/")
    return _Reference(path, attributes["objectid"], transform)


def _check_extensions(name: str, required: list[str], namespaces: dict[str, str]) -> None:
    for prefix in required:
        if namespaces.get(prefix) not in _GEOMETRY_KEPT:
            raise InspectionError(
                f"{name} needs the 3MF extension {prefix!r}, which changes the geometry; export a plain mesh."
            )


def _parse_xml(
    name: str,
    archive: Archive,
    member: str,
    start: Callable[[str, dict[str, str]], None],
    namespaces: dict[str, str] | None = None,
) -> None:
    """Call `start` for every element of a member, without document types and so without entities."""

    def refuse_document_type(*_: object) -> None:
        raise InspectionError(
            f"{name} is not to be trusted: {member} has a document type, which 3MF forbids."
        )

    def note_namespace(prefix: str | None, uri: str) -> None:
        if namespaces is not None:
            namespaces[prefix or ""] = uri

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = start
    parser.StartDoctypeDeclHandler = refuse_document_type
    parser.StartNamespaceDeclHandler = note_namespace
    try:
        for block in archive.blocks(member):
            parser.Parse(block, False)
        parser.Parse(b"", True)
    except (expat.ExpatError, ValueError, OverflowError, KeyError) as error:
        raise InspectionError(f"{name} is damaged: {member} is no valid 3MF model ({error}).") from error
