"""Placing the centre of mass: closed forms, the equation of moments anew, optimality by brute force."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.errors import GeometryError, SpecError
from gomboc_cad.products.assembly import center_of_mass
from gomboc_cad.products.common_spec import TrimSpec
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.placing.com_placement import ComPlacement, CoreMove, com_target, converge, place_com
from gomboc_cad.products.placing.moment_balance import Balance, Choice
from gomboc_cad.products.placing.placement_report import placement_document
from gomboc_cad.products.placing.trim import TrimSite, trim_parts
from gomboc_cad.products.placing.trim_choice import HEAVIER, chosen, nearest
from gomboc_cad.solid import hollow
from gomboc_cad.solid.hollow import Cylinder
from gomboc_cad.solid.mass import solid_mass

ORIGIN = (0.0, 0.0, 0.0)
PLASTIC_G_CM3 = 1.24


def ring(count: int, *, max_diameter_mm: float = 8.0, moving: bool = True) -> list[TrimSite]:
    """Vertical sites around a circle, alternately upwards and downwards from the seam."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return [
        TrimSite(
            f"site-{index}",
            (30.0 * np.cos(angle), 30.0 * np.sin(angle), 0.0),
            (0.0, 0.0, 1.0 if index % 2 else -1.0),
            20.0,
            max_diameter_mm,
            moving,
        )
        for index, angle in enumerate(angles)
    ]


def com_anew(placement: ComPlacement, fixed: tuple[float, tuple], lever_g: float) -> np.ndarray:
    """Centre of mass from what was placed: core, masses and holes one by one."""
    mass, com = fixed
    shift = np.array(placement.core_shift_mm)
    moment = mass * np.array(com) + lever_g * shift
    for trim in (*placement.trims, *placement.pockets):
        hole = trim.hole
        removed = PLASTIC_G_CM3 * 1e-3 * np.pi * hole.radius_mm**2 * hole.length_mm
        middle = np.array(hole.base_mm) + 0.5 * hole.length_mm * np.array(hole.direction)
        middle = middle + shift * trim.site.moves_with_core
        moment = moment - removed * middle
        mass -= removed
        if trim.item is not None:
            moment = moment + trim.mass_g * np.array(trim.position_mm)
            mass += trim.mass_g
    return moment / mass


def test_the_core_alone() -> None:
    """M (c − t) + L s = 0."""
    placement = place_com((200.0, (0.1, 0.2, -0.3)), (0.0, 0.1, 0.0), CoreMove(-80.0, 1.5), ring(4))
    np.testing.assert_allclose(placement.core_shift_mm, (0.25, 0.25, -0.75), rtol=1e-12)
    assert placement.trims == placement.pockets == ()
    assert placement.residual_um < 1e-9
    (cost,) = placement.costs
    assert cost.amount == pytest.approx(np.linalg.norm((0.25, 0.25, -0.75)))
    assert cost.com_effect_um == pytest.approx(1e3 * np.linalg.norm((0.1, 0.1, -0.3)))
    assert not cost.at_limit


def test_nothing_to_do() -> None:
    placement = place_com((200.0, (0.1, 0.2, -0.3)), (0.1, 0.2, -0.3), None)
    assert placement.costs == ()
    assert "nothing is moved" in placement.sentence


def test_how_far_the_core_alone_can_go() -> None:
    """A core that may go a quarter of the way brings the COM a quarter of the way."""
    with pytest.raises(
        GeometryError, match=r"0\.4 mm away.* within 0\.3 mm, 25 % of the way.* limit of 0\.25"
    ):
        place_com((200.0, (0.0, 0.0, 0.4)), ORIGIN, CoreMove(-80.0, 0.25))


def test_contents_as_heavy_as_what_they_displace() -> None:
    with pytest.raises(GeometryError, match=r"0 % of the way.*weigh as much as the material it displaces"):
        place_com((200.0, (0.0, 0.0, 0.4)), ORIGIN, CoreMove(0.0, 2.0))


def test_nothing_free_at_all() -> None:
    with pytest.raises(GeometryError, match=r"0 % of the way.*allow trim"):
        place_com((200.0, (0.0, 0.0, 0.4)), ORIGIN, None, ring(3))


