"""Makers of part files: valid ones in every format, and damaged, lying or hostile ones."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gomboc_cad.solid.mesh import Mesh

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
RELATIONSHIPS = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
    'Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>"
)


def box(size=(10.0, 20.0, 30.0), low=(0.0, 0.0, 0.0)) -> Mesh:
    """A box of twelve triangles that face outwards; corner number 4x + 2y + z."""
    bits = np.array([[k >> 2 & 1, k >> 1 & 1, k & 1] for k in range(8)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return Mesh(bits * size + np.asarray(low), np.array(faces, dtype=np.int64))


def together(*meshes: Mesh) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0] + [len(mesh.vertices_mm) for mesh in meshes])
    return Mesh(
        np.concatenate([mesh.vertices_mm for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def reversed_mesh(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices_mm, mesh.faces[:, ::-1])


def binary_stl(mesh: Mesh, header: bytes = b"made for tests") -> bytes:
    rows = [struct.pack("<12fH", 0, 0, 0, *mesh.vertices_mm[face].ravel(), 0) for face in mesh.faces]
    return header.ljust(80, b"\0") + struct.pack("<I", len(rows)) + b"".join(rows)


def text_stl(mesh: Mesh, name: str = "part") -> bytes:
    lines = [f"solid {name}"]
    for face in mesh.faces:
        lines += ["  facet normal 0 0 0", "    outer loop"]
        lines += [f"      vertex {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices_mm[face].tolist()]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, f"endsolid {name}", ""]).encode()


def obj(mesh: Mesh) -> bytes:
    lines = ["mtllib other.mtl", "usemtl shiny"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices_mm.tolist()]
    lines += ["f " + " ".join(f"{k + 1}/1/1" for k in face) for face in mesh.faces.tolist()]
    return "\n".join([*lines, ""]).encode()


def ply_header(encoding: str, vertices: int, faces: int) -> bytes:
    return (
        f"ply\nformat {encoding} 1.0\ncomment made for tests\nelement vertex {vertices}\nproperty float x\n"
        f"property float y\nproperty float z\nelement face {faces}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()


def text_ply(mesh: Mesh) -> bytes:
    lines = [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices_mm.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    return ply_header("ascii", len(mesh.vertices_mm), len(mesh.faces)) + "\n".join([*lines, ""]).encode()


def binary_ply(mesh: Mesh, order: str = "<") -> bytes:
    encoding = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    rows = [struct.pack(order + "Biii", 3, *face) for face in mesh.faces.tolist()]
    vertices = mesh.vertices_mm.astype(order + "f4").tobytes()
    return ply_header(encoding, len(mesh.vertices_mm), len(mesh.faces)) + vertices + b"".join(rows)


def model_xml(
    meshes: dict[str, Mesh], *, unit: str = "millimeter", transform: str = "", resources: str = ""
) -> str:
    """A 3MF model with one build item per mesh; `resources` are added as they are."""
    objects, items = [], []
    for number, (name, mesh) in enumerate(meshes.items(), start=1):
        vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in mesh.vertices_mm.tolist())
        facets = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces.tolist())
        objects.append(
            f'<object id="{number}" name="{name}" type="model"><mesh><vertices>{vertices}</vertices>'
            f"<triangles>{facets}</triangles></mesh></object>"
        )
        placed = f' transform="{transform}"' if transform else ""
        items.append(f'<item objectid="{number}"{placed}/>')
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><model unit="{unit}" xmlns="{CORE}"><resources>'
        f"{''.join(objects)}{resources}</resources><build>{''.join(items)}</build></model>"
    )


def archive(members: dict[str, str | bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as target:
        for name, content in members.items():
            target.writestr(name, content)
    return stream.getvalue()


def package(model: str | bytes, **more: str | bytes) -> bytes:
    """A 3MF file around a model."""
    return archive({"_rels/.rels": RELATIONSHIPS, "3D/3dmodel.model": model, **more})


def three_mf(mesh: Mesh, **how: str) -> bytes:
    return package(model_xml({"part": mesh}, **how))


WRITERS: dict[str, tuple[str, Callable[[Mesh], bytes]]] = {
    "binary STL": (".stl", binary_stl),
    "text STL": (".stl", text_stl),
    "OBJ": (".obj", obj),
    "text PLY": (".ply", text_ply),
    "binary PLY": (".ply", binary_ply),
    "big-endian PLY": (".ply", lambda mesh: binary_ply(mesh, ">")),
    "3MF": (".3mf", three_mf),
}


def write(folder: Path, name: str, content: bytes) -> Path:
    path = folder / name
    path.write_bytes(content)
    return path


def declared_stl(facets: int) -> bytes:
    """A binary STL that claims many facets and holds none."""
    return b"\0" * 80 + struct.pack("<I", facets)


def zip_bomb() -> bytes:
    """A 3MF of some sixty kilobytes whose model unpacks to 64 MB of blanks."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as target:
        target.writestr("_rels/.rels", RELATIONSHIPS)
        with target.open("3D/3dmodel.model", "w") as member:
            for _ in range(64):
                member.write(b" " * 2**20)
    return stream.getvalue()


def doubling_components(levels: int) -> bytes:
    """A 3MF whose last object is 2^levels copies of a box."""
    placed = "".join(
        f'<object id="{k + 2}" type="model"><components><component objectid="{k + 1}"/>'
        f'<component objectid="{k + 1}"/></components></object>'
        for k in range(levels)
    )
    model = model_xml({"box": box()}, resources=placed)
    return package(model.replace('<item objectid="1"/>', f'<item objectid="{levels + 1}"/>'))


def entity_bomb() -> bytes:
    """A 3MF whose model declares the billion laughs."""
    entities = '<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))
    model = model_xml({"box": box()}).replace("<model ", f"<!DOCTYPE model [{entities}]><model ", 1)
    return package(model.replace('name="box"', 'name="&a9;"'))


def external_entity(target: Path) -> bytes:
    """A 3MF whose model asks for another file of this computer."""
    document_type = f'<!DOCTYPE model [<!ENTITY x SYSTEM "{target.as_uri()}">]>'
    model = model_xml({"box": box()}).replace("<model ", document_type + "<model ", 1)
    return package(model.replace('name="box"', 'name="&x;"'))
