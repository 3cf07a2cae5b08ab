"""Floating states and censuses: invariances, derivatives, waterlines and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import tangent_frame, unit
from gomboc_cad.errors import GeometryError
from gomboc_cad.hydrostatics import SEA_WATER, Water, floating_census, floating_state
from gomboc_cad.hydrostatics.immersion import immerse
from gomboc_cad.hydrostatics.surface import wetted_surface
from tests.equilibria.polyhedra import Array, Mesh, hull_mesh, platonic
from tests.hydrostatics.hulls import UNIT_WATER, ball, box, census_with, float_with, mass_for, sloan

COM = np.array([0.1, -0.2, 0.15])


def directions(seed: int, count: int) -> Array:
    return unit(np.random.default_rng(seed).normal(size=(count, 3)))


def rotation(seed: int) -> Array:
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return turn * np.linalg.det(turn)


def two_boxes() -> Mesh:
    """A catamaran: two hulls that do not touch."""
    hull = box(8.0, 1.0, 2.0)
    count = len(hull.vertices)
    apart = np.array([0.0, 3.0, 0.0])
    return Mesh(
        np.concatenate([hull.vertices - apart, hull.vertices + apart]),
        np.concatenate([hull.faces, hull.faces + count]),
    )


@pytest.mark.parametrize("mesh", [box(3.0, 2.0, 1.0), sloan(3, 2.0), two_boxes()])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.93])
def test_the_righting_arm_and_gm_are_derivatives_of_the_energy(mesh: Mesh, share: float) -> None:
    """Central differences along great circles, in both heel directions."""
    for up in directions(3, 4):
        state = float_with(mesh, share, COM, up)
        torque = np.array(state.restoring_torque_n_mm)
        weight_n = 9.80665e-3 * mass_for(mesh, share)
        step = 1e-4
        slopes = []
        for heel_axis, gm in zip(state.heel_axes, state.gm_mm, strict=True):
            along = np.cross(heel_axis, up)
            ahead, behind = (
                float_with(mesh, share, COM, np.cos(step) * up + sign * np.sin(step) * along)
                for sign in (1.0, -1.0)
            )
            middle = state.com_over_buoyancy_mm
            energies = ahead.com_over_buoyancy_mm, behind.com_over_buoyancy_mm
            slopes.append((energies[0] - energies[1]) / (2.0 * step))
            assert (energies[0] - 2.0 * middle + energies[1]) / step**2 == pytest.approx(gm, abs=2e-2)
            # Turning the part by an angle about an axis turns the direction up, seen from it, back.
            assert torque @ np.array(heel_axis) == pytest.approx(weight_n * slopes[-1], abs=1e-6 * weight_n)
        assert np.hypot(*slopes) == pytest.approx(state.righting_arm_mm, abs=1e-6)


@pytest.mark.parametrize("share", [1e-4, 0.02, 0.5, 0.98, 0.9999])
def test_the_displaced_volume_is_that_of_the_clipped_part(share: float) -> None:
    """The convex hull of the corners under water and of the waterline is the part under water."""
    mesh = hull_mesh(sloan(3, 2.0).vertices)
    for up in directions(5, 6):
        state = float_with(mesh, share, COM, up)
        depth = mesh.vertices @ up
        wet = mesh.vertices[depth < depth.min() + state.draft_mm]
        clipped = mesh_mass(*hull_mesh(np.concatenate([wet, *state.waterline_mm])))
        assert clipped.volume_mm3 == pytest.approx(state.displaced_volume_mm3, rel=1e-6)
        assert clipped.com_mm == pytest.approx(state.center_of_buoyancy_mm, abs=1e-8)


def test_the_parts_above_and_below_the_water_balance() -> None:
    """Turned upside down with the rest of its volume under water, a part has the same waterplane."""
    mesh = sloan(3, 2.0)
    up = directions(8, 1)[0]
    below, above = float_with(mesh, 0.3, COM, up), float_with(mesh, 0.7, COM, -up)
    assert above.waterplane_area_mm2 == pytest.approx(below.waterplane_area_mm2)
    assert above.second_moments_mm4 == pytest.approx(below.second_moments_mm4)
    assert above.center_of_flotation_mm == pytest.approx(below.center_of_flotation_mm)
    centroid = 0.3 * np.array(below.center_of_buoyancy_mm) + 0.7 * np.array(above.center_of_buoyancy_mm)
    assert centroid == pytest.approx(np.array(mesh_mass(*mesh).com_mm), abs=1e-9)


def test_each_hull_of_a_catamaran_has_its_waterline() -> None:
    state = float_with(two_boxes(), 0.4, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert len(state.waterline_mm) == 2
    area = 0.0
    for loop in state.waterline_mm:
        assert loop[:, 2] == pytest.approx(-0.2)
        x, y = loop[:, 0], loop[:, 1]
        area += 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area == pytest.approx(state.waterplane_area_mm2) == pytest.approx(16.0)
    # Two strips at ±3: each its own B³ L / 12 and A d².
    assert state.second_moments_mm4 == pytest.approx(
        sorted([2.0 * 8.0**3 / 12.0, 2.0 * (8.0 / 12.0 + 8.0 * 9.0)])
    )


def test_many_orientations_at_once_and_bad_guesses_change_nothing() -> None:
    surface = wetted_surface(*sloan(3, 2.0))
    ups = directions(2, 40)
    volume = 0.4 * surface.volume_mm3
    alone = [immerse(surface, up[None], volume) for up in ups]
    for guess in (None, np.full(40, 0.4), np.linspace(-9.0, 9.0, 40), np.linspace(-0.5, 0.5, 40)):
        together = immerse(surface, ups, volume, guess)
        for one, field in zip(zip(*alone, strict=True), together, strict=True):
            assert np.concatenate(one) == pytest.approx(field, abs=1e-8)
        # The volume is found to 1e-9 only; the last step in closed form does the rest.
        buoyancy = np.concatenate([single.buoyancy_mm for single in alone])
        assert together.buoyancy_mm == pytest.approx(buoyancy, abs=1e-13)


@given(seed=st.integers(0, 1000), scale=st.floats(0.1, 50.0))
@settings(max_examples=15, deadline=None)
def test_states_turn_and_scale_with_the_part(seed: int, scale: float) -> None:
    mesh, turn = sloan(2, 2.0), rotation(seed)
    moved = Mesh(scale * mesh.vertices @ turn.T + (3.0, -1.0, 2.0), mesh.faces)
    up = directions(seed, 1)[0]
    state = float_with(mesh, 0.6, COM, up)
    other = float_with(moved, 0.6, scale * turn @ COM + (3.0, -1.0, 2.0), turn @ up)
    assert other.draft_mm == pytest.approx(scale * state.draft_mm)
    assert other.gm_mm == pytest.approx(scale * np.array(state.gm_mm), abs=1e-8 * scale)
    assert other.energy_mj == pytest.approx(scale**4 * state.energy_mj)
    torque = scale**4 * turn @ np.array(state.restoring_torque_n_mm)
    assert other.restoring_torque_n_mm == pytest.approx(torque, abs=1e-9 * scale**4)


@pytest.mark.parametrize("seed", range(3))
def test_a_census_turns_with_the_part(seed: int) -> None:
    mesh, turn = sloan(3), rotation(seed)
    com = np.array([-1.5, 0.4, 0.2])
    census = census_with(mesh, 0.45, com)
    other = census_with(Mesh(mesh.vertices @ turn.T, mesh.faces), 0.45, turn @ com)
    assert (other.stable, other.saddles, other.unstable) == (census.stable, census.saddles, census.unstable)
    for pose, turned in zip(census.poses, other.poses, strict=True):
        assert turned.kind == pose.kind
        assert turned.state.com_over_buoyancy_mm == pytest.approx(pose.state.com_over_buoyancy_mm, abs=1e-6)
    assert other.depth_mm == pytest.approx(census.depth_mm, rel=1e-4)


@pytest.mark.parametrize("sides", [(1.0, 1.3, 2.1), (3.0, 2.5, 1.0)])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.85])
def test_counted_poses_are_those_of_a_brute_force_search(
    sides: tuple[float, float, float], share: float
) -> None:
    """Descents of the sampled energy from a thousand random orientations find the same minima."""
    mesh = box(*sides)
    census = census_with(mesh, share)
    assert census.evidence.complete
    found = brute_force_minima(mesh, share)
    ours = np.array([pose.up for pose in census.poses if pose.kind == "stable"])
    assert len(found) == len(ours)
    for up in found:
        assert np.linalg.norm(ours - up, axis=1).min() < 2e-3


def brute_force_minima(mesh: Mesh, share: float) -> Array:
    surface = wetted_surface(*mesh)
    volume = share * surface.volume_mm3

    def energies(ups: Array) -> Array:
        return -np.einsum("nx,nx->n", immerse(surface, ups, volume).buoyancy_mm, ups)

    rng = np.random.default_rng(1)
    ups = unit(rng.normal(size=(400, 3)))
    best, step = energies(ups), np.full(400, 0.3)
    for _ in range(150):
        first, second = tangent_frame(ups)
        angle = rng.uniform(0.0, 2.0 * np.pi, 400)
        side = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
        better = np.zeros(400, dtype=bool)
        for sign in (1.0, -1.0):
            there = unit(ups + sign * step[:, None] * side)
            value = energies(there)
            gain = value < best
            ups[gain], best[gain] = there[gain], value[gain]
            better |= gain
        step *= np.where(better, 1.2, 0.85)
    kept: list[Array] = []
    for up in ups[np.argsort(best)]:
        if all(np.linalg.norm(up - other) > 0.05 for other in kept):
            kept.append(up)
    return np.array(kept)


def test_a_higher_barrier_leaves_shallow_poses_out() -> None:
    every, deep = (census_with(box(5.0, 1.0, 1.0), 0.25, barrier_mm=b) for b in (0.0, 0.0022))
    shallowest = min(pose.barrier_mm or 0.0 for pose in every.poses if pose.kind == "stable")
    assert (every.stable, every.evidence.highest_uncounted_mm) == (8, None)
    assert shallowest < 0.0022
    assert deep.stable < every.stable
    assert deep.evidence.highest_uncounted_mm == pytest.approx(shallowest)


def test_a_coarser_sampling_finds_the_same_poses() -> None:
    coarse, fine = (census_with(box(3.0, 2.0, 1.3), 0.5, level=level) for level in (3, 5))
    assert fine.evidence.resolution_mm < coarse.evidence.resolution_mm / 10.0
    assert [p.kind for p in coarse.poses] == [p.kind for p in fine.poses]
    for one, other in zip(coarse.poses, fine.poses, strict=True):
        assert one.state.com_over_buoyancy_mm == pytest.approx(other.state.com_over_buoyancy_mm)


def test_a_part_that_is_too_heavy_sinks_with_both_figures() -> None:
    with pytest.raises(
        GeometryError, match=r"sinks: it weighs 30 g and displaces at most 24\.6 g of sea water"
    ):
        floating_state(*box(40.0, 30.0, 20.0), 30.0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(GeometryError, match="sinks"):
        floating_census(*box(40.0, 30.0, 20.0), 24.6, (0.0, 0.0, 0.0), SEA_WATER)


BOX = box(2.0, 2.0, 2.0)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"faces": BOX.faces[1:]}, "not watertight"),
        ({"faces": np.concatenate([BOX.faces[:1, ::-1], BOX.faces[1:]])}, "not watertight"),
        ({"faces": BOX.faces[:, ::-1]}, "inside out"),
        ({"faces": BOX.faces + 1}, "does not exist"),
        ({"faces": np.empty((0, 3), dtype=int)}, "no triangles"),
        ({"vertices": BOX.vertices * np.nan}, "finite"),
        ({"vertices": BOX.vertices[:, :2]}, "shape"),
        ({"mass_g": 0.0}, "positive number of grams"),
        ({"mass_g": float("nan")}, "positive number of grams"),
        ({"com_mm": (0.0, np.inf, 0.0)}, "centre of mass"),
        ({"com_mm": (0.0, 0.0)}, "centre of mass"),
        ({"up": (0.0, 0.0, 0.0)}, "must not be zero"),
        ({"up": "up"}, "three finite numbers"),
    ],
)
def test_bad_input_gets_one_sentence(change: dict[str, object], complaint: str) -> None:
    given = {
        "vertices": BOX.vertices,
        "faces": BOX.faces,
        "mass_g": 0.004,
        "com_mm": (0, 0, 0),
        "up": (0, 0, 1),
    }
    with pytest.raises(GeometryError, match=complaint):
        floating_state(**(given | change), water=UNIT_WATER)  # type: ignore[arg-type]


@pytest.mark.parametrize("options", [{"level": 1}, {"level": 9}, {"barrier_mm": -1.0}, {"sag_mm": np.inf}])
def test_bad_options_of_a_census_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(GeometryError, match="must be"):
        census_with(BOX, 0.5, **options)


def test_water_needs_a_density() -> None:
    with pytest.raises(GeometryError, match="density of brine"):
        Water("brine", 0.0)


@pytest.mark.parametrize(("faces", "group"), [(6, 24), (8, 24), (12, 60), (20, 60)])
def test_a_platonic_solid_floats_as_symmetrically_as_it_is(faces: int, group: int) -> None:
    """By symmetry the poses of one depth are a multiple of an orbit of its rotations."""
    census = census_with(hull_mesh(platonic(faces)), 0.5)
    assert census.evidence.complete
    depths = np.array([pose.state.com_over_buoyancy_mm for pose in census.poses if pose.kind == "stable"])
    for depth in depths:
        alike = int(np.isclose(depths, depth, rtol=0.0, atol=1e-9).sum())
        # An orbit has as many members as the group over the rotations that keep one: 1, 2, 3, 4 or 5.
        assert any(alike % (group // order) == 0 for order in (1, 2, 3, 4, 5) if group % order == 0)


def test_a_ball_says_up_to_which_barrier_it_is_neutral() -> None:
    """The barriers of the facets stay below the sag, which is what the census ignores."""
    census = census_with(ball(3), 0.4, (0.0, 0.0, 0.0))
    assert census.energy_range_mm < census.evidence.sag_mm
    assert f"{census.evidence.barrier_mm:.4g} mm" in census.reason