def test_the_full_sites_are_named() -> None:
    spec = TrimSpec(kind="balls", max_diameter_mm=3.0)
    with pytest.raises(GeometryError, match=r"site-0: ISO 3290-1 ball 3 at its limit"):
        place_com((200.0, (-2.0, 0.0, 0.0)), ORIGIN, CoreMove(-80.0, 0.5), ring(4), spec)


def test_trim_of_an_unknown_material() -> None:
    spec = TrimSpec(kind="balls", material="unobtainium")
    with pytest.raises(SpecError, match="no material 'unobtainium'"):
        place_com((200.0, (1.0, 0.0, 0.0)), ORIGIN, None, ring(3), spec)


def test_one_ball_on_the_line_through_the_target() -> None:
    """m (p + d) = M c with the hole empty already: the ball slides to where it balances."""
    site = TrimSite("tube", (5.0, 0.0, 0.0), (1.0, 0.0, 0.0), 30.0, 6.0, moves_with_core=False, solid=False)
    placement = place_com(
        (100.0, (-0.15, 0.0, 0.0)), ORIGIN, None, [site], TrimSpec(kind="balls", max_diameter_mm=6.0)
    )
    (trim,) = placement.trims
    assert trim.mass_g * trim.position_mm[0] == pytest.approx(15.0, rel=1e-12)
    # The lightest ball that can be far enough out: 15 g·mm at no more than 35 mm less its radius.
    lightest = next(d for d in (4.0, 4.5, 5.0) if 7.85e-3 * np.pi * d**3 / 6.0 * (35.0 - 0.5 * d) >= 15.0)
    assert trim.diameter_mm == lightest
    assert placement.residual_um < 1e-9


@settings(max_examples=20, deadline=None, derandomize=True)
@given(
    com=st.tuples(*3 * [st.floats(-0.5, 0.5)]),
    lever=st.floats(-120.0, -40.0),
    limit=st.floats(0.3, 2.0),
    kind=st.sampled_from(["balls", "pockets"]),
    moving=st.booleans(),
)
def test_whatever_is_placed_balances_within_its_bounds(
    com: tuple[float, float, float], lever: float, limit: float, kind: str, moving: bool
) -> None:
    fixed, target = (200.0, com), (0.1, -0.05, 0.02)
    sites, spec = ring(4, moving=moving), TrimSpec(kind=kind, max_diameter_mm=8.0)
    try:
        placement = place_com(fixed, target, CoreMove(lever, limit), sites, spec, PLASTIC_G_CM3)
    except GeometryError:
        reject()
    np.testing.assert_allclose(com_anew(placement, fixed, lever), target, atol=1e-5)
    np.testing.assert_allclose(placement.com_mm, com_anew(placement, fixed, lever), atol=1e-9)
    assert placement.residual_um < 0.01
    assert np.linalg.norm(placement.core_shift_mm) <= limit * (1.0 + 1e-9)
    for trim in (*placement.trims, *placement.pockets):
        assert trim.depth_mm >= -1e-9
        assert trim.depth_mm + trim.length_mm <= trim.site.length_mm + 1e-9


def a_balance(com: tuple[float, float, float], limit: float) -> Balance:
    """Three empty tubes for small balls, one of which does not move with the core."""
    spec = TrimSpec(kind="balls", max_diameter_mm=4.0)
    sites = [replace(site, solid=False) for site in ring(3)]
    sites[2] = replace(sites[2], moves_with_core=False)
    placement = place_com((200.0, ORIGIN), ORIGIN, CoreMove(-80.0, limit), sites, spec, PLASTIC_G_CM3)
    return replace(placement.balance, moment_g_mm=tuple(200.0 * np.array(com)))


