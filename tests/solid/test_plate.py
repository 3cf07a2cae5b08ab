"""Plates: upright, apart, on the bed, and a slicer takes them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.common_spec import PlateSpec
from gomboc_cad.solid.export import NamedMesh, write_plate
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.plate import PlateItem, pack
from tests.external import PrusaSlicer
from tests.solid.manifolds import block, mesh_of, rod


@dataclass(frozen=True)
class Piece:
    """What `pack` needs to know of a part."""

    name: str
    mesh: Mesh | None
    print_up: Vector | None


BOX = Piece("box", mesh_of(block(40.0, 30.0, 20.0).translate([500.0, 0.0, -70.0])), (1.0, 0.0, 0.0))
DISC = Piece("disc", mesh_of(rod(15.0, 10.0)), (0.0, 0.0, -1.0))
SCREW = Piece("screw", None, None)


def boxes(plate: tuple[PlateItem, ...], *pieces: Piece) -> Array:
    """Lowest and highest corner of each copy, shape (n, 2, 3)."""
    meshes = {piece.name: piece.mesh for piece in pieces or (BOX, DISC)}
    vertices = [item.placed(meshes[item.part]).vertices_mm for item in plate]
    return np.array([(points.min(axis=0), points.max(axis=0)) for points in vertices])


def check(plate: tuple[PlateItem, ...], spec: PlateSpec, *pieces: Piece) -> None:
    """Everything on the bed, on the ground, unique, and apart by the spacing."""
    bounds = boxes(plate, *pieces)
    assert bounds[:, 0, 2] == pytest.approx(0.0, abs=1e-12)
    assert np.all(bounds[:, 0, :2] >= spec.spacing_mm - 1e-9)
    assert np.all(bounds[:, 1, :2] <= np.array(spec.bed_mm) - spec.spacing_mm + 1e-9)
    assert len({item.name for item in plate}) == len(plate)
    for (low, high), (lower, higher) in combinations(bounds[:, :, :2], 2):
        assert np.maximum(lower - high, low - higher).max() >= spec.spacing_mm - 1e-9


def test_parts_stand_upright_and_bought_ones_stay_away() -> None:
    spec = PlateSpec()
    plate = pack([BOX, SCREW, DISC], spec)
    check(plate, spec)
    assert [item.name for item in plate] == ["box", "disc"]
    extents = np.ptp(boxes(plate), axis=1)
    assert extents[0, 2] == pytest.approx(40.0)
    assert sorted(extents[0, :2]) == pytest.approx([20.0, 30.0])
    assert extents[1, 2] == pytest.approx(10.0)


@settings(max_examples=20, deadline=None)
@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.05))
def test_the_printing_direction_ends_up_upright_and_the_part_is_not_mirrored(up: Vector) -> None:
    mesh = mesh_of(block(10.0, 20.0, 30.0) - rod(2.0, 99.0).translate([2.0, 3.0, 0.0]))
    (item,) = pack([Piece("part", mesh, up)], PlateSpec())
    placed = item.placed(mesh)
    assert item.turn @ item.turn.T == pytest.approx(np.eye(3), abs=1e-12)
    assert placed.mass().volume_mm3 == pytest.approx(mesh.mass().volume_mm3)
    heights = mesh.vertices_mm @ (np.array(up) / np.linalg.norm(up))
    assert placed.vertices_mm[:, 2] == pytest.approx(heights - heights.min(), abs=1e-9)
    assert placed.vertices_mm[:, :2].min(axis=0) == pytest.approx(5.0)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(2.0, 60.0), st.floats(2.0, 60.0)), min_size=1, max_size=5),
    st.integers(1, 6),
    st.floats(0.0, 8.0),
)
def test_whatever_is_packed_is_apart_and_on_the_bed(
    sizes: list[tuple[float, float]], copies: int, spacing: float
) -> None:
    pieces = [Piece(f"p{k}", mesh_of(block(*size, 5.0)), (0.0, 0.0, 1.0)) for k, size in enumerate(sizes)]
    spec = PlateSpec(bed_mm=(250.0, 5000.0), spacing_mm=spacing, copies=copies)
    plate = pack(pieces, spec)
    check(plate, spec, *pieces)
    assert len(plate) == copies * len(sizes)


def test_copies_are_numbered() -> None:
    plate = pack([BOX, DISC], PlateSpec(copies=3))
    assert sorted(item.name for item in plate) == [f"{n}-{k}" for n in ("box", "disc") for k in (1, 2, 3)]


def test_rectangles_fill_a_bed_that_they_fit_exactly() -> None:
    """Twelve of 20 x 30 mm with 5 mm between them need 105 x 145 mm in three columns of four."""
    spec = PlateSpec(bed_mm=(110.0, 110.0), copies=12)
    piece = Piece("tile", mesh_of(block(20.0, 30.0, 5.0)), (0.0, 0.0, 1.0))
    check(pack([piece], spec), spec, piece)


def test_the_same_parts_are_packed_in_the_same_way() -> None:
    first, second = (pack([BOX, DISC], PlateSpec(copies=9)) for _ in range(2))
    assert all(
        np.array_equal(a.turn, b.turn) and np.array_equal(a.shift_mm, b.shift_mm)
        for a, b in zip(first, second, strict=True)
    )


def test_too_many_copies_are_refused_with_what_would_fit_and_what_would_do() -> None:
    with pytest.raises(
        GeometryError, match=r"too small for 100 copies.*: (\d+) would fit, or plate.bed_mm"
    ) as error:
        pack([BOX, DISC], PlateSpec(copies=100))
    words = str(error.value)
    fit = int(words.split(" would fit")[0].split()[-1])
    depth = float(words.split(" mm.")[0].split()[-1])
    assert len(pack([BOX, DISC], PlateSpec(copies=fit))) == 2 * fit
    assert len(pack([BOX, DISC], PlateSpec(copies=100, bed_mm=(250.0, depth)))) == 200
    with pytest.raises(GeometryError):
        pack([BOX, DISC], PlateSpec(copies=fit + 1))


def test_a_part_larger_than_the_bed_is_named_with_the_bed_that_it_needs() -> None:
    with pytest.raises(GeometryError, match=r"part box .* does not fit .* at least 30 × 40 mm"):
        pack([BOX], PlateSpec(bed_mm=(60.0, 29.0)))
    assert len(pack([BOX], PlateSpec(bed_mm=(40.0, 30.0)))) == 1


def test_prusaslicer_prints_the_parts_where_they_were_put(tmp_path: Path, prusa_slicer: PrusaSlicer) -> None:
    file = tmp_path / "plate.3mf"
    plate = pack([BOX, DISC], PlateSpec(copies=2))
    write_plate(file, [NamedMesh(piece.name, piece.mesh) for piece in (BOX, DISC)], plate)
    assert prusa_slicer.info(file)["manifold"] is True
    bed = ("--dont-arrange", "--bed-shape", "0x0,250x0,250x210,0x210", "--skirts", "0")
    gcode = prusa_slicer.slice(file, tmp_path / "plate.gcode", *bed)
    moves = re.findall(r"^G1 X([\d.]+) Y([\d.]+) E", gcode, re.MULTILINE)
    places = np.array(moves, dtype=float)
    bounds = boxes(plate)[:, :, :2]
    # The middle of a thread of 0.45 mm runs inside the outline.
    assert places.min(axis=0) == pytest.approx(bounds[:, 0].min(axis=0), abs=0.3)
    assert places.max(axis=0) == pytest.approx(bounds[:, 1].max(axis=0), abs=0.3)
    for low, high in bounds:
        assert np.any(np.all((places > low) & (places < high), axis=1))
