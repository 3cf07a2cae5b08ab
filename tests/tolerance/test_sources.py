"""Sources one at a time: what each does to a product, against closed forms and against its own figures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ndtr

from gomboc_cad.body import Body, FourierSloan
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.process import Process, form_amplitudes_mm, load_process
from gomboc_cad.tolerance.com_model import MassModel, WeighedPart
from gomboc_cad.tolerance.product_study import ProductStudy, body_study
from gomboc_cad.tolerance.sources import glue_sources, load_sources, process_sources, seam_sources
from gomboc_cad.tolerance.variants import Nominal, Variants
from gomboc_cad.tolerance.weighing import GlueLine, machine_axes

SPHERE = Body("sphere", FourierSloan(0.0), 10.0)
UP: Vector = (0.0, 0.0, 1.0)
OUTER, INNER = 10.0, 8.0
VOLUME, VOID = 2.0 / 3.0 * np.pi * (OUTER**3 - INNER**3), 2.0 / 3.0 * np.pi * INNER**3
ALL_ROWS = np.linspace(0.01, 0.99, 21)


def process_with(**figures: float) -> Process:
    """FDM with other figures: `process_with(shrinkage__mean_x_percent=1.0)`."""
    data: dict[str, Any] = load_process("fdm").model_dump()
    for key, value in figures.items():
        table, name = key.split("__")
        data["tolerances"][table][name] = {"value": value, "range": (value, value), "source": "this test"}
    return Process.model_validate(data)


def half(name: str, height: float, upper: bool) -> WeighedPart:
    spread = 5.0 * np.diag([1.0, 1.0, 2.0])
    return WeighedPart(
        name,
        "shell",
        1e-3 * VOLUME,
        (0.0, 0.0, height),
        upper=upper,
        build_up=UP,
        height_mm=10.0,
        spread_mm2=spread,
        volume_mm3=VOLUME,
        void_share=VOID / VOLUME,
    )


PARTS = (
    half("lower", -4.0, upper=False),
    half("upper", 4.0, upper=True),
    WeighedPart("board", "payload", 0.5, (1.0, 0.0, -6.0), carrier="lower"),
    WeighedPart("screw", "fastener", 0.1, (6.0, 0.0, 1.0), upper=True, carrier="upper"),
    WeighedPart("ball", "trim", 0.2, (0.0, 5.0, -5.0), carrier="lower"),
    WeighedPart("valve", "fastener", 0.3, (0.0, -9.0, 1.0), upper=True),
    WeighedPart("glue", "glue", 0.0, (0.0, 0.0, 0.0)),
)
TOTAL_G = sum(part.mass_g for part in PARTS)
LINE = GlueLine(60.0, np.zeros(3), np.array([[4.5, 0.0, 0.0], [0.0, 4.5, 0.0]]))
LOADS = (UncertainLoad("board", 0.05, 0.4),)


def study(process: Process, *names: str) -> ProductStudy:
    """A hollow sphere of two halves with something of every kind in it, and only some of the sources."""
    contributors = (
        *process_sources(process, PARTS, SPHERE.diameter_mm, 3),
        *load_sources(LOADS, PARTS, np.eye(3)),
        *seam_sources(process, np.eye(3)),
        *glue_sources(process, 6, LINE),
    )
    masses = MassModel.of(PARTS, SPHERE, 3)
    com = tuple(masses.com_mm(masses.no_deviations())[0])
    whole = ProductStudy(
        "sphere", process.name, Nominal(SPHERE, com), masses, machine_axes(UP), (0.0, 0.0, 0.0), contributors
    )
    return whole.only(*names) if names else whole


def at(model: ProductStudy, *draws: float) -> Variants:
    """The variant of given draws: in standard deviations of a normal law, in half-widths of a uniform one."""
    laws = [law.law for law in model.contributors for _ in range(law.source.dimensions)]
    row = [
        ndtr(draw) if law == "normal" else 0.5 * (draw + 1.0) for draw, law in zip(draws, laws, strict=True)
    ]
    return model.variants(np.array([row]))


def moved_mm(model: ProductStudy, *draws: float) -> np.ndarray:
    return at(model, *draws).com_mm[0] - np.array(model.nominal.com_mm)


def com_of(masses: dict[str, float] | None = None, places: dict[str, Vector] | None = None) -> np.ndarray:
    """Centre of mass of the parts with some heavier by grams and some displaced, by its definition."""
    weights = [part.mass_g + (masses or {}).get(part.name, 0.0) for part in PARTS]
    spots = [np.add(part.com_mm, (places or {}).get(part.name, (0.0, 0.0, 0.0))) for part in PARTS]
    return np.average(spots, axis=0, weights=weights)


def test_density_of_each_half() -> None:
    model = study(process_with(density__scatter_percent=2.0), "shell_density")
    expected = com_of({"lower": 0.02 * PARTS[0].mass_g, "upper": -0.04 * PARTS[1].mass_g})
    assert at(model, 1.0, -2.0).com_mm[0] == pytest.approx(expected, abs=1e-13)


def test_density_gradient_moves_a_part_by_its_second_moment() -> None:
    """1 % over a height of 10 mm, with ∫z² dV / V = 10 mm²: 0.01 mm."""
    process = process_with(density__gradient_mean_percent=0.0, density__gradient_scatter_percent=1.0)
    expected = com_of(places={"lower": (0.0, 0.0, 0.01), "upper": (0.0, 0.0, -0.02)})
    assert at(study(process, "density_gradient"), 1.0, -2.0).com_mm[0] == pytest.approx(expected, abs=1e-13)


def test_density_gradient_of_a_massive_sphere() -> None:
    """`ρ (1 + γ z/2R)` moves the centre by γR/10."""
    process = process_with(density__gradient_mean_percent=3.0, density__gradient_scatter_percent=0.0)
    model = body_study(SPHERE, process, com_mm=(0.0, 0.0, -1.0), build_up=UP).only("density_gradient")
    assert moved_mm(model, 0.3) == pytest.approx([0.0, 0.0, 0.03], abs=1e-9)


def test_core_shift_moves_the_void_and_what_sits_on_the_core() -> None:
    """The halves of a hollow sphere go the other way, by V₀/V; the valve stays in the outer surface."""
    model = study(process_with(placement__core_scatter_mm=0.1), "core_shift")
    away = -0.1 * VOID / VOLUME
    on_lower = com_of(places={"lower": (away, 0.0, 0.0), "board": (0.1, 0.0, 0.0), "ball": (0.1, 0.0, 0.0)})
    on_upper = com_of(places={"upper": (0.0, 0.0, away), "screw": (0.0, 0.0, 0.1)})
    assert at(model, 1.0, 0, 0, 0, 0, 0).com_mm[0] == pytest.approx(on_lower, abs=1e-13)
    assert at(model, 0, 0, 0, 0, 0, 1.0).com_mm[0] == pytest.approx(on_upper, abs=1e-13)


def test_core_shift_of_a_hollow_sphere_by_its_volumes() -> None:
    """Both cores displaced by d: the shell's centre goes by `−d r³/(R³ − r³)`."""
    model = study(process_with(placement__core_scatter_mm=0.1), "core_shift")
    model_of_halves = MassModel.of(PARTS[:2], SPHERE, 2)
    deviations = model.deviations(np.array([[ndtr(1.0), 0.5, 0.5, ndtr(1.0), 0.5, 0.5]]))
    blank = model_of_halves.no_deviations()
    blank.place_mm[0] = deviations.place_mm[0, :2]
    expected = -0.1 * INNER**3 / (OUTER**3 - INNER**3)
    assert model_of_halves.com_mm(blank)[0] == pytest.approx([expected, 0.0, 0.0], abs=1e-13)


