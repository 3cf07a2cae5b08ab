"""Solids go to CadQuery and come back without loss."""

from __future__ import annotations

import builtins
from types import ModuleType

import pytest
from build123d import Solid

from gomboc_cad import Body
from gomboc_cad.errors import GeometryError, GombocError
from gomboc_cad.solid.exchange import from_cadquery, to_cadquery
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.patches import body_solid


@pytest.mark.usefixtures("cadquery")
def test_a_solid_comes_back_as_the_same_shape(primary: Body) -> None:
    solid = body_solid(primary)
    workplane = to_cadquery(solid)
    assert workplane.val().isValid()
    back = from_cadquery(workplane)
    assert isinstance(back, Solid)
    assert back.wrapped.IsSame(solid.wrapped)
    assert solid_mass(back) == solid_mass(solid)


@pytest.mark.usefixtures("cadquery")
def test_a_hole_drilled_in_cadquery_comes_back(primary: Body) -> None:
    solid = body_solid(primary)
    drilled = to_cadquery(solid).faces(">Z").workplane(centerOption="CenterOfMass").hole(5.0)
    back = from_cadquery(drilled)
    assert back.is_valid
    taken = solid_mass(solid).volume_mm3 - solid_mass(back).volume_mm3
    # The drill enters at the centre of one of six patches, beside the middle of the body.
    assert 85.0 < taken / (3.1416 * 2.5**2) < 100.0


def test_other_than_one_solid_is_refused(cadquery: ModuleType) -> None:
    two = cadquery.Workplane().pushPoints([(0, 0), (10, 0)]).box(1, 1, 1, combine=False)
    with pytest.raises(GeometryError, match="holds 2 solids"):
        from_cadquery(two)
    with pytest.raises(GeometryError, match="holds 0 solids"):
        from_cadquery(cadquery.Workplane().pushPoints([(0, 0), (1, 1)]))


def test_without_cadquery_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real_import = builtins.__import__

    def refuse(name: str, *args, **kwargs):
        if name == "cadquery":
            raise ImportError(name)
        return real_import(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(GombocError, match=r"gomboc-cad\[cadquery\]"):
        to_cadquery(Solid.make_box(1, 1, 1))
