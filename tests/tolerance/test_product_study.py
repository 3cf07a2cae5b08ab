"""Studies of a bare body and of a real product: without errors the design, with one what that error does."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from gomboc_cad import catalog
from gomboc_cad.body import make_body
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GombocError, NotConvexError, SpecError
from gomboc_cad.products.assembly import Assembly, Part
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.imu_housing.recipe import HousingDesign
from gomboc_cad.products.process import load_process, process_names
from gomboc_cad.products.recipes import design_product
from gomboc_cad.products.spec import load_spec
from gomboc_cad.solid import hollow
from gomboc_cad.tolerance.product_parts import weighed_parts
from gomboc_cad.tolerance.product_study import ProductStudy, body_study, product_study

STEP_MM, GAP_MM = (0.05, -0.02), 0.1


def quick_design(product: str, **changes: dict[str, object]) -> ProductDesign:
    """A template's product with some keys changed, and without what costs time and has no mass."""
    spec = load_spec(product)
    changes = {"com": {"target": "centroid"}, "mesh": {"sag_um": 500.0}, **changes}
    tables = {name: getattr(spec, name).model_copy(update=keys) for name, keys in changes.items()}
    return design_product(spec.model_copy(update=tables))


@pytest.fixture(scope="module")
def bare() -> ProductStudy:
    return body_study(catalog()["primary"], load_process("sla"), com_error_mm=0.01, degree=6)


@pytest.fixture(scope="module")
def housing() -> HousingDesign:
    """The default housing with a seam that does not fit."""
    split = {"step_mm": STEP_MM, "gap_mm": GAP_MM}
    design = quick_design("imu-housing", split=split, mark={"text": ""})
    assert isinstance(design, HousingDesign)
    return design


@pytest.fixture(scope="module")
def housing_study(housing: HousingDesign) -> ProductStudy:
    return product_study(housing, load_process("fdm"), degree=4)


def random_rows(study: ProductStudy, count: int) -> np.ndarray:
    return np.random.default_rng(2).random((count, study.dimensions))


def without_errors(study: ProductStudy) -> ProductStudy:
    return study.scaled({source.name: 0.0 for source in study.sources})


@pytest.mark.parametrize("process", process_names())
def test_a_body_without_errors_is_exactly_the_nominal_one(process: str) -> None:
    study = body_study(catalog()["primary"], load_process(process), degree=3)
    variants = without_errors(study).variants(random_rows(study, 5))
    assert np.array_equal(variants.com_mm, np.tile(study.nominal.com_mm, (5, 1)))
    assert np.array_equal(variants.stretch, np.tile(np.eye(3), (5, 1, 1)))
    assert not variants.form_mm.any()
    assert not variants.upper_shift_mm.any()


def test_a_product_without_errors_is_exactly_the_design(
    housing: HousingDesign, housing_study: ProductStudy
) -> None:
    variants = without_errors(housing_study).variants(random_rows(housing_study, 3))
    assert np.array_equal(variants.com_mm, np.tile(housing_study.nominal.com_mm, (3, 1)))
    assert np.array_equal(variants.stretch, np.tile(np.eye(3), (3, 1, 1)))
    assert housing_study.nominal.com_mm == pytest.approx(housing.assembly.com_mm, abs=1e-13)
    designed = housing.frame.point(*STEP_MM, GAP_MM)
    assert variants.upper_shift_mm == pytest.approx(np.tile(designed, (3, 1)), abs=1e-15)


def test_the_median_is_the_nominal_body_with_its_mean_errors(bare: ProductStudy) -> None:
    middle = bare.variants(np.full((1, bare.dimensions), 0.5))
    means = dict.fromkeys(("form_error", "com_error"), 0.0)
    assert middle.com_mm == pytest.approx(
        bare.scaled(means).variants(np.full((1, bare.dimensions), 0.5)).com_mm, abs=1e-14
    )
    assert not middle.form_mm.any()


def test_rows_do_not_depend_on_their_batch(housing_study: ProductStudy) -> None:
    rows = random_rows(housing_study, 64)
    together = housing_study.variants(rows)
    for some in (slice(0, 1), slice(40, 41), slice(5, 60, 9), slice(32, 64)):
        apart = housing_study.variants(rows[some])
        for name, value in vars(together).items():
            assert np.array_equal(getattr(apart, name), value[some]), name


def test_a_pickled_study_is_small_and_gives_the_same_numbers(housing_study: ProductStudy) -> None:
    data = pickle.dumps(housing_study)
    assert len(data) < 100_000
    rows = random_rows(housing_study, 8)
    assert np.array_equal(pickle.loads(data).variants(rows).com_mm, housing_study.variants(rows).com_mm)


def test_a_study_of_a_body_needs_no_kernel() -> None:
    script = (
        "import sys\n"
        "from gomboc_cad import catalog\n"
        "from gomboc_cad.products.process import load_process\n"
        "from gomboc_cad.tolerance.product_study import body_study\n"
        "body_study(catalog()['primary'], load_process('fdm'), degree=2)\n"
        "print('build123d' in sys.modules, 'OCP' in sys.modules)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, encoding="utf-8", timeout=120, check=True
    )
    assert done.stdout.split() == ["False", "False"]


