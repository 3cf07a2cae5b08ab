"""Processes: the shipped files are sourced and sensible, and a user's own works as well."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import legendre

from gomboc_cad.body.sphere import unit
from gomboc_cad.errors import SpecError
from gomboc_cad.products.common_spec import ShellSpec
from gomboc_cad.products.process import (
    Process,
    form_amplitudes_mm,
    known_tolerances,
    least_wall_mm,
    load_process,
    process_names,
)
from gomboc_cad.products.process_table import TABLES, figures, with_tables

# Supported walls in mm, from the one-page table "3D printing design rules" of Protolabs Network.
PUBLISHED_WALL = {"fdm": 0.8, "sla": 0.5, "sls": 0.7, "mjf": 0.7, "polyjet": 1.0}

OWN = """
name = "my mill"
kind = "machined"
min_wall_mm = 0.9
min_wall_source = "tried"
undercuts_matter = true
"""


def test_the_processes_of_the_contract_are_there() -> None:
    names = {"fdm", "sla", "sls", "mjf", "polyjet", "cnc-3axis", "cnc-5axis", "injection"}
    assert set(process_names()) == names


@pytest.mark.parametrize("name", process_names())
def test_each_process_says_where_its_figures_come_from(name: str) -> None:
    process = load_process(name)
    assert 0.3 <= process.min_wall_mm <= 2.0
    assert len(process.min_wall_source) > 20
    assert (process.kind == "printed") == (name in PUBLISHED_WALL)
    # A printer builds any overhang with support or powder, and a tilted tool reaches most of them.
    assert process.undercuts_matter == (name in {"cnc-3axis", "injection"})


@pytest.mark.parametrize(("name", "wall_mm"), PUBLISHED_WALL.items())
def test_printed_walls_are_those_of_the_published_table(name: str, wall_mm: float) -> None:
    assert load_process(name).min_wall_mm == wall_mm


def test_a_process_of_ones_own_lies_beside_the_spec(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(OWN, encoding="utf-8")
    assert load_process("mine.toml", tmp_path).min_wall_mm == 0.9
    assert least_wall_mm(ShellSpec(process="mine.toml"), tmp_path) == 0.9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("0.9", "-0.9"), r"mine.toml: min_wall_mm = -0.9 is not allowed"),
        (('"machined"', '"cast"'), r"mine.toml: kind = 'cast' is not allowed"),
        (
            ("min_wall_source", "min_wall_sauce"),
            r"unknown key min_wall_sauce \(did you mean min_wall_source\?\)",
        ),
        (("undercuts_matter = true", "typical_size_mm = [1.0, 1.0, 1.0]"), "undercuts_matter is missing"),
    ],
)
def test_mistakes_in_a_process_of_ones_own_are_named(
    tmp_path: Path, change: tuple[str, str], message: str
) -> None:
    (tmp_path / "mine.toml").write_text(OWN.replace(*change), encoding="utf-8")
    with pytest.raises(SpecError, match=message):
        load_process("mine.toml", tmp_path)


def test_a_size_needs_its_source(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(OWN + "typical_size_mm = [1.0, 1.0, 1.0]\n", encoding="utf-8")
    with pytest.raises(SpecError, match="typical_size_mm and typical_size_source go together"):
        load_process("mine.toml", tmp_path)


def test_an_unknown_process_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(SpecError, match=r"no process 'cnc-4axis'; did you mean cnc-[35]axis\?"):
        load_process("cnc-4axis")
    with pytest.raises(SpecError, match=r"no process 'knitting'; choose one of cnc-3axis, .*, sls,"):
        load_process("knitting")


def test_a_name_does_not_leave_the_folder_of_the_templates() -> None:
    with pytest.raises(SpecError, match="no process"):
        load_process("../boards/adafruit-bno055")


def test_the_wall_left_is_the_processs_own_unless_the_spec_asks_for_more() -> None:
    assert least_wall_mm(ShellSpec(wall_mm=3.0, process="sls")) == 0.7
    assert least_wall_mm(ShellSpec(wall_mm=3.0, min_wall_mm=1.2, process="sls")) == 1.2


@pytest.mark.parametrize(
    ("shell", "message"),
    [
        (
            ShellSpec(wall_mm=0.7, process="fdm"),
            r"shell.wall_mm = 0.7 is thinner than the 0.8 mm .* FDM print",
        ),
        (ShellSpec(wall_mm=2.0, min_wall_mm=0.4, process="fdm"), r"shell.min_wall_mm = 0.4 is thinner"),
    ],
)
def test_a_wall_below_the_minimum_of_the_process_is_refused(shell: ShellSpec, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        least_wall_mm(shell)


LIKE_FDM = 'like = "fdm"\n[tolerances.form]\n'
FIGURE = '{{ value = {}, range = [{}, {}], source = "measured" }}'
ORDERS = np.arange(2, 16)


def own(folder: Path, text: str) -> Process:
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    return load_process("mine.toml", folder)


def with_form(folder: Path, **changes: str) -> Process:
    """The FDM process with a tolerance of ±0.1 mm, whatever the size, and other changes of its form."""
    zero, given_mm = FIGURE.format(0.0, 0.0, 0.0), FIGURE.format(0.1, 0.1, 0.1)
    keys = {"proportional_percent": zero, "fixed_mm": given_mm} | changes
    return own(folder, LIKE_FDM + "".join(f"{key} = {value}\n" for key, value in keys.items()))


@pytest.mark.parametrize("name", process_names())
def test_every_figure_has_a_source_and_lies_within_its_range(name: str) -> None:
    process = load_process(name)
    found = figures(process)
    assert len(found) == 26 + (process.kind == "printed")
    for key, figure in found.items():
        low, high = figure.range
        assert low <= figure.value <= high, key
        assert len(figure.source) > 20, key
        assert low < high, key


def test_prints_have_layers_and_others_have_none() -> None:
    published_layer_mm = {"sla": 0.1, "sls": 0.12, "mjf": 0.08, "polyjet": 0.03}
    for name in process_names():
        layers = known_tolerances(load_process(name)).layers
        assert (layers is not None) == (name in PUBLISHED_WALL)
        if name in published_layer_mm:
            assert layers is not None
            # Standard layers in Fathom's design guidelines lie within the range.
            assert layers.height_mm.range[0] <= published_layer_mm[name] <= layers.height_mm.range[1]


def test_figures_agree_with_the_published_tolerances() -> None:
    """Protolabs, Basic Design Guidelines: small parts, ± in mm; each is within the range of the process."""
    published = {"sla": 0.0508, "sls": 0.254, "polyjet": 0.127, "mjf": 0.305, "cnc-3axis": 0.127}
    for name, tolerance_mm in published.items():
        low, high = known_tolerances(load_process(name)).form.fixed_mm.range
        assert low <= tolerance_mm <= high, name


@given(
    name=st.sampled_from(process_names()),
    size_mm=st.floats(1.0, 1000.0),
    growth=st.floats(1.0, 10.0),
)
def test_a_bigger_part_is_never_better(name: str, size_mm: float, growth: float) -> None:
    form = known_tolerances(load_process(name)).form
    assert form.tolerance_mm(growth * size_mm) >= form.tolerance_mm(size_mm) >= form.fixed_mm.value
    small, large = (
        form_amplitudes_mm(load_process(name), size, ORDERS) for size in (size_mm, growth * size_mm)
    )
    assert np.all(large >= small)
    assert np.all(small > 0.0)


def test_a_large_part_has_the_proportional_tolerance() -> None:
    form = known_tolerances(load_process("fdm")).form
    assert form.tolerance_mm(20.0) == form.fixed_mm.value == 0.3
    assert form.tolerance_mm(1000.0) == pytest.approx(3.0)
    assert form.rms_mm(1000.0) == pytest.approx(10.0 * form.rms_mm(50.0))


@pytest.mark.parametrize("name", process_names())
def test_the_amplitudes_sum_to_the_stated_total(name: str) -> None:
    process = load_process(name)
    form = known_tolerances(process).form
    assert np.linalg.norm(form_amplitudes_mm(process, 100.0, np.arange(0, 100))) == pytest.approx(
        form.rms_mm(100.0), rel=1e-12
    )


def test_amplitudes_are_zero_outside_of_the_band_and_keep_the_shape_asked_for() -> None:
    process = load_process("sls")
    found = form_amplitudes_mm(process, 80.0, np.array([[-1, 0, 1, 2], [15, 16, 100, 3]]))
    assert (found > 0.0).tolist() == [[False, False, False, True], [True, False, False, True]]
    assert found[0, 3] == form_amplitudes_mm(process, 80.0, np.array(2))
    assert form_amplitudes_mm(process, 80.0, np.array([], dtype=int)).shape == (0,)


def test_a_tolerance_of_the_surface_is_its_rms_times_the_quantile(tmp_path: Path) -> None:
    """95 % of a normal distribution lie within 1.959964 standard deviations; the spectrum falls as n⁻²."""
    process = with_form(tmp_path, measure='"surface"')
    found = form_amplitudes_mm(process, 100.0, ORDERS)
    assert np.linalg.norm(found) == pytest.approx(0.1 / 1.959963984540054, rel=1e-12)
    np.testing.assert_allclose(found / found[0], (ORDERS / 2.0) ** -2.0, rtol=1e-12)


def test_one_standard_deviation_is_taken_as_it_is(tmp_path: Path) -> None:
    process = with_form(
        tmp_path, measure='"surface"', coverage_percent=FIGURE.format(68.26894921370859, 50.0, 99.0)
    )
    assert known_tolerances(process).form.rms_mm(100.0) == pytest.approx(0.1, rel=1e-9)


def test_an_oval_alone_has_twice_its_deviation_as_dimension(tmp_path: Path) -> None:
    process = with_form(tmp_path, highest_order=FIGURE.format(2, 2, 2))
    assert form_amplitudes_mm(process, 100.0, np.array(2)) == pytest.approx(0.1 / 1.959963984540054 / 2.0)


def test_calipers_do_not_see_odd_orders_alone(tmp_path: Path) -> None:
    three = FIGURE.format(3, 2, 3)
    with pytest.raises(SpecError, match="no dimension shows the odd order 3 alone"):
        with_form(tmp_path, lowest_order=three, highest_order=three)
    surface = with_form(tmp_path, lowest_order=three, highest_order=three, measure='"surface"')
    assert np.count_nonzero(form_amplitudes_mm(surface, 100.0, ORDERS)) == 1


def test_widths_of_random_surfaces_scatter_by_the_stated_tolerance() -> None:
    """Random fields with the spectrum, each degree a sum of zonal harmonics about random axes."""
    process = load_process("polyjet")
    generator = np.random.default_rng(3)
    surfaces, axes = 200, 60
    places = unit(generator.normal(size=(40, 3)))
    poles = unit(generator.normal(size=(surfaces, axes, 3)))
    # The mean square of a Legendre polynomial of degree n over the sphere is 1 / (2 n + 1).
    scale = form_amplitudes_mm(process, 100.0, ORDERS) * np.sqrt((2 * ORDERS + 1) / axes)
    weights = generator.normal(size=(surfaces, axes, len(ORDERS))) * scale
    cosines = np.einsum("pi,sai->sap", places, poles)
    by_degree = legendre.legvander(cosines, ORDERS[-1])[..., ORDERS]
    deviation = np.einsum("sapn,san->sp", by_degree, weights)
    opposite = np.einsum("sapn,san,n->sp", by_degree, weights, (-1.0) ** ORDERS)
    form = known_tolerances(process).form
    assert np.std(deviation) == pytest.approx(form.rms_mm(100.0), rel=0.05)
    assert np.std(deviation + opposite) == pytest.approx(form.tolerance_mm(100.0) / 1.96, rel=0.05)


@pytest.mark.parametrize("decay", [1, 2, 3])
def test_a_roundness_trace_shows_the_spectrum_of_the_sphere(tmp_path: Path, decay: int) -> None:
    """What the page on processes tells those who measure: 86 to 88 % of the rms, the same slope.

    A degree n has the covariance aₙ² Pₙ(cos φ) along a great circle (addition theorem), whose cosine series
    is the spectrum that a roundness tester finds; it takes out orders 0 and 1.
    """
    process = with_form(tmp_path, decay=FIGURE.format(decay, 1, 3))
    amplitudes = form_amplitudes_mm(process, 100.0, ORDERS)
    angles = (np.arange(64) + 0.5) * np.pi / 64
    covariance = legendre.legvander(np.cos(angles), ORDERS[-1])[:, ORDERS] @ amplitudes**2
    trace = np.sqrt(2.0 * np.cos(np.outer(ORDERS, angles)) @ covariance / len(angles))
    assert 0.86 <= np.linalg.norm(trace) / np.linalg.norm(amplitudes) <= 0.88
    # Near its end a band lacks the degrees above it, so the slope is read off the first third.
    slope = np.polyfit(np.log(ORDERS[:5]), np.log(trace[:5]), 1)[0]
    assert slope == pytest.approx(-decay, abs=0.2)


def test_like_alone_is_the_process_itself(tmp_path: Path) -> None:
    for name in process_names():
        assert own(tmp_path, f'like = "{name}"\n') == load_process(name)


def test_like_changes_what_is_given_and_nothing_else(tmp_path: Path) -> None:
    fdm = load_process("fdm")
    changed = own(
        tmp_path,
        'like = "fdm"\nname = "mine"\nmin_wall_mm = 1.0\n[tolerances.seam]\n'
        f"step_scatter_mm = {FIGURE.format(0.02, 0.01, 0.03)}\n",
    )
    assert (changed.name, changed.min_wall_mm, changed.min_wall_source) == ("mine", 1.0, fdm.min_wall_source)
    differing = {key for key, figure in figures(changed).items() if figure != figures(fdm)[key]}
    assert differing == {"seam.step_scatter_mm"}
    assert figures(changed)["seam.step_scatter_mm"].range == (0.01, 0.03)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("fixed_um = {value = 200.0, range = [1.0, 300.0], source = 'x'}", "did you mean fixed_mm"),
        (
            "fixed_mm = {value = 200.0, range = [1.0, 300.0], source = 'x'}",
            "tolerances.form.fixed_mm: 200 is not allowed .allowed: 0 to 10., in the unit of the key's name",
        ),
        (
            "fixed_mm = {value = 0.2, range = [0.3, 0.4], source = 'x'}",
            "tolerances.form.fixed_mm: value = 0.2 is outside of its own range, 0.3 to 0.4",
        ),
        (
            "fixed_mm = {value = 0.2, range = [0.4, 0.1], source = 'x'}",
            r"range = \[0.4, 0.1\] is the wrong way round",
        ),
        # A figure is replaced as a whole: the source of the old one does not stand for the new one.
        (
            "fixed_mm = {value = 0.2, range = [0.1, 0.3]}",
            "the key tolerances.form.fixed_mm.source is missing",
        ),
        ("fixed_mm = {value = 0.2, source = 'x'}", "the key tolerances.form.fixed_mm.range is missing"),
        ("fixed_mm = 0.2", "tolerances.form.fixed_mm: a figure is written {"),
        ("fixed_mm = {value = nan, range = [0.0, 1.0], source = 'x'}", "fixed_mm.value = nan is not allowed"),
        ("lowest_order = {value = 2.5, range = [2, 3], source = 'x'}", "value = 2.5 is not a whole number"),
        ("lowest_order = {value = 1, range = [1, 3], source = 'x'}", "1 is not allowed .allowed: 2 to 500."),
        (
            "lowest_order = {value = 20, range = [2, 30], source = 'x'}",
            "lowest_order = 20 is more than highest_order = 15",
        ),
        (
            "measure = 'radius'",
            "tolerances.form.measure = 'radius' is not allowed .allowed: dimension, surface",
        ),
        ("[tolerances.layers]\ndirection = [0.0, 0.0, 0.0]", "points nowhere"),
        ("[tolerance.form]", "unknown key tolerance .did you mean tolerances"),
        ("[tolerances.sheam]", "unknown key tolerances.sheam .did you mean seam"),
    ],
)
def test_mistakes_in_tolerances_are_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(SpecError, match=f"mine.toml: .*{message}"):
        own(tmp_path, LIKE_FDM + text)


@pytest.mark.parametrize("pattern", ['"fmd"', '"mine.toml"', "3"])
def test_only_a_shipped_process_can_be_like(tmp_path: Path, pattern: str) -> None:
    with pytest.raises(SpecError, match=r"mine.toml: like = .* is not allowed \(allowed: cnc-3axis, .*sls\)"):
        own(tmp_path, f"like = {pattern}\n")


@pytest.mark.parametrize(("name", "kind"), [("fdm", "machined"), ("cnc-3axis", "printed")])
def test_layers_go_with_prints(tmp_path: Path, name: str, kind: str) -> None:
    with pytest.raises(SpecError, match=r"tolerances\.layers goes with a printed process"):
        own(tmp_path, f'like = "{name}"\nkind = "{kind}"\n')


def test_a_file_without_tolerances_does_for_walls_but_not_for_a_study(tmp_path: Path) -> None:
    process = own(tmp_path, OWN)
    assert process.tolerances is None
    with pytest.raises(SpecError, match=r'my mill has no tables .* begin the file with like = "fdm"'):
        known_tolerances(process)
    with pytest.raises(SpecError, match="my mill has no tables"):
        form_amplitudes_mm(process, 100.0, ORDERS)


def test_a_process_goes_to_other_processes_of_the_computer() -> None:
    process = load_process("sls")
    assert pickle.loads(pickle.dumps(process)) == process


def test_processes_load_no_cad() -> None:
    code = "import sys, gomboc_cad.products.process; sys.exit(bool({'build123d', 'OCP'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_page_has_the_figures_of_the_files(root: Path) -> None:
    page = (root / "docs" / "processes.md").read_text(encoding="utf-8")
    assert with_tables(page) == page
    assert all(table() in page for table in TABLES.values())


def test_the_pages_own_process_can_be_used(root: Path, tmp_path: Path) -> None:
    page = (root / "docs" / "processes.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    form = known_tolerances(own(tmp_path, text)).form
    assert form.rms_mm(80.0) == pytest.approx(0.062, rel=1e-4)