def test_masses_and_places_of_what_is_put_in() -> None:
    process = process_with(
        mass__bought_scatter_percent=1.0,
        placement__insert_scatter_mm=0.2,
        placement__payload_scatter_mm=0.3,
    )
    fasteners = at(study(process, "fastener_mass"), 1.0, -1.0).com_mm[0]
    assert fasteners == pytest.approx(com_of({"screw": 0.001, "valve": -0.003}), abs=1e-13)
    assert at(study(process, "trim_mass"), 2.0).com_mm[0] == pytest.approx(com_of({"ball": 0.004}), abs=1e-13)
    placed = at(study(process, "fastener_place"), 0, 0, 0, 1.0, 0, -1.0).com_mm[0]
    assert placed == pytest.approx(com_of(places={"valve": (0.2, 0.0, -0.2)}), abs=1e-13)
    trim = at(study(process, "trim_place"), 0, 1.0, 0).com_mm[0]
    assert trim == pytest.approx(com_of(places={"ball": (0.0, 0.2, 0.0)}), abs=1e-13)
    seated = at(study(process, "payload_place"), 1.0, 0, 0).com_mm[0]
    assert seated == pytest.approx(com_of(places={"board": (0.3, 0.0, 0.0)}), abs=1e-13)


def test_loads_reach_their_half_widths_and_no_further() -> None:
    process = load_process("fdm")
    heavier = at(study(process, "mass_of_board"), 1.0).com_mm[0]
    assert heavier == pytest.approx(com_of({"board": 0.05}), abs=1e-13)
    off = at(study(process, "place_of_board"), 1.0, -1.0, 0.5).com_mm[0]
    assert off == pytest.approx(com_of(places={"board": (0.4, -0.4, 0.2)}), abs=1e-13)