def test_effects_are_in_proportion_to_sizes(bare: ProductStudy) -> None:
    rows = random_rows(bare, 10)
    form, half = bare.variants(rows).form_mm, bare.scaled({"form_error": 0.5}).variants(rows).form_mm
    assert half == pytest.approx(0.5 * form)
    sizes = {source.name: source.size for source in bare.sources}
    halved = {source.name: source.size for source in bare.scaled({"form_error": 0.5}).sources}
    assert halved == {**sizes, "form_error": 0.5 * sizes["form_error"]}


def test_a_single_source_is_what_it_is_among_all(bare: ProductStudy) -> None:
    rows = random_rows(bare, 10)
    start = next(
        sum(source.dimensions for source in bare.sources[:index])
        for index, source in enumerate(bare.sources)
        if source.name == "shrinkage"
    )
    alone = bare.only("shrinkage")
    assert alone.dimensions == 3
    stretch = alone.variants(rows[:, start : start + 3]).stretch
    assert np.array_equal(stretch, bare.variants(rows).stretch)


def test_com_shift_moves_design_and_variants_alike(bare: ProductStudy) -> None:
    lowered = bare.with_com_shift((0.0, 0.0, -0.2)).with_com_shift((0.1, 0.0, -0.2))
    rows = random_rows(bare, 4)
    assert np.subtract(lowered.nominal.com_mm, bare.nominal.com_mm) == pytest.approx([0.1, 0.0, -0.4])
    moved = lowered.variants(rows).com_mm - bare.variants(rows).com_mm
    assert moved == pytest.approx(np.tile([0.1, 0.0, -0.4], (4, 1)))


def test_wrong_names_and_wrong_shapes_are_refused(bare: ProductStudy) -> None:
    with pytest.raises(GombocError, match=r"no source 'form'; choose of form_error, shrinkage"):
        bare.scaled({"form": 0.5})
    with pytest.raises(GombocError, match="no source 'glue'"):
        bare.only("glue")
    with pytest.raises(ValueError, match="not \\(n, "):
        bare.variants(np.full((2, 3), 0.5))


def test_a_process_without_tolerances_is_refused() -> None:
    process = load_process("fdm").model_copy(update={"tolerances": None})
    with pytest.raises(SpecError, match="tolerances"):
        body_study(catalog()["primary"], process)


def test_form_error_goes_as_far_as_the_spectrum_of_the_process(bare: ProductStudy) -> None:
    process = load_process("fdm")
    highest = int(process.tolerances.form.highest_order.value)
    study = body_study(catalog()["primary"], process)
    assert study.sources[0].dimensions == (min(16, highest) + 1) ** 2 - 4
    assert bare.sources[0].dimensions == 7**2 - 4


def test_a_study_without_form_error(bare: ProductStudy) -> None:
    study = body_study(catalog()["primary"], load_process("sla"), degree=1)
    variants = study.variants(random_rows(study, 3))
    assert variants.form_mm.shape == (3, 0)
    assert "form_error" not in {source.name for source in study.sources}


@pytest.mark.parametrize("build_up", [None, (0.0, 0.0, 1.0)])
def test_a_dented_body_is_refused(build_up: Vector | None) -> None:
    with pytest.raises(NotConvexError, match="not strictly convex"):
        body_study(make_body("sloan2", beta=0.06), load_process("fdm"), build_up=build_up)


def test_description_lists_all_that_varies(bare: ProductStudy) -> None:
    said = bare.describe()
    assert [source["name"] for source in said["sources"]] == [source.name for source in bare.sources]
    assert said["subject"] == "primary"


def test_sources_of_a_product(housing: HousingDesign, housing_study: ProductStudy) -> None:
    names = [source.name for source in housing_study.sources]
    for name in ("form_error", "shrinkage", "seam_step", "seam_gap", "shell_density", "core_shift"):
        assert names.count(name) == 1
    assert {"mass_of_board", "place_of_board", "fastener_mass", "com_error"} <= set(names)
    assert "trim_mass" not in names  # there is none
    sizes = {source.name: source.size for source in housing_study.sources}
    (board,) = housing.mounted.loads
    assert sizes["mass_of_board"] == board.mass_tolerance_g
    assert sizes["com_error"] == pytest.approx(1e-3 * housing.spec.tolerances.com_error_um)
    assert housing_study.nominal.openings == housing.openings
    seam = housing_study.nominal.seam
    assert seam is not None
    assert seam.normal == housing.frame.up


def extreme(study: ProductStudy, name: str, column: int = 0, quantile: float = 0.9) -> np.ndarray:
    """How the centre of mass moves when one draw of one source is not in the middle."""
    alone = study.only(name)
    row = np.full((2, alone.dimensions), 0.5)
    row[1, column] = quantile
    middle, moved = alone.variants(row).com_mm
    return moved - middle


