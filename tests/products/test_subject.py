"""What an analysis starts from: bodies by name and as they are, products by their spec."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.errors import BodyError, SpecError
from gomboc_cad.products.subject import body_and_com, is_spec


def test_a_body_comes_with_its_homogeneous_centroid() -> None:
    body = catalog()["primary"].with_diameter(60.0)
    assert body_and_com(body) == (body, mass_properties(body).com_mm)
    named, com = body_and_com("primary")
    assert named.diameter_mm == 100.0
    assert com == pytest.approx((-0.134778477, 0.0, 0.0), abs=1e-8)


def test_a_product_comes_with_the_com_of_its_assembly(template_with: Callable[..., Path]) -> None:
    """That is on its target, far from the centroid of the body."""
    stages: list[str] = []
    spec = template_with(("diameter_mm = 100.0", "diameter_mm = 90.0"), ('"best" ', "[-0.4, 0.0, 0.0] "))
    body, com = body_and_com(str(spec), stages.append)
    assert body.diameter_mm == 90.0
    assert com == pytest.approx((-0.4, 0.0, 0.0), abs=1e-4)
    assert np.linalg.norm(np.subtract(com, mass_properties(body).com_mm)) > 0.2
    assert stages


def test_names_of_specs_and_of_bodies() -> None:
    assert is_spec("imu-housing")
    assert is_spec("folder/mine.toml")
    assert not is_spec("primary")
    with pytest.raises(BodyError):
        body_and_com("no-such-body")
    with pytest.raises(SpecError):
        body_and_com("no-such-file.toml")
