"""The whole study of a product, from its spec to the files in one folder.

The rows of the study go to a file as they come; with it an interrupted study goes on where it was. All else
is computed from the same model and written at the end as `tolerance.json`, with every number of the report.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import OutputError, SpecError, StudyError
from gomboc_cad.products.process import form_amplitudes_mm, known_tolerances, load_process, process_names
from gomboc_cad.products.subject import NO_SPEC_TO_CHANGE, bare_body, is_spec
from gomboc_cad.progress import Progress, silent
from gomboc_cad.report.build_records import study_records
from gomboc_cad.report.document import body_document
from gomboc_cad.report.folder import REPORT, VERDICT, is_built, read_results
from gomboc_cad.report.write import FIGURES, PAGE, add_to_report
from gomboc_cad.solid.output import json_bytes, write_bytes, writing_to
from gomboc_cad.tolerance.acceptance import Effort, Target, design_outcome, require_good_design
from gomboc_cad.tolerance.allowable import form_error_curve
from gomboc_cad.tolerance.baseline import sphere_baseline
from gomboc_cad.tolerance.budget import solve_budget
from gomboc_cad.tolerance.comparison import compare_processes
from gomboc_cad.tolerance.cross_check import CrossCheck, checked_rows, cross_check
from gomboc_cad.tolerance.dead_zone import half_width_deg
from gomboc_cad.tolerance.executors import executor_for
from gomboc_cad.tolerance.layers import Layers, layered_rest, stair_dead_zone_mm
from gomboc_cad.tolerance.product_study import ProductStudy, body_study, product_study
from gomboc_cad.tolerance.recommend import recommend
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.sampling import SobolSample
from gomboc_cad.tolerance.statistics import Distribution, SobolIndex, Yield
from gomboc_cad.tolerance.study import StudyResult, run_sensitivity, run_study
from gomboc_cad.tolerance.tables import table_for

if TYPE_CHECKING:
    from gomboc_cad.products.process import Process

STUDY_FILE = "tolerance.json"
ROWS_NAME = "variants"

_PHASES = (0.0, 0.5)
"""Where the first layer begins, in layers over the origin."""


@dataclass(frozen=True)
class Question:
    """What a study is asked.

    Attributes:
        process: Name of a process, or the path of a user's own; that of the spec if not given.
        variants: How many variants the yields are counted on.
        seed: Of all samples.
        max_tilt_deg: Largest angle from the nominal rest at which a good part stops.
        rolling_mm: Rolling-resistance length of the part on its table.
        good_share: Share of the parts that has to be good.
        samples: Rows of each matrix of the sensitivity, a power of two.
        against: Processes to compare with; all that come with the package if not given.
        compared: Variants for each process of the comparison.
        undulations: Orders for which the allowable form error is found; between them it goes about as n⁻².
        searched: Variants that each change of the design or of a tolerance is tried on.
        confirmed: Fresh variants that confirm each answer.
        rebuilt: Variants that are judged a second time, as geometry.
        rows_format: Format of the file of rows, `csv` or `parquet`.
        answers: Whether to look for what to change: budget, recommendation, allowable form error, baseline
            and the comparison of the processes, which take most of the time.
    """

    process: str | None = None
    variants: int = 8192
    seed: int = 0
    max_tilt_deg: float = 1.0
    rolling_mm: float = 0.001
    good_share: float = 0.95
    samples: int = 512
    against: tuple[str, ...] | None = None
    compared: int = 2048
    undulations: tuple[int, ...] = (2, 3, 4, 6, 8, 12, 16)
    searched: int = 2048
    confirmed: int = 8192
    rebuilt: int = 12
    rows_format: str = "csv"
    answers: bool = True

    @property
    def target(self) -> Target:
        """What has to be met.

        Raises:
            StudyError: If a figure is out of its range.
        """
        return Target(Requirement(self.max_tilt_deg, self.rolling_mm), self.good_share)


def study_tolerances(
    subject: str,
    folder: Path,
    question: Question,
    *,
    changes: Sequence[str] = (),
    executor: str = "local",
    force: bool = False,
    report: bool = True,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Study a product or a body, and write the rows and `tolerance.json` into a folder.

    Args:
        subject: A product, the path of a spec, a body of the catalogue, or the path of a body's file.
        folder: Where the files go. An interrupted study of the same question goes on in its folder.
        question: What is asked.
        changes: `KEY=VALUE` each, for keys of the spec.
        executor: Where the variants are judged: `local`, `local:4` or `dask://HOST:PORT`.
        force: Allow a folder that holds other files, or the build of another design.
        report: Write the report too.
        progress: Called with the name of each stage as it begins.

    Returns:
        The document, as in `tolerance.json`.

    Raises:
        SpecError: If the spec or the process is wrong.
        StudyError: If the question cannot be answered, or the folder holds another study.
        GeometryError: If the product cannot be made.
        OutputError: If the folder holds other files, or cannot be written.
    """
    target, rows_file = question.target, folder / f"{ROWS_NAME}.{question.rows_format}"
    table_for(rows_file)
    _require_own_folder(folder, rows_file, force)
    with executor_for(executor) as pool:
        progress("designing what is to be studied")
        models = _models(subject, changes, question, progress)
        model = models.asked
        _require_own_design(folder, model, force)
        sample = SobolSample(model.dimensions, question.seed, question.variants)
        # Only now that nothing of the question can be refused any more.
        with writing_to(folder):
            folder.mkdir(parents=True, exist_ok=True)
        found = run_study(
            model,
            question.variants,
            question.seed,
            requirement=target.requirement,
            executor=pool,
            store=rows_file,
            progress=lambda batch: progress(f"judging variants: {batch}"),
        )
        document = _yields(model, question, found)
        progress("finding which sources matter")
        document |= _sensitivity(model, question, pool)
        progress("building some variants as geometry")
        document["cross_check"] = _cross_check(model, sample, question, pool)
        document["layers"] = _layers(models.process, model)
        if question.answers:
            document |= _answers(models, question, pool, progress)
    write_bytes(folder / STUDY_FILE, json_bytes(document))
    files = [rows_file.name, STUDY_FILE]
    if report:
        progress("writing the report")
        files += _write_report(folder, model, found)
    return {"folder": str(folder), "files": files, **document}