def rebuilt(housing: HousingDesign, changed: dict[str, Part]) -> np.ndarray:
    """How the centre of mass of the assembly moves when parts are really replaced."""
    parts = tuple(changed.get(part.name, part) for part in housing.assembly.parts)
    made = Assembly("made", parts, housing.assembly.com_target_mm)
    return np.subtract(made.com_mm, housing.assembly.com_mm)


def test_errors_of_a_product_are_those_of_really_changed_parts(
    housing: HousingDesign, housing_study: ProductStudy
) -> None:
    parts = {part.name: part for part in housing.assembly.parts}
    board, lower = parts["board"], parts["imu-housing-lower"]
    (load,) = housing.mounted.loads
    heavier = replace(board, mass_g=board.mass_g + 0.8 * load.mass_tolerance_g)
    assert extreme(housing_study, "mass_of_board") == pytest.approx(
        rebuilt(housing, {"board": heavier}), abs=1e-12
    )
    aside = board.moved(0.8 * load.com_tolerance_mm * np.array(housing.frame.second))
    assert extreme(housing_study, "place_of_board", 1) == pytest.approx(
        rebuilt(housing, {"board": aside}), abs=1e-12
    )
    spread = housing_study.only("shell_density").deviations(np.array([[0.9, 0.5]])).mass_g[0, 0]
    denser = replace(lower, mass_g=lower.mass_g + spread)
    assert spread > 0.0
    assert extreme(housing_study, "shell_density") == pytest.approx(
        rebuilt(housing, {lower.name: denser}), abs=1e-12
    )
    step = housing_study.only("seam_step").deviations(np.array([[0.9, 0.5]])).upper_shift_mm[0]
    upper = {
        name: part.moved(step) for name, part in parts.items() if np.dot(part.com_mm, housing.frame.up) > 0.0
    }
    assert set(upper) == {"imu-housing-upper"}
    assert extreme(housing_study, "seam_step") == pytest.approx(rebuilt(housing, upper), abs=1e-12)


def test_core_shift_is_that_of_a_cavity_that_is_really_displaced(
    housing: HousingDesign, housing_study: ProductStudy
) -> None:
    """Both cores by the same vector: the plastic's moment against meshes of the displaced cavity."""
    shift = np.array([0.3, 0.2, -0.1])
    whole = replace(housing.layout.hollow, core_shift_mm=housing.placement.core_shift_mm)
    there = replace(whole, core_shift_mm=tuple(np.add(whole.core_shift_mm, shift)))
    before, after = (hollow.mesh(each, 100.0).mass() for each in (whole, there))
    moment = after.volume_mm3 * np.array(after.com_mm) - before.volume_mm3 * np.array(before.com_mm)
    parts = weighed_parts(housing, load_process("fdm"))
    lost = -sum(part.void_share * part.volume_mm3 for part in parts if part.role == "shell") * shift
    assert moment == pytest.approx(lost, rel=0.01)


def test_contents_sit_on_the_core_of_their_half(housing: HousingDesign) -> None:
    parts = {part.name: part for part in weighed_parts(housing, load_process("fdm"))}
    assert parts["board"].carrier == "imu-housing-lower"
    assert parts["board"].role == "payload"
    assert parts["imu-housing-upper"].carrier is None
    assert parts["imu-housing-upper"].build_up == housing.frame.up
    assert parts["imu-housing-lower"].build_up == pytest.approx(np.negative(housing.frame.up))
    # Lower and upper half together are as tall as the body, up to what the closure has across the seam.
    assert parts["imu-housing-lower"].height_mm + parts["imu-housing-upper"].height_mm == pytest.approx(
        100.0, abs=2.0
    )


@pytest.mark.slow
def test_a_loose_filling_of_a_pod_settles() -> None:
    spec = load_spec("seed-pod")
    design = quick_design("seed-pod", substrate={"fill": 0.5})
    kernel, filling = design.loads
    mass = next(part.mass_g for part in design.assembly.parts if part.name == "substrate")
    assert filling.mass_tolerance_g == pytest.approx(spec.substrate.mass_scatter * mass)
    # Half of a room of about 10 mm goes to one side by a few millimetres.
    assert 1.0 < filling.com_tolerance_mm < 5.0
    assert kernel.com_tolerance_mm == spec.seed.play_mm
    names = {source.name for source in product_study(design, load_process("sla"), degree=2).sources}
    assert {"mass_of_seed", "place_of_seed", "mass_of_substrate", "place_of_substrate"} <= names


@pytest.mark.slow
def test_loads_and_fixed_parts_of_a_buoy() -> None:
    design = quick_design("buoy", com={})  # as the template has it
    assert {load.part for load in design.loads} == {"battery", "electronics", "ballast"}
    parts = {part.name: part for part in weighed_parts(design, load_process("injection"))}
    assert parts["ballast"].carrier == "buoy-lower"
    assert parts["eye-bolt"].carrier is None  # it is in the mooring's recess
    assert parts["battery"].role == "payload"
    # Whatever its centre of mass is above: the tube that holds both stands in the lower half.
    upper = {name for name, part in parts.items() if part.upper and not name.startswith("closure-screw-")}
    assert upper == {"buoy-upper", "port-plug", "port-seal"}