def every_set(balance: Balance) -> list[tuple[float, int, float]]:
    """Mass, number of pieces and least moment beyond the core's reach of every set of choices."""
    sites = sorted({choice.site.name for choice in balance.choices})
    ways: list[list[Choice | None]] = [
        [None, *(choice for choice in balance.choices if choice.site.name == site)] for site in sites
    ]
    sets = []
    for picks in itertools.product(*ways):
        used = [choice for choice in picks if choice is not None]
        moment = np.array(balance.moment_g_mm)
        moment = moment + sum(choice.moment_g_mm(choice.low_mm, ORIGIN) for choice in used)
        if used:
            slope = np.array([choice.moment_per_mm(choice.low_mm, ORIGIN) for choice in used]).T
            way = [choice.high_mm - choice.low_mm + 1e-12 for choice in used]
            moment = lsq_linear(slope, -moment, (np.zeros(len(used)), way), tol=1e-14).fun
        lever = balance.core.lever_g + sum(choice.moved_mass_g(choice.low_mm) for choice in used)
        beyond = np.linalg.norm(moment) - abs(lever) * balance.core.limit_mm
        sets.append((sum(choice.item_mass_g for choice in used), len(used), float(beyond)))
    return sets


@pytest.mark.parametrize(
    ("com", "limit"),
    [
        ((-0.07, 0.0, 0.0), 0.1),
        ((0.015, -0.06, 0.015), 0.1),
        ((0.045, -0.01, -0.02), 0.05),
        ((0.05, 0.04, 0.06), 0.18),
    ],
)
def test_the_choice_is_what_trying_all_sets_gives(com: tuple[float, float, float], limit: float) -> None:
    balance = a_balance(com, limit)
    reached = [(pieces, mass) for mass, pieces, beyond in every_set(balance) if beyond <= 1e-6]
    lightest = min(mass for _, mass in reached)
    pieces, mass = min((p, m) for p, m in reached if m <= HEAVIER * lightest)
    uses = chosen(balance)
    assert uses is not None
    assert len(uses) == pieces > 0
    assert sum(use.choice.item_mass_g for use in uses) == pytest.approx(mass, rel=1e-3)
    assert balance.off_mm(uses) < 1e-9


@pytest.mark.parametrize("com", [(-0.5, 0.1, 0.0), (0.1, 0.2, 0.4)])
def test_the_nearest_is_what_trying_all_sets_gives(com: tuple[float, float, float]) -> None:
    balance = a_balance(com, 0.1)
    assert chosen(balance) is None
    least = min(beyond for _, _, beyond in every_set(balance))
    uses = nearest(balance)
    left = np.linalg.norm(balance.com_mm(uses)) * balance.mass_with_g(uses)
    assert least > 0.0
    assert left == pytest.approx(least, abs=2e-3 * np.linalg.norm(balance.moment_g_mm))


def test_converging_on_what_really_weighs_something() -> None:
    """Openings that stay when the core moves, and a lever that is not quite what was thought."""
    core = CoreMove(-80.0, 1.5)
    placement = place_com((200.0, (0.1, 0.2, -0.3)), ORIGIN, core)
    calls = []

    def measure(tried: ComPlacement) -> tuple[float, tuple[float, float, float]]:
        calls.append(tried.core_shift_mm)
        shift = np.array(tried.core_shift_mm)
        moment = 200.0 * np.array((0.1, 0.2, -0.3)) - 81.0 * shift - 0.4 * np.array((0.0, 0.0, 40.0))
        moment = moment + 0.05 * shift**2
        return 199.6, tuple(moment / 199.6)

    done = converge(measure, placement)
    assert 2 < len(calls) < 8
    mass, com = measure(done)
    assert np.linalg.norm(com) <= 1e-4
    assert done.residual_um == pytest.approx(1e3 * np.linalg.norm(com))
    assert (done.mass_g, done.com_mm) == (mass, com)


def test_converging_without_a_core_moves_the_trim() -> None:
    site = TrimSite("tube", (5.0, 0.0, 0.0), (1.0, 0.0, 0.0), 30.0, 6.0, moves_with_core=False, solid=False)
    placement = place_com((100.0, (-0.15, 0.0, 0.0)), ORIGIN, None, [site], TrimSpec(kind="balls"))

    def measure(tried: ComPlacement) -> tuple[float, tuple[float, float, float]]:
        (trim,) = tried.trims
        mass = 100.0 + trim.mass_g
        return mass, ((-15.0 + trim.mass_g * trim.position_mm[0] + 0.3) / mass, 0.0, 0.0)

    done = converge(measure, placement)
    assert done.trims[0].standard == placement.trims[0].standard
    assert done.trims[0].position_mm[0] < placement.trims[0].position_mm[0]
    assert done.residual_um <= 0.1


