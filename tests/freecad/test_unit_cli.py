"""Command lines and answers, against the package that they are for; no FreeCAD."""

from __future__ import annotations

import itertools
import json
import tomllib
from pathlib import Path

import pytest
from freecad.gomboc import cli
from freecad.gomboc.errors import CancelledError, GombocCadError
from freecad.gomboc.lists import Lists
from freecad.gomboc.objects.properties import PRODUCT_SETTINGS, default_of
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import gomboc_cad
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.cli import app
from gomboc_cad.console import Reporter
from gomboc_cad.documents import catalog_document
from gomboc_cad.products.body_file import load_body
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.spec import PRODUCTS, load_spec
from gomboc_cad.products.template_files import template_names, template_values

VALUES = st.recursive(
    st.text(st.characters(exclude_categories=["Cs"]))
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=6,
)


@given(VALUES)
def test_values_reach_a_spec_as_they_are(value):
    read = tomllib.loads(f"value = {cli.toml(value)}")["value"]
    assert read == value
    assert type(read) is type(value)


def test_what_a_spec_cannot_hold_is_refused():
    with pytest.raises(TypeError, match="no place in a spec"):
        cli.toml({"a": 1})


def changes(subject: cli.Subject) -> list[str]:
    words = subject.arguments()
    return [value for flag, value in itertools.pairwise(words) if flag == "--set"]


@pytest.mark.parametrize("product", PRODUCTS)
def test_the_settings_of_a_product_are_keys_of_its_spec(product):
    spec = load_spec(product).model_dump(mode="json", exclude_none=True)
    defaults = {setting.key: default_of(spec, setting.key) for setting in PRODUCT_SETTINGS}
    defaults = {key: value for key, value in defaults.items() if value is not None}
    assert {"body.name", "body.diameter_mm", "shell.wall_mm", "shell.material", "shell.process"} <= set(
        defaults
    )
    assert load_spec(product, changes(cli.Subject(product, changes=defaults))) == load_spec(product)
    larger = {"body.diameter_mm": 1.25 * defaults["body.diameter_mm"], "com.target": [-0.5, 0.25, 0.0]}
    found = load_spec(product, changes(cli.Subject(product, changes=larger)))
    assert found.body.diameter_mm == larger["body.diameter_mm"]
    assert found.com.target == (-0.5, 0.25, 0.0)


def test_what_a_user_overrides_wins():
    subject = cli.Subject(
        "imu-housing",
        changes={"body.diameter_mm": 60.0},
        overrides=[cli.check_override(" body.diameter_mm = 70")],
    )
    assert load_spec("imu-housing", changes(subject)).body.diameter_mm == 70.0


@pytest.mark.parametrize("text", ["", "no equals sign", "= 3", "a.b =", "a b = 3"])
def test_an_override_that_is_none_is_refused(text):
    with pytest.raises(GombocCadError, match="KEY=VALUE"):
        cli.check_override(text)


@pytest.mark.parametrize(
    "arguments",
    [
        cli.templates(),
        cli.catalog(),
        cli.build(cli.Subject("seed-pod", changes={"body.diameter_mm": 30.0}), Path("out")),
        cli.body(cli.Subject("primary", diameter_mm=60.0), Path("out")),
        cli.check(Path("part.step"), (-1.5, 0.0, 1e-7)),
        cli.zone(cli.Subject("primary", diameter_mm=60.0), Path("zone.stl"), (-1.0, 0.0, 0.0)),
        cli.drill_map(cli.Subject("primary", diameter_mm=60.0), 3000, (-1.0, 0.0, 0.0)),
        cli.tolerance(cli.Subject("buoy"), Path("out"), cli.Study("fdm", 64, 1, answers=False)),
    ],
    ids=lambda arguments: arguments[5],
)
def test_the_package_knows_each_option(arguments):
    isolated, words = arguments[: len(cli.ISOLATED) + 2], arguments[len(cli.ISOLATED) + 2 :]
    assert isolated == [*cli.ISOLATED, "-m", "gomboc_cad"]
    # --help after the options: they are parsed, nothing is computed.
    done = CliRunner().invoke(app, [*words, "--help"])
    assert done.exit_code == 0, done.output
    options = {word.partition("=")[0] for word in words if word.startswith("--")}
    assert all(option in done.output for option in options)


def test_stages_of_the_package_are_understood(capsys, monkeypatch):
    monkeypatch.setenv("GOMBOC_CAD_PROGRESS", "lines")
    with Reporter(as_json=True, quiet=False).stages(2) as progress:
        progress("cutting the cavity")
        progress("judging [2/3] of it")
    with Reporter(as_json=True, quiet=False).stages(None) as progress:
        progress("reading the file")
    said = [cli.progress_of(line) for line in capsys.readouterr().err.splitlines()]
    assert said == [
        cli.Progress(1, 2, "cutting the cavity"),
        cli.Progress(2, 2, "judging [2/3] of it"),
        cli.Progress(1, None, "reading the file"),
    ]
    assert cli.progress_of("gomboc-cad: no stage") is None


def test_the_version_of_this_package_fits():
    assert cli.version_of(f"gomboc-cad {gomboc_cad.__version__}\n") == gomboc_cad.__version__
    assert cli.supported(gomboc_cad.__version__)


