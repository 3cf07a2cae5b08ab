"""Plates read back: each mesh is in the file once, and what stands wrong is said."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad.body.catalogue import named_body
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.export import NamedMesh, write_plate
from gomboc_cad.solid.inspect import Expected, FileInspection
from gomboc_cad.solid.mesh import Mesh, body_mesh
from gomboc_cad.solid.mesh_reading import read_3mf
from gomboc_cad.solid.plate_inspection import inspect_plate

BED = (250.0, 210.0)
QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Copy:
    """A copy of a part on a bed."""

    part: str
    turn: Array
    shift_mm: Array


@pytest.fixture(scope="module")
def pod() -> Mesh:
    return body_mesh(named_body("primary", 60.0), 50.0)


def standing(mesh: Mesh, x: float, y: float, turn: Array) -> Copy:
    """A copy whose box begins at a place of the bed."""
    return Copy("pod", turn, np.array([x, y, 0.0]) - (mesh.vertices_mm @ turn.T).min(axis=0))


def row(mesh: Mesh, pitch: float, count: int = 3) -> list[Copy]:
    return [standing(mesh, 5.0 + pitch * i, 5.0, QUARTER_TURN if i % 2 else np.eye(3)) for i in range(count)]


def found(path: Path, mesh: Mesh, laid_out: list[Copy], written: list[Copy]) -> FileInspection:
    write_plate(path, [NamedMesh("pod", mesh)], written)
    mass = mesh.mass()
    expected = {"pod": Expected("pod", mass.volume_mm3, mass.com_mm, 50.0)}
    return inspect_plate(path, expected, laid_out, BED)


def test_each_copy_is_where_it_was_laid(tmp_path: Path, pod: Mesh) -> None:
    copies = row(pod, 66.0)
    result = found(tmp_path / "plate.3mf", pod, copies, copies)
    assert result.ok, result.problems
    read = sorted(read_3mf(tmp_path / "plate.3mf"), key=lambda item: item[1].vertices_mm[:, 0].min())
    for (name, mesh), copy in zip(read, copies, strict=True):
        assert name == "pod"
        expected = pod.vertices_mm @ copy.turn.T + copy.shift_mm
        assert mesh.vertices_mm.min(axis=0) == pytest.approx(expected.min(axis=0), abs=1e-4)
        assert mesh.vertices_mm.max(axis=0) == pytest.approx(expected.max(axis=0), abs=1e-4)


def test_copies_cost_next_to_nothing_and_the_bytes_are_the_same(tmp_path: Path, pod: Mesh) -> None:
    for name, count in (("one", 1), ("many", 200), ("again", 200)):
        write_plate(tmp_path / name, [NamedMesh("pod", pod)], row(pod, 66.0, count))
    one, many = ((tmp_path / name).stat().st_size for name in ("one", "many"))
    assert many < 1.2 * one
    assert (tmp_path / "many").read_bytes() == (tmp_path / "again").read_bytes()


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (lambda pod: row(pod, 50.0), "in each other's way"),
        (lambda pod: row(pod, 95.0), "over the edge"),
        (lambda pod: row(pod, 66.0, 2), "were laid out"),
        (
            lambda pod: [
                *row(pod, 66.0, 2),
                Copy("pod", np.eye(3), np.array([170.0, 40.0, 60.0])),
            ],
            "does not stand on the bed",
        ),
    ],
)
def test_what_stands_wrong_is_said(tmp_path: Path, pod: Mesh, written, said: str) -> None:
    result = found(tmp_path / "plate.3mf", pod, row(pod, 66.0), written(pod))
    assert not result.ok
    assert any(said in problem for problem in result.problems)


def test_another_part_and_damage_are_said(tmp_path: Path, pod: Mesh) -> None:
    copies = row(pod, 66.0)
    smaller = Mesh(0.99 * pod.vertices_mm, pod.faces)
    write_plate(tmp_path / "plate.3mf", [NamedMesh("pod", smaller)], copies)
    mass = pod.mass()
    expected = {"pod": Expected("pod", mass.volume_mm3, mass.com_mm, 50.0)}
    assert any("volume" in p for p in inspect_plate(tmp_path / "plate.3mf", expected, copies, BED).problems)
    (tmp_path / "broken.3mf").write_bytes((tmp_path / "plate.3mf").read_bytes()[:500])
    assert not inspect_plate(tmp_path / "broken.3mf", expected, copies, BED).ok
    with zipfile.ZipFile(tmp_path / "empty.3mf", "w"):
        pass
    assert not inspect_plate(tmp_path / "empty.3mf", expected, copies, BED).ok
    with pytest.raises(InspectionError, match="cannot be read"):
        inspect_plate(tmp_path / "missing.3mf", expected, copies, BED)
