"""The seed pod: what is promised of the parts, of the centre of mass and of the way out for the root."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gomboc_cad.body import depth_mm
from gomboc_cad.errors import GeometryError, GombocError, SpecError
from gomboc_cad.products.assembly import Assembly, Part
from gomboc_cad.products.common_spec import SplitSpec
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.placement import parting_of
from gomboc_cad.products.process import load_process
from gomboc_cad.products.seed_pod.casing import BODY, LOWER, PLUG, UPPER, SplitCasing
from gomboc_cad.products.seed_pod.contents import (
    SEED,
    SUBSTRATE,
    Contents,
    contents_of,
    loose_shift_mm,
    substrate_of,
)
from gomboc_cad.products.seed_pod.layout import PodLayout, lay_out
from gomboc_cad.products.seed_pod.recipe import design_seed_pod
from gomboc_cad.products.seed_pod.seeds import load_seed
from gomboc_cad.products.seed_pod.spec import SeedPodSpec
from gomboc_cad.products.toml_model import parse_model
from gomboc_cad.resources import template_folder
from gomboc_cad.solid.hollow import Ellipsoid

PLUGGED = {"kind": "plug"}
PINNED = {"kind": "dowels", "diameter_mm": 2.0, "length_mm": 6.0, "boss_wall_mm": 0.8}
PRESSED = {"kind": "press", "height_mm": 3.0, "tongue_wall_mm": 1.6}

# The best place of the primary's loading zone, so that not every test has to look for it.
BEST = [-0.00822 * 15.0, 0.0, 0.0]


def pod_spec(**tables: dict[str, Any]) -> SeedPodSpec:
    """The template with some keys changed, a coarse mesh and a given target; a closure is replaced."""
    data = tomllib.loads((template_folder() / "seed-pod.toml").read_text(encoding="utf-8"))
    data["com"]["target"], data["mesh"]["sag_um"] = BEST, 50.0
    for table, changes in tables.items():
        data[table] = changes if table == "closure" else data[table] | changes
    return parse_model(SeedPodSpec, data, "pod")


def laid_out(spec: SeedPodSpec, least_wall_mm: float = 0.8) -> PodLayout:
    body = spec.body.body()
    return lay_out(spec, body, load_seed(spec.seed.species), spec.com.target, least_wall_mm)


def contents(spec: SeedPodSpec) -> Contents:
    return contents_of(spec, laid_out(spec), load_seed(spec.seed.species), substrate_of(spec))


def part(design: ProductDesign | Assembly, name: str) -> Part:
    assembly = design.assembly if isinstance(design, ProductDesign) else design
    return next(part for part in assembly.parts if part.name == name)


@pytest.fixture(scope="module")
def default_pod() -> ProductDesign:
    return design_seed_pod(pod_spec())


@pytest.fixture(scope="module")
def plugged_pod() -> ProductDesign:
    return design_seed_pod(pod_spec(closure=PLUGGED))


@pytest.fixture(scope="module", params=["default_pod", "plugged_pod"])
def pod(request: pytest.FixtureRequest) -> ProductDesign:
    return request.getfixturevalue(request.param)


def test_the_centre_of_mass_is_on_its_target(pod: ProductDesign) -> None:
    assert pod.assembly.com_residual_um < 0.1
    assert pod.assembly.com_target_mm == tuple(BEST)
    assert pod.placement.costs[0].variable == "core"
    assert not pod.placement.costs[0].at_limit


def test_the_other_kernel_finds_the_same_centre_of_mass(pod: ProductDesign) -> None:
    """The meshes are made by another kernel from the same description; they differ by their sag."""
    moments, masses = np.zeros(3), 0.0
    for piece in pod.assembly.parts:
        if piece.mesh is None:
            mass_g, com = piece.mass_g, piece.com_mm
        else:
            measured = piece.mesh.mass()
            assert measured.volume_mm3 == pytest.approx(piece.volume_mm3, rel=0.01)
            mass_g, com = piece.mass_g * measured.volume_mm3 / piece.volume_mm3, measured.com_mm
        moments, masses = moments + mass_g * np.array(com), masses + mass_g
    assert np.allclose(moments / masses, pod.assembly.com_mm, atol=3e-3)


def test_the_radicle_points_down_over_the_exit_at_the_rest(pod: ProductDesign) -> None:
    """The seed's own x is its radicle; the rest point is under the centre of mass."""
    (way_out,) = pod.openings
    down = -np.array(pod.frame.up)
    assert way_out.state == "rest"
    assert np.allclose(way_out.direction, down, atol=1e-6)
    assert np.allclose(down, [-1.0, 0.0, 0.0])
    seed = part(pod, SEED)
    across = np.subtract(seed.com_mm, way_out.position_mm)
    assert np.linalg.norm(across - (across @ down) * down) < 1e-3
    box = seed.solid.bounding_box()
    assert pytest.approx(6.07, abs=1e-3) == 0.5 * box.size.X
    assert pytest.approx(seed.com_mm[0] - 6.07, abs=1e-3) == box.min.X
    assert pytest.approx(5.79, abs=1e-3) == box.size.Y