@pytest.mark.parametrize(
    ("version", "fits"),
    [
        ("0.1.0", True),
        ("0.1.17", True),
        ("0.1.1.dev3", True),
        ("0.0.9", False),
        ("0.2.0", False),
        ("1.0", False),
    ],
)
def test_versions_that_fit(version, fits):
    assert cli.supported(version) is fits


@pytest.mark.parametrize("output", ["", "Python 3.11.2\n", "gomboc-cad: an error\n"])
def test_no_version_is_read_from_something_else(output):
    assert cli.version_of(output) is None


def transcript(output: str = "", errors: str = "") -> cli.Transcript:
    made = cli.Transcript()
    made.add_output(output.encode())
    made.add_errors(errors.encode())
    return made


@given(st.lists(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\n\r"))), st.data())
def test_lines_do_not_depend_on_how_they_arrive(lines, data):
    whole = "".join(line + "\n" for line in lines).encode()
    cuts = sorted(data.draw(st.lists(st.integers(0, len(whole)), max_size=5)))
    pieces = cli.Transcript()
    for begin, end in zip([0, *cuts], [*cuts, len(whole)], strict=True):
        pieces.add_errors(whole[begin:end])
    assert pieces.lines == lines


@pytest.mark.parametrize("exit_code", [cli.PASSED, cli.FAILED])
def test_an_answer_is_read_whatever_its_verdict(exit_code):
    document = {"verdict": "FAIL", "reasons": ["größer als 3 µm"]}
    said = transcript(json.dumps(document, ensure_ascii=False), "[1/1] judging\n")
    assert said.document(exit_code, crashed=False) == document


def test_the_sentence_of_the_package_is_given_on():
    sentence = "The folder of /tmp/Prüfung 1/x.stl does not exist; make it first."
    said = transcript(errors=f"[1/3] reading\nsome warning\ngomboc-cad: {sentence}\n")
    with pytest.raises(GombocCadError) as caught:
        said.document(cli.BAD_INPUT, crashed=False)
    assert str(caught.value) == sentence


def test_a_last_line_without_an_end_is_read_too():
    with pytest.raises(GombocCadError, match=r"^no end of line$"):
        transcript(errors="gomboc-cad: no end of line").document(cli.BAD_INPUT, crashed=False)


def test_an_interrupted_run_is_told_from_a_failed_one():
    with pytest.raises(CancelledError):
        transcript(errors="gomboc-cad: interrupted\n").document(cli.INTERRUPTED, crashed=False)


@pytest.mark.parametrize(("exit_code", "crashed"), [(-9, True), (11, False), (0, True)])
def test_a_crash_names_the_stage(exit_code, crashed):
    with pytest.raises(GombocCadError, match="while cutting the cavity; nothing was changed"):
        transcript("{}", "[3/12] cutting the cavity\n").document(exit_code, crashed)


@pytest.mark.parametrize(
    ("output", "errors", "reason"),
    [
        ("", "python: No module named gomboc_cad\n", "No module named gomboc_cad"),
        ("Traceback", "ValueError: x\n", "ValueError: x"),
        ("[1, 2]", "", "list"),
        ('{"a": 1', "", "delimiter"),
    ],
)
def test_what_is_no_answer_is_said(output, errors, reason):
    with pytest.raises(GombocCadError, match="cannot be read") as caught:
        transcript(output, errors).document(cli.FAILED, crashed=False)
    assert reason in str(caught.value)


def test_an_outside_program_gets_nothing_of_a_bundle():
    bundle = "/tmp/.mount_FreeCAD"
    given = {
        "APPDIR": bundle,
        "PYTHONHOME": f"{bundle}/usr",
        "PYTHONPATH": "x",
        "VIRTUAL_ENV": "y",
        "LD_LIBRARY_PATH": f"{bundle}/usr/lib:/opt/cuda/lib:{bundle}",
        "LD_PRELOAD": f"{bundle}/usr/lib/fix.so",
        "HOME": "/home/ü",
    }
    assert cli.environment(given) == {"APPDIR": bundle, "LD_LIBRARY_PATH": "/opt/cuda/lib", "HOME": "/home/ü"}
    assert cli.in_bundle(f"{bundle}/usr/bin/python3", given)
    assert not cli.in_bundle(f"{bundle}2/python3", given)
    assert not cli.in_bundle("/usr/bin/python3", given)
    plain = {"LD_LIBRARY_PATH": "/opt/cuda/lib", "HOME": "/root"}
    assert cli.environment(plain) == plain


def test_the_lists_are_those_of_the_package():
    answer = {**template_names(), **template_values(), "file": None}
    found = Lists.of_documents(catalog_document(), json.loads(json.dumps(answer)))
    assert set(found.products) == set(PRODUCTS)
    assert found.products["imu-housing"]["body"]["diameter_mm"] == load_spec("imu-housing").body.diameter_mm
    assert "primary" in found.choices["bodies"]
    assert found.density_g_cm3["PLA"] == load_material("PLA").density_g_cm3
    for setting in PRODUCT_SETTINGS:
        assert setting.kind != "choice" or found.choices[setting.choices]


def test_a_body_of_the_catalogue_as_a_file_is_that_body(tmp_path):
    file = tmp_path / "primary.toml"
    file.write_text(cli.body_file(cli.Subject("primary", diameter_mm=62.5)), encoding="utf-8")
    assert load_body(file) == named_body("primary", 62.5)
