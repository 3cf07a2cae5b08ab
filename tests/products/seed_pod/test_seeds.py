"""Seeds: what is published is in the files, and the radicle points down whatever its direction."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gomboc_cad.errors import SpecError
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.seed_pod.seeds import Seed, load_seed, seed_names
from gomboc_cad.products.toml_model import parse_model
from gomboc_cad.resources import template_folder

Change = Callable[[dict[str, Any]], None]

# Mean length, width, thickness in mm and mass in g, as printed in the works that the files cite.
PUBLISHED = {
    "helianthus-annuus": (12.14, 5.79, 3.86, 0.0803),
    "moringa-oleifera": (10.96, 10.83, 10.24, 0.35),
    "cicer-arietinum": (6.85, 5.08, 4.72, 0.10018),
    # Middles of the ranges of 24 seed sources.
    "jatropha-curcas": (
        0.5 * (15.88 + 19.0),
        0.5 * (10.20 + 11.71),
        0.5 * (7.95 + 9.37),
        0.005 * (42.67 + 80.20),
    ),
}

numbers = st.floats(-1.0, 1.0)
directions = st.tuples(numbers, numbers, numbers).filter(lambda v: np.linalg.norm(v) > 0.1)


def seed_data(name: str) -> dict[str, Any]:
    return tomllib.loads((template_folder() / "seeds" / f"{name}.toml").read_text(encoding="utf-8"))


def test_there_are_seeds_with_and_without_published_figures() -> None:
    assert set(PUBLISHED) < set(seed_names())
    for name in set(seed_names()) - set(PUBLISHED):
        assert load_seed(name).source.startswith("estimate")


@pytest.mark.parametrize("name", sorted(PUBLISHED))
def test_a_seed_has_the_published_size_and_mass(name: str) -> None:
    seed = load_seed(name)
    found = (seed.length_mm, seed.width_mm, seed.thickness_mm, seed.mass_g)
    assert found == pytest.approx(PUBLISHED[name], rel=0.01)


@pytest.mark.parametrize("name", seed_names())
def test_a_seed_says_what_is_estimated_and_is_as_dense_as_seeds_are(name: str) -> None:
    """Achenes with air under the hull have 0.5 g/cm³, pulses 1.2 to 1.3 g/cm³."""
    seed = load_seed(name)
    assert 0.5 < seed.density_g_cm3 < 1.3
    assert "estimate" in seed.radicle_source
    assert 0.2 * seed.mass_g < seed.mass_scatter_g
    assert seed.length_mm >= seed.width_mm >= seed.thickness_mm > seed.radicle_diameter_mm


@given(directions, directions)
def test_the_radicle_points_down_in_any_frame(radicle: tuple[float, ...], down: tuple[float, ...]) -> None:
    data = seed_data("helianthus-annuus") | {"radicle_direction": list(radicle)}
    seed = parse_model(Seed, data, "seed")
    frame = RestFrame.from_rest(tuple(np.array(down) / np.linalg.norm(down)))
    axes = seed.axes_in(frame.matrix())
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    in_body = np.array(radicle) / np.linalg.norm(radicle) @ axes
    assert np.allclose(in_body, -np.array(frame.up), atol=1e-12)


def test_the_widest_side_of_an_upright_seed_lies_along_the_first_axis() -> None:
    frame = RestFrame.from_rest((-1.0, 0.0, 0.0))
    length, width, thickness = load_seed("helianthus-annuus").axes_in(frame.matrix())
    assert np.allclose(length, [-1.0, 0.0, 0.0])
    assert np.allclose(np.abs(width), np.abs(frame.first))
    assert np.allclose(np.abs(thickness), np.abs(frame.second))


def test_a_seed_of_ones_own_is_read_from_beside_the_spec(tmp_path: Path) -> None:
    text = (template_folder() / "seeds" / "quercus-robur.toml").read_text(encoding="utf-8")
    (tmp_path / "own.toml").write_text(text.replace("mass_g = 4.0", "mass_g = 3.5"), encoding="utf-8")
    assert load_seed("own.toml", tmp_path).mass_g == 3.5


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(radicle_direction=[0.0, 0.0, 0.0]), "radicle_direction must not be zero"),
        (lambda d: d.update(mass_g=80.0), r"5.6e\+02 g/cm³, which no seed is; check the unit"),
        (lambda d: d.update(mass_scatter_g=0.08), "not less than mass_g"),
        (lambda d: d.update(length_mm=0.0), "length_mm = 0.0 is not allowed"),
        (lambda d: d.update(colour="black"), "unknown key colour"),
        (lambda d: d.pop("source"), "the key source is missing"),
    ],
)
def test_impossible_seeds_are_refused(change: Change, said: str) -> None:
    data = seed_data("helianthus-annuus")
    change(data)
    with pytest.raises(SpecError, match=said):
        parse_model(Seed, data, "seed")


def test_an_unknown_seed_is_answered_with_the_known_ones() -> None:
    with pytest.raises(SpecError, match="no seed 'baobab'; choose one of cicer-arietinum, helianthus"):
        load_seed("baobab")