def test_seam_moves_the_upper_part_and_its_contents() -> None:
    process = process_with(seam__step_scatter_mm=0.1, seam__gap_mean_mm=0.05, seam__gap_scatter_mm=0.02)
    variants = at(study(process, "seam_step", "seam_gap"), 1.0, -2.0, 1.0)
    shift = (0.1, -0.2, 0.07)
    assert variants.upper_shift_mm[0] == pytest.approx(shift, abs=1e-13)
    expected = com_of(places=dict.fromkeys(("upper", "screw", "valve"), shift))
    assert variants.com_mm[0] == pytest.approx(expected, abs=1e-13)


def test_glue_adds_its_mass_where_the_seam_is() -> None:
    process = process_with(
        mass__glue_mean_mg_per_mm=2.0, mass__glue_scatter_percent=10.0, mass__glue_unevenness_percent=20.0
    )
    found = at(study(process, "glue_mass", "glue_unevenness"), 1.0, 1.0, -1.0).com_mm[0]
    expected = com_of({"glue": 0.132}, {"glue": (0.9, -0.9, 0.0)})
    assert found == pytest.approx(expected, abs=1e-13)


def test_shrinkage_along_the_machines_axes() -> None:
    build = (0.0, 0.6, 0.8)
    process = process_with(
        shrinkage__mean_x_percent=0.1,
        shrinkage__mean_y_percent=0.2,
        shrinkage__mean_build_percent=0.5,
        shrinkage__scatter_x_percent=0.0,
        shrinkage__scatter_y_percent=0.0,
        shrinkage__scatter_build_percent=0.1,
    )
    model = body_study(SPHERE, process, com_mm=(0.0, 0.0, -1.0), build_up=build).only("shrinkage")
    stretch = at(model, 3.0, 3.0, 2.0).stretch[0]
    factors, axes = np.linalg.eigh(stretch)
    assert factors == pytest.approx([0.993, 0.998, 0.999], abs=1e-12)
    assert abs(axes[:, 0] @ build) == pytest.approx(1.0, abs=1e-12)
    assert abs(axes[0, 2]) == pytest.approx(abs(machine_axes(build)[0, 0]), abs=1e-9)
    # A body in one piece goes to S c exactly.
    assert at(model, 3.0, 3.0, 2.0).com_mm[0] == pytest.approx(stretch @ [0.0, 0.0, -1.0], abs=1e-13)


@pytest.mark.parametrize("name", ["fdm", "cnc-5axis"])
def test_form_error_has_the_spectrum_of_the_process(name: str) -> None:
    process, degree = load_process(name), 7
    model = body_study(SPHERE, process, com_mm=(0.0, 0.0, -1.0), build_up=UP, degree=degree).only(
        "form_error"
    )
    rows = np.random.default_rng(7).random((20_000, model.dimensions))
    squares = (model.variants(rows).form_mm ** 2).mean(axis=0)
    degrees = np.arange(2, degree + 1)
    power = [squares[n * n - 4 : (n + 1) ** 2 - 4].sum() for n in degrees]
    assert np.sqrt(power) == pytest.approx(form_amplitudes_mm(process, 20.0, degrees), rel=0.02)
    assert model.sources[0].size == pytest.approx(np.sqrt(np.sum(power)), rel=0.02)


def test_scatters_are_standard_deviations_and_half_widths_are_bounds() -> None:
    rows = np.random.default_rng(8).random((40_000, 1))
    process = process_with(seam__gap_mean_mm=0.05, seam__gap_scatter_mm=0.02)
    gap = study(process, "seam_gap").variants(rows).upper_shift_mm[:, 2]
    assert (gap.mean(), gap.std()) == pytest.approx((0.05, 0.02), rel=0.02)
    grams = study(process, "mass_of_board").deviations(rows).mass_g[:, 2]
    assert np.abs(grams).max() <= 0.05
    assert grams.std() == pytest.approx(0.05 / np.sqrt(3.0), rel=0.02)


def test_every_source_says_where_its_figure_is_from() -> None:
    model = study(load_process("fdm"))
    for source in model.sources:
        assert source.basis
        assert source.text
        assert source.unit
    assert len({source.name for source in model.sources}) == len(model.sources)
    assert "rms" in next(source.unit for source in model.sources if source.name == "seam_gap")