def test_masses_are_those_of_the_data(pod: ProductDesign) -> None:
    seed, filling = part(pod, SEED), part(pod, SUBSTRATE)
    assert seed.mass_g == 0.080
    assert seed.volume_mm3 == pytest.approx(np.pi / 6.0 * 12.14 * 5.79 * 3.86, rel=1e-6)
    assert filling.mass_g == pytest.approx(0.16e-3 * filling.volume_mm3)
    for made in (piece for piece in pod.assembly.parts if piece.made):
        assert made.mass_g == pytest.approx(1.24e-3 * made.volume_mm3)


def test_a_chamber_in_two_pinned_halves_has_the_volume_of_its_ellipsoid() -> None:
    """Nothing widens it there: room less seed in closed form."""
    filling = contents(pod_spec(closure=PINNED)).substrate
    assert filling is not None
    room = 4.0 / 3.0 * np.pi * np.prod(0.5 * np.array([12.14, 5.79, 3.86]) + 4.0)
    assert filling.volume_mm3 == pytest.approx(room - np.pi / 6.0 * 12.14 * 5.79 * 3.86, rel=1e-6)
    assert np.allclose(filling.com_mm, BEST, atol=1e-6)


def test_parts_in_place_do_not_overlap(pod: ProductDesign) -> None:
    shell = [piece for piece in pod.assembly.parts if piece.made]
    inside = [part(pod, SEED), part(pod, SUBSTRATE)]
    for first, second in [tuple(shell), tuple(inside), (shell[0], inside[1]), (shell[1], inside[0])]:
        common = first.solid.intersect(second.solid)
        shared = 0.0 if common is None else sum(solid.volume for solid in common.solids())
        assert shared == pytest.approx(0.0, abs=1e-4), (first.name, second.name)


def test_every_surface_inside_is_at_least_the_least_wall_under_the_surface(pod: ProductDesign) -> None:
    least = load_process("fdm").min_wall_mm
    body = pod.assembly.parts[0]
    filling = part(pod, SUBSTRATE)
    corners = np.array([tuple(vertex) for vertex in filling.solid.vertices()])
    assert depth_mm(pod.body, corners).min() > least
    assert body.mesh is not None