def _require_own_folder(folder: Path, rows_file: Path, force: bool) -> None:
    """Refuse a folder with files that are neither those of a study nor of a build, unless that is allowed."""
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder} is a file; name a folder to write to.")
    rows = {rows_file.name, f"{rows_file.name}.study.json", f"{rows_file.name}.journal"}
    own = {STUDY_FILE, REPORT, PAGE, FIGURES, *rows}
    with writing_to(folder):
        others = {path.name for path in folder.iterdir()} - own if folder.is_dir() else set()
    if others and VERDICT not in others and not force:
        raise OutputError(f"{folder} exists and is not empty; name another folder or use --force.")


def _require_own_design(folder: Path, model: ProductStudy, force: bool) -> None:
    """Refuse the folder of another design's build: one report is written of build and study."""
    if force or not (folder / VERDICT).is_file():
        return
    if not is_built(read_results(folder), model.nominal.com_mm):
        raise StudyError(
            f"{folder} holds the build of another design (its centre of mass is elsewhere); name another "
            "folder or use --force."
        )


def _write_report(folder: Path, model: ProductStudy, found: StudyResult) -> list[str]:
    """Write the report of the folder; give the names of its files."""
    nominal = model.nominal
    body = body_document(nominal.body, np.array(nominal.com_mm))
    written: list[str] = add_to_report(folder, {"body": body, **study_records(model, found)})["files"]
    return written


@dataclass(frozen=True)
class _Models:
    """The design with the errors of the process that is asked about, and with those of all."""

    process: Process
    asked: ProductStudy
    all: Mapping[str, ProductStudy]


def _models(subject: str, changes: Sequence[str], question: Question, progress: Progress) -> _Models:
    if is_spec(subject):
        # The kernel is loaded only for what needs it.
        from gomboc_cad.products.recipes import design_product
        from gomboc_cad.products.spec import load_spec, spec_path

        spec, beside = load_spec(subject, changes), spec_path(subject).parent
        name = question.process or spec.shell.process
        wanted = load_process(name, beside if question.process is None else None)
        design = design_product(spec, beside, progress)
        made = partial(product_study, design)
    elif changes:
        raise SpecError(NO_SPEC_TO_CHANGE)
    else:
        name = question.process or "fdm"
        wanted = load_process(name)
        made = partial(body_study, bare_body(subject))
    against = process_names() if question.against is None else question.against
    others = {other: load_process(other) for other in against} if question.answers else {}
    return _Models(wanted, made(wanted), {other: made(process) for other, process in others.items()})