def test_a_measurement_that_never_settles_is_said() -> None:
    placement = place_com((200.0, (0.1, 0.2, -0.3)), ORIGIN, CoreMove(-80.0, 1.5))
    with pytest.raises(GeometryError, match=r"stays .* µm from its target"):
        converge(lambda tried: (200.0, tuple(np.array(tried.core_shift_mm) % 0.01 + 0.01)), placement)


def test_the_targets_of_a_spec() -> None:
    body = catalog()["primary"].with_diameter(60.0)
    assert com_target("centroid", body) == mass_properties(body).com_mm
    assert com_target((1.0, 2.0, 3.0), body) == (1.0, 2.0, 3.0)
    small, large = (np.array(com_target("best", body.with_diameter(d))) for d in (50.0, 100.0))
    np.testing.assert_allclose(large, 2.0 * small, rtol=1e-12)
    np.testing.assert_allclose(large, (-0.411, 0.0, 0.0), atol=2e-3)


def test_the_document_says_all_of_it() -> None:
    spec = TrimSpec(kind="balls", max_diameter_mm=8.0)
    placement = place_com(
        (200.0, (0.5, 0.4, -0.3)), ORIGIN, CoreMove(-80.0, 1.5), ring(4), spec, PLASTIC_G_CM3
    )
    document = placement_document(placement)
    assert [cost["variable"].split(":")[0] for cost in document["costs"]] == [
        "core",
        *(trim.site.name for trim in placement.trims),
    ]
    assert document["trims"][0]["standard"].startswith("ISO 3290-1 ball")
    assert document["residual_um"] < 0.01
    for cost in placement.costs:
        assert f"{abs(cost.mass_g):.3g} g" in document["sentence"] or cost.variable == "core"


def test_on_solids_that_were_made_and_weighed() -> None:
    """A payload off the middle of a hollow body is balanced by balls in drilled columns."""
    body = catalog()["primary"].with_diameter(60.0)
    columns = tuple(
        Cylinder((x, y, -40.0), (0.0, 0.0, 1.0), 5.0, 80.0)
        for x, y in ((14.0, 0.0), (-7.0, 12.0), (-7.0, -12.0))
    )
    sites = [
        TrimSite(f"column-{index}", (*column.base_mm[:2], 9.0), (0.0, 0.0, -1.0), 16.0, 7.0)
        for index, column in enumerate(columns)
    ]
    plastic, payload_g, payload_mm = load_material("PLA"), 6.0, np.array((-6.0, 2.0, -4.0))

    def weigh(placement: ComPlacement | None) -> tuple[float, tuple[float, float, float]]:
        shift = placement.core_shift_mm if placement else ORIGIN
        holes = placement.core_holes if placement else ()
        shell = solid_mass(hollow.brep(hollow.HollowBody(body, 3.0, shift, columns, holes)))
        parts = [(plastic.mass_g(shell.volume_mm3), shell.com_mm), (payload_g, payload_mm + shift)]
        parts += [(part.mass_g, part.com_mm) for part in trim_parts(placement.trims if placement else ())]
        return sum(mass for mass, _ in parts), tuple(center_of_mass(parts))

    void = hollow.void_properties(hollow.HollowBody(body, 3.0, bosses=columns))
    core = CoreMove(payload_g - plastic.mass_g(void.volume_mm3), 0.4)
    target = com_target("centroid", body)
    placement = place_com(weigh(None), target, core, sites, TrimSpec(kind="balls"), plastic.density_g_cm3)
    assert placement.trims
    _, predicted = weigh(placement)
    np.testing.assert_allclose(predicted, target, atol=1e-3)
    done = converge(weigh, placement)
    assert 1e3 * np.linalg.norm(np.subtract(weigh(done)[1], target)) <= 0.1