def test_the_wall_of_the_layout_is_the_distance_of_chamber_and_surface() -> None:
    """Against the distances of points of the chamber, found in another way."""
    layout = laid_out(pod_spec(closure=PINNED))
    rng = np.random.default_rng(7)
    directions = rng.normal(size=(400, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    depths = depth_mm(layout.body, layout.chamber.position_mm(directions))
    assert depths.min() == pytest.approx(layout.wall_mm, abs=0.05)
    assert depths.min() > layout.wall_mm - 1e-3


def test_the_plug_is_flush_and_sits_on_its_ledge(plugged_pod: ProductDesign) -> None:
    plug = part(plugged_pod, PLUG)
    up = np.array(plugged_pod.frame.up)
    assert plug.mesh is not None
    heights = plug.mesh.vertices_mm @ up
    top = plug.mesh.vertices_mm[heights > heights.min() + 1e-3]
    # Its sides lie under the surface, its outer face on it.
    depth = depth_mm(plugged_pod.body, top[:: max(1, len(top) // 100)])
    assert np.all((np.abs(depth) < 0.06) | (depth > 0.0))
    assert np.sum(np.abs(depth) < 0.06) > 20
    assert plug.print_up == plugged_pod.frame.up


def test_halves_are_printed_on_their_seam(default_pod: ProductDesign) -> None:
    up = np.array(default_pod.frame.up)
    lower, upper = part(default_pod, LOWER), part(default_pod, UPPER)
    assert lower.print_up == tuple(-up)
    assert upper.print_up == tuple(up)
    assert np.dot(lower.com_mm, up) < 0.0 < np.dot(upper.com_mm, up)


def test_a_gap_and_a_step_move_the_upper_half() -> None:
    flat = laid_out(pod_spec(closure=PINNED))
    assert flat.closure is not None
    splits = SplitSpec(), SplitSpec(gap_mm=0.2, step_mm=(0.1, -0.05))
    whole, shell = flat.hollow(), load_material("PLA")
    casings = [SplitCasing(flat.closure, parting_of(flat.frame, split)) for split in splits]
    flat_parts, stepped_parts = ({p.name: p for p in casing.parts(whole, shell)} for casing in casings)
    moved = {name: np.subtract(stepped_parts[name].com_mm, flat_parts[name].com_mm) for name in stepped_parts}
    assert np.allclose(moved.pop(UPPER), flat.frame.point(0.1, -0.05, 0.2), atol=1e-9)
    assert np.allclose(list(moved.values()), 0.0)


@pytest.fixture(scope="module")
def special_pod(tmp_path_factory: pytest.TempPathFactory) -> ProductDesign:
    """A seed of one's own beside the spec, a chamber that is not full, and a seam with gap and step."""
    folder = tmp_path_factory.mktemp("pod")
    text = (template_folder() / "seeds" / "helianthus-annuus.toml").read_text(encoding="utf-8")
    (folder / "own.toml").write_text(text.replace("mass_g = 0.080", "mass_g = 0.090"), encoding="utf-8")
    spec = pod_spec(
        closure=PINNED,
        seed={"species": "own.toml"},
        substrate={"fill": 0.7},
        split={"gap_mm": 0.2, "step_mm": [0.1, -0.05]},
    )
    return design_seed_pod(spec, folder)


@pytest.mark.slow
def test_the_centre_of_mass_stays_whatever_the_seam_does(special_pod: ProductDesign) -> None:
    assert special_pod.assembly.com_residual_um < 0.1
    across = special_pod.frame.matrix() @ np.array(special_pod.placement.core_shift_mm)
    assert abs(across[0]) > 0.05


def test_what_is_uncertain_moves_the_centre_of_mass_as_said(default_pod: ProductDesign) -> None:
    """Against the centre of mass of the parts with the change made; that of a heavier seed is exact in it."""
    scatter, play, filling = default_pod.uncertainties
    seed = part(default_pod, SEED)
    others = tuple(piece for piece in default_pod.assembly.parts if piece is not seed)

    def com(changed: Part) -> np.ndarray:
        return np.array(Assembly("pod", (*others, changed), (0.0, 0.0, 0.0)).com_mm)

    now = np.array(default_pod.assembly.com_mm)
    heavier = com(replace(seed, mass_g=seed.mass_g + 0.020)) - now
    assert np.allclose(heavier, scatter.com_error_mm, rtol=5e-3, atol=1e-9)
    direction = np.array(play.com_error_mm) / np.linalg.norm(play.com_error_mm)
    aside = com(seed.moved(0.5 * direction)) - now
    assert np.allclose(aside, play.com_error_mm, atol=1e-12)
    assert abs(direction @ np.array(default_pod.frame.up)) < 1e-6
    assert "10 % lighter or heavier" in filling.source


def test_a_loose_filling_goes_to_one_side() -> None:
    """A half-filled sphere of radius R has its centroid 3/8 R under the middle, a full one in it."""
    layout = laid_out(pod_spec(closure=PINNED))
    axes = layout.chamber.axes
    hollow = replace(
        layout,
        chamber=Ellipsoid(layout.chamber.center_mm, axes, (8.0, 8.0, 8.0)),
        seed=Ellipsoid(layout.chamber.center_mm, axes, (0.1, 0.1, 0.1)),
    )
    assert loose_shift_mm(hollow, 0.5) == pytest.approx(3.0, rel=0.01)
    assert loose_shift_mm(hollow, 1.0) == pytest.approx(0.0, abs=1e-9)
    assert loose_shift_mm(hollow, 0.9) < loose_shift_mm(hollow, 0.5)


def test_a_part_filled_chamber_is_lighter() -> None:
    full, part_filled = (contents(pod_spec(closure=PINNED, substrate={"fill": fill})) for fill in (1.0, 0.7))
    assert full.substrate is not None
    assert part_filled.substrate is not None
    assert part_filled.substrate.mass_g == pytest.approx(0.7 * full.substrate.mass_g)


def test_a_weighed_density_replaces_that_of_the_material() -> None:
    filling = contents(pod_spec(closure=PINNED, substrate={"density_g_cm3": 0.5})).substrate
    assert filling is not None
    assert filling.mass_g == pytest.approx(0.5e-3 * filling.volume_mm3)


@pytest.mark.slow
def test_a_part_filled_chamber_is_said_to_be_loose(special_pod: ProductDesign) -> None:
    assert any("settles to one side" in item.source for item in special_pod.uncertainties)
    assert any("loose" in note for note in special_pod.notes)


@pytest.mark.slow
def test_a_seed_without_substrate_has_a_pod_too() -> None:
    design = design_seed_pod(pod_spec(closure=PINNED, substrate={"material": "none"}))
    assert all(piece.name != SUBSTRATE for piece in design.assembly.parts)
    assert design.assembly.com_residual_um < 0.1
    assert any("play_mm" in note for note in design.notes)


@pytest.mark.slow
def test_trim_masses_help_where_the_chamber_alone_does_not() -> None:
    """In a pod of 48 mm the chamber of a sunflower seed is too light to be of use alone."""
    large = {"body": {"diameter_mm": 48.0}, "com": {"target": [-0.00822 * 24.0, 0.0, 0.0]}}
    with pytest.raises(GeometryError, match=r"% of the way, with the cavity at its limit"):
        design_seed_pod(pod_spec(closure=PINNED, **large))
    helped = design_seed_pod(
        pod_spec(closure=PINNED, trim={"kind": "balls", "max_diameter_mm": 4.0}, **large)
    )
    balls = [piece for piece in helped.assembly.parts if piece.name.startswith("trim")]
    assert balls
    assert all(ball.standard.startswith("ISO 3290") for ball in balls)
    assert helped.assembly.com_residual_um < 0.1
    for ball in balls:
        common = ball.solid.intersect(part(helped, LOWER).solid)
        assert common is None or sum(solid.volume for solid in common.solids()) < 0.02 * ball.volume_mm3


@pytest.mark.slow
def test_a_press_fit_overlaps_by_its_interference_only() -> None:
    design = design_seed_pod(pod_spec(closure=PRESSED))
    common = part(design, LOWER).solid.intersect(part(design, UPPER).solid)
    shared = sum(solid.volume for solid in common.solids())
    assert 0.0 < shared < 2.0
    assert any("interference" in note or "wider than its socket" in note for note in design.notes)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("species", "diameter"),
    [
        ("cicer-arietinum", 25.0),
        ("moringa-oleifera", 35.0),
        ("jatropha-curcas", 40.0),
        ("quercus-robur", 55.0),
    ],
)
def test_every_species_has_a_pod(species: str, diameter: float) -> None:
    """Made as one piece with a plug, which is much the quickest; in two halves it is laid out only."""
    sized = {
        "body": {"diameter_mm": diameter},
        "seed": {"species": species},
        "com": {"target": [-0.00411 * diameter, 0.0, 0.0]},
        "mesh": {"sag_um": 200.0},
    }
    design = design_seed_pod(pod_spec(closure=PLUGGED, **sized))
    assert design.assembly.com_residual_um < 0.1
    assert design.openings[0].tool.radius_mm == 0.5 * load_seed(species).radicle_diameter_mm
    assert laid_out(pod_spec(**sized)).closure is not None


@pytest.mark.slow
def test_the_same_spec_gives_the_same_pod(plugged_pod: ProductDesign) -> None:
    again = design_seed_pod(pod_spec(closure=PLUGGED))
    assert again.assembly.com_mm == plugged_pod.assembly.com_mm
    for name in (BODY, PLUG):
        mesh, other = part(again, name).mesh, part(plugged_pod, name).mesh
        assert mesh is not None
        assert other is not None
        assert np.array_equal(mesh.vertices_mm, other.vertices_mm)


def test_the_diameter_that_a_refusal_names_is_enough() -> None:
    spec = pod_spec(closure=PINNED, seed={"species": "quercus-robur"})
    with pytest.raises(
        GeometryError, match=r"'Quercus robur' of 27 x 16 x 16 mm.*does not fit a pod of 30 mm"
    ) as caught:
        laid_out(spec)
    needed = float(re.search(r"diameter of (\d+) mm or more", str(caught.value))[1])

    def sized(diameter: float) -> SeedPodSpec:
        target = [-0.00411 * diameter, 0.0, 0.0]
        seed, body = {"species": "quercus-robur"}, {"diameter_mm": diameter}
        return pod_spec(closure=PINNED, seed=seed, body=body, com={"target": target})

    assert laid_out(sized(needed)).wall_mm >= 3.0
    with pytest.raises(GeometryError, match="does not fit"):
        laid_out(sized(needed - 1.0))


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"body": {"diameter_mm": 80.0}}, r"diameter_mm = 80 is not allowed for a seed pod \(10 to 60\)"),
        ({"body": {"diameter_mm": 12.0}}, "does not fit a pod of 12 mm"),
        ({"seed": {"species": "quercus-robur", "clearance_mm": 20.0}}, "take a smaller seed"),
        ({"seed": {"species": "baobab"}}, "no seed 'baobab'"),
        ({"seed": {"play_mm": 5.0}}, "play_mm = 5 is more than seed.clearance_mm = 4"),
        ({"shell": {"wall_mm": 0.5}}, "thinner than the .* mm that the process"),
        ({"shell": {"min_wall_mm": 0.3}}, "thinner than the .* mm that the process"),
        ({"shell": {"material": "gold"}}, "no material 'gold'"),
        ({"substrate": {"material": "mud"}}, "no material 'mud'"),
        ({"substrate": {"fill": 1.2}}, "substrate.fill = 1.2 is not allowed"),
        ({"exit": {"diameter_mm": 4.0}}, "exit of 4 mm lets the seed fall out"),
        ({"closure": {"kind": "screws"}}, "closure"),
        ({"com": {"target": [-1.2, 0.0, 0.0]}}, "% of the way"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(tables: dict[str, dict[str, Any]], said: str) -> None:
    with pytest.raises((SpecError, GeometryError), match=said) as caught:
        design_seed_pod(pod_spec(**{"closure": PINNED, **tables}))
    assert "\n" not in str(caught.value)


def test_a_spec_of_another_product_is_refused() -> None:
    data = tomllib.loads((template_folder() / "seed-pod.toml").read_text(encoding="utf-8"))
    with pytest.raises(SpecError, match="product = 'buoy' is not allowed"):
        parse_model(SeedPodSpec, data | {"product": "buoy"}, "pod")


def test_a_key_that_is_left_out_has_the_value_of_the_template() -> None:
    """As the template promises; the table `[body]` is the user's to fill."""
    text = (template_folder() / "seed-pod.toml").read_text(encoding="utf-8")
    full = parse_model(SeedPodSpec, tomllib.loads(text), "template")
    bare = SeedPodSpec.model_validate({"product": "seed-pod", "body": full.body.model_dump()})
    changed = {name for name in SeedPodSpec.model_fields if getattr(bare, name) != getattr(full, name)}
    assert changed == {"plate"}


@pytest.mark.slow
def test_a_seed_of_ones_own_lies_beside_the_spec(special_pod: ProductDesign, tmp_path: Path) -> None:
    assert part(special_pod, SEED).mass_g == 0.090
    with pytest.raises(GombocError, match="no file"):
        design_seed_pod(pod_spec(closure=PINNED, seed={"species": "other.toml"}), tmp_path)


def test_the_body_of_a_plugged_pod_stands_on_its_exit(plugged_pod: ProductDesign) -> None:
    assert part(plugged_pod, BODY).print_up == plugged_pod.frame.up