def _yields(model: ProductStudy, question: Question, found: StudyResult) -> dict[str, Any]:
    """What the variants say."""
    return {
        **model.describe(),
        "variants": question.variants,
        "seed": question.seed,
        "max_tilt_deg": question.max_tilt_deg,
        "rolling_um": 1e3 * question.rolling_mm,
        "good_share": question.good_share,
        "verdict": "PASS" if found.yield_tilt.interval.low >= question.good_share else "FAIL",
        "yield_monostable": _yield(found.yield_monostable),
        "yield_tilt": _yield(found.yield_tilt),
        "may_stall": found.may_stall,
        "tilt_deg": _distribution(found.tilt_deg),
        "dead_zone_deg": _distribution(found.dead_zone_deg),
        "s_margin_mm": _distribution(found.s_margin_mm),
        "com_error_um": _distribution(found.com_error_um),
    }


def _yield(found: Yield) -> dict[str, Any]:
    """The interval if no undecided variant is good, and its upper end if all are."""
    return {
        **asdict(found.interval),
        "passed": found.passed,
        "undecided": found.undecided,
        "high_if_undecided_pass": found.possible.high,
    }


def _distribution(found: Distribution | None) -> dict[str, Any] | None:
    return None if found is None else asdict(found)


def _sensitivity(model: ProductStudy, question: Question, pool: Executor) -> dict[str, Any]:
    """Sobol indices of the tilt, as the contract has them, and of the S-margin."""
    found = run_sensitivity(model, question.samples, question.seed, executor=pool)

    def entries(indices: tuple[SobolIndex, ...]) -> list[dict[str, Any]]:
        return [asdict(index) for index in sorted(indices, key=lambda index: -index.total.estimate)]

    return {
        "sobol": entries(found.tilt_deg),
        "sobol_s_margin": entries(found.s_margin_mm),
        "sobol_samples": found.samples,
    }


def _cross_check(
    model: ProductStudy, sample: SobolSample, question: Question, pool: Executor
) -> dict[str, Any]:
    """A random subset of the very variants of the study, built and judged again."""
    if question.rebuilt == 0:
        return CrossCheck(()).document()
    numbers = checked_rows(question.variants, question.rebuilt, question.seed)
    return cross_check(model, sample.rows(numbers), numbers, spread=pool.map).document()


def _layers(process: Process, model: ProductStudy) -> dict[str, Any] | None:
    """The typical part built of real layers: where their stairs hold it; None where there are no layers."""
    figures = known_tolerances(process).layers
    if figures is None:
        return None
    height_mm, up = figures.height_mm.value, as_vector(model.machine[2])
    design = design_outcome(model)
    zone_mm = float(stair_dead_zone_mm(model.nominal.body, up, height_mm, design.rest_direction)[0])
    typical = model.variants(np.full((1, model.dimensions), 0.5))
    built = [layered_rest(model.nominal, typical, 0, Layers(up, height_mm, phase)) for phase in _PHASES]
    return {
        "height_mm": height_mm,
        "dead_zone_mm": zone_mm,
        "dead_zone_deg": float(half_width_deg(zone_mm, design.stiffness_mm[:1, 0])[0]),
        "built": [
            {
                "phase": phase,
                "verdict": made.verdict,
                "stable": made.stable,
                "barrier_um": 1e3 * made.barrier_mm,
            }
            for phase, made in zip(_PHASES, built, strict=True)
        ],
    }


def _answers(models: _Models, question: Question, pool: Executor, progress: Progress) -> dict[str, Any]:
    """What limits the yield and what to change; where the design itself is not good, only that."""
    model, target, effort = (
        models.asked,
        question.target,
        Effort(question.searched, question.confirmed, question.seed),
    )
    compared = compare_processes(
        models.all,
        target,
        variants=question.compared,
        seed=question.seed,
        executor=pool,
        dominating=False,
        progress=lambda name: progress(f"comparing processes: {name}"),
    )
    progress("comparing with a ballasted sphere")
    answers: dict[str, Any] = {
        "processes": [row.document() for row in compared],
        "baseline": sphere_baseline(model, target, effort, executor=pool).document(),
    }
    try:
        require_good_design(model, target.requirement)
    except StudyError as error:
        return {**answers, "no_answer": str(error)}
    made = form_amplitudes_mm(models.process, model.nominal.body.diameter_mm, np.array(question.undulations))
    curve = form_error_curve(
        model, question.undulations, target, process_mm=made, executor=pool, progress=progress
    )
    budget = solve_budget(model, target, effort, executor=pool, progress=progress)
    others = {name: other for name, other in models.all.items() if other.process != model.process}
    found = recommend(
        model, target, effort, as_made=budget.as_made, processes=others, executor=pool, progress=progress
    )
    summary = budget.document()
    return {
        **answers,
        "form_error": curve.document(),
        "budget": summary.pop("sources"),
        "budget_summary": summary,
        "recommend": found.document(),
    }
