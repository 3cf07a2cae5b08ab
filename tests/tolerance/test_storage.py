"""A stored study goes on after any interruption with the same numbers, and never takes what is another's."""

from __future__ import annotations

import csv
import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from gomboc_cad.errors import GombocError, StudyError
from gomboc_cad.tolerance import tables
from gomboc_cad.tolerance.fingerprint import fingerprint
from gomboc_cad.tolerance.judging import ROW
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.study import StudyResult, run_study
from tests.tolerance.toys import LoadedSphere

MODEL = LoadedSphere(margin_mm=0.25, doubt_mm=0.4)
REQUIREMENT = Requirement(5.0, rolling_mm=0.01)
VARIANTS = 5 * BATCH_ROWS + 100
RECORD = 16 + BATCH_ROWS * ROW.itemsize


def study(store: Path | None, *, fail_at: int | None = None, told: list[str] | None = None) -> StudyResult:
    """The study of these tests; the machine can fail when a batch is due."""

    def progress(stage: str) -> None:
        if told is not None:
            told.append(stage)
        if stage == f"batch {fail_at} of 6":
            raise MemoryError

    return run_study(MODEL, VARIANTS, 1, requirement=REQUIREMENT, store=store, progress=progress)


@pytest.fixture(scope="module")
def whole() -> StudyResult:
    return study(None)


def interrupted(folder: Path, suffix: str, fail_at: int = 4) -> Path:
    """A study that failed when it had done all batches before one."""
    store = folder / f"rows{suffix}"
    with pytest.raises(MemoryError):
        study(store, fail_at=fail_at)
    return store


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_resumed_study_is_the_uninterrupted_one(
    tmp_path: Path, suffix: str, whole: StudyResult, pyarrow: ModuleType
) -> None:
    for folder in ("once", "twice"):
        (tmp_path / folder).mkdir()
    once = study(tmp_path / "once" / f"rows{suffix}")
    store = interrupted(tmp_path / "twice", suffix)
    assert names(store.parent) == {f"rows{suffix}.journal", f"rows{suffix}.study.json"}
    twice = study(store)
    assert once.rows.tobytes() == twice.rows.tobytes() == whole.rows.tobytes()
    assert once.yield_tilt == twice.yield_tilt == whole.yield_tilt
    assert names(store.parent) == {f"rows{suffix}", f"rows{suffix}.study.json"}
    assert store.read_bytes() == (tmp_path / "once" / f"rows{suffix}").read_bytes()


def test_only_what_is_missing_is_judged(tmp_path: Path) -> None:
    store = interrupted(tmp_path, ".csv", fail_at=4)
    told: list[str] = []
    with pytest.raises(MemoryError):
        study(store, fail_at=6, told=told)
    assert told == [f"batch {k} of 6" for k in range(1, 7)]
    assert (tmp_path / "rows.csv.journal").stat().st_size == 5 * RECORD


@pytest.mark.parametrize(
    ("kept_bytes", "batches"),
    [(0, 0), (5, 0), (16, 0), (RECORD - 1, 0), (RECORD, 1), (RECORD + 16, 1), (3 * RECORD - 7, 2)],
)
def test_a_batch_that_was_cut_off_is_done_again(
    tmp_path: Path, whole: StudyResult, kept_bytes: int, batches: int
) -> None:
    store = interrupted(tmp_path, ".csv")
    journal = tmp_path / "rows.csv.journal"
    assert journal.stat().st_size == 3 * RECORD
    with journal.open("rb+") as stream:
        stream.truncate(kept_bytes)
    with pytest.raises(MemoryError):
        study(store, fail_at=batches + 1)
    assert journal.stat().st_size == batches * RECORD
    assert study(store).rows.tobytes() == whole.rows.tobytes()


@pytest.mark.parametrize(
    ("place", "batches"), [(0, 0), (RECORD + 12, 1), (RECORD + 400, 1), (3 * RECORD - 1, 2)]
)
def test_a_flipped_bit_is_found(tmp_path: Path, whole: StudyResult, place: int, batches: int) -> None:
    store = interrupted(tmp_path, ".csv")
    journal = tmp_path / "rows.csv.journal"
    contents = bytearray(journal.read_bytes())
    contents[place] ^= 4
    journal.write_bytes(contents)
    with pytest.raises(MemoryError):
        study(store, fail_at=batches + 1)
    assert journal.stat().st_size == batches * RECORD
    assert study(store).rows.tobytes() == whole.rows.tobytes()


def test_blocks_that_never_reached_the_disk_are_found(tmp_path: Path, whole: StudyResult) -> None:
    """After a power failure a file may be as long as it should be, and hold zeros."""
    store = interrupted(tmp_path, ".csv")
    (tmp_path / "rows.csv.journal").write_bytes(bytes(3 * RECORD))
    assert study(store).rows.tobytes() == whole.rows.tobytes()


def test_a_finished_study_is_read_and_not_judged_again(
    tmp_path: Path, whole: StudyResult, pyarrow: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("judged again")

    for suffix in (".csv", ".parquet"):
        study(tmp_path / f"rows{suffix}")
    monkeypatch.setattr(LoadedSphere, "judge", fail)
    # What a run leaves that is killed between its last two steps.
    (tmp_path / "rows.csv.journal").write_bytes(b"left over")
    for suffix in (".csv", ".parquet"):
        again = study(tmp_path / f"rows{suffix}")
        assert again.rows.tobytes() == whole.rows.tobytes()
        assert again.tilt_deg == whole.tilt_deg
    assert not (tmp_path / "rows.csv.journal").exists()


def test_the_files_say_what_others_can_read(tmp_path: Path, whole: StudyResult, pyarrow: ModuleType) -> None:
    import pyarrow.parquet as pq

    study(tmp_path / "rows.csv")
    study(tmp_path / "rows.parquet")
    with (tmp_path / "rows.csv").open(newline="") as stream:
        lines = list(csv.DictReader(stream))
    table = pq.read_table(tmp_path / "rows.parquet")
    assert table.column_names == list(lines[0])
    assert [int(line["row"]) for line in lines] == table["row"].to_pylist() == list(range(VARIANTS))
    verdicts = [line["verdict"] for line in lines]
    assert verdicts == table["verdict"].to_pylist()
    assert verdicts.count("monostable") == whole.yield_monostable.passed
    assert verdicts.count("undecided") == whole.yield_monostable.undecided > 0
    margin = [float(line["s_margin_mm"]) if line["s_margin_mm"] else np.nan for line in lines]
    np.testing.assert_array_equal(margin, whole.rows["s_margin_mm"])
    np.testing.assert_array_equal(table["s_margin_mm"].to_numpy(), whole.rows["s_margin_mm"])
    assert json.loads((tmp_path / "rows.csv.study.json").read_text())["seed"] == 1


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (lambda store: run_study(MODEL, VARIANTS, 2, store=store), "rolling_mm, seed"),
        (lambda store: run_study(MODEL, VARIANTS, 1, store=store), "rolling_mm"),
        (lambda store: run_study(MODEL, 700, 1, store=store), "rolling_mm, variants"),
        (
            lambda store: run_study(MODEL.scaled({"along": 1.1}), VARIANTS, 1, store=store),
            "model, rolling_mm",
        ),
    ],
)
@pytest.mark.parametrize("fail_at", [4, None])
def test_the_store_of_another_study_is_left_alone(
    tmp_path: Path, change: Callable[[Path], object], key: str, fail_at: int | None
) -> None:
    store = tmp_path / "rows.csv"
    if fail_at is None:
        study(store)
    else:
        interrupted(tmp_path, ".csv", fail_at)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(StudyError, match=f"belongs to another study: its {key} differ; name another file"):
        change(store)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_angle_may_be_changed_afterwards(tmp_path: Path) -> None:
    """It says which rows are good, and nothing about the rows."""
    study(tmp_path / "rows.csv")
    wide = run_study(MODEL, VARIANTS, 1, requirement=Requirement(90.0, 0.01), store=tmp_path / "rows.csv")
    assert wide.yield_tilt.passed == wide.yield_monostable.passed - wide.may_stall
    assert wide.yield_tilt.passed > study(None).yield_tilt.passed


def refusal(store: Path) -> str:
    with pytest.raises(GombocError) as caught:
        study(store)
    sentence = str(caught.value)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    return sentence


def test_files_of_others_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "rows.csv").write_text("mine\n")
    assert "is no study; name another file" in refusal(tmp_path / "rows.csv")
    assert (tmp_path / "rows.csv").read_text() == "mine\n"
    (tmp_path / "other.csv.study.json").write_text("[1")
    assert "belongs to another study" in refusal(tmp_path / "other.csv")


@pytest.mark.parametrize("damage", ["", "row,verdict\n", "cut", "word", "letters"])
def test_a_finished_file_that_was_changed_is_refused(tmp_path: Path, damage: str) -> None:
    store = tmp_path / "rows.csv"
    study(store)
    text = store.read_text()
    cut = text[: text.rstrip("\n").rindex("\n") + 1]
    damaged = {"cut": cut, "word": text.replace("monostable", "good", 1), "letters": text[:-5] + "ä\n"}
    store.write_text(damaged.get(damage, damage), encoding="utf-8")
    assert "is not as it was written" in refusal(store)


def test_a_finished_parquet_file_that_was_changed_is_refused(tmp_path: Path, pyarrow: ModuleType) -> None:
    store = tmp_path / "rows.parquet"
    study(store)
    store.write_bytes(store.read_bytes()[:-100])
    assert "is not as it was written" in refusal(store)


def test_two_runs_at_once_spoil_no_file(tmp_path: Path, whole: StudyResult) -> None:
    """What the other one writes in between ends what can be read of the journal."""
    store, journal = tmp_path / "rows.csv", tmp_path / "rows.csv.journal"

    def other(stage: str) -> None:
        if stage == "batch 4 of 6":
            with journal.open("ab") as stream:
                stream.write(journal.read_bytes()[:RECORD])

    with pytest.raises(StudyError, match="journal is not as it was written"):
        run_study(MODEL, VARIANTS, 1, requirement=REQUIREMENT, store=store, progress=other)
    assert not store.exists()
    assert study(store).rows.tobytes() == whole.rows.tobytes()


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    assert "does not exist; make it first" in refusal(tmp_path / "nowhere" / "rows.csv")
    assert "written as .csv or .parquet, not as rows.txt" in refusal(tmp_path / "rows.txt")


def test_parquet_needs_its_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "parquet_is_possible", lambda: False)
    assert "install gomboc-cad[parquet], or name a .csv file" in refusal(tmp_path / "rows.parquet")


SCRIPT = """
import sys
from pathlib import Path
from gomboc_cad.errors import GombocError
from gomboc_cad.tolerance.study import run_study
from tests.tolerance.toys import LoadedSphere

def tell(stage):
    print(stage, flush=True)

try:
    run_study(LoadedSphere(pause_s=0.02), 20_000, 1, store=Path(sys.argv[1]), progress=tell)
except GombocError as error:
    sys.exit(str(error))
except KeyboardInterrupt:
    sys.exit(130)
"""


def script(store: Path, before: Callable[[], None] | None = None) -> subprocess.Popen[str]:
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(store)],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        preexec_fn=before,
    )


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_a_study_interrupted_from_outside_goes_on(tmp_path: Path, sent: signal.Signals) -> None:
    store = tmp_path / "rows.csv"
    with script(store) as child:
        assert child.stdout is not None
        while not child.stdout.readline().startswith("batch 5 "):
            assert child.poll() is None
        child.send_signal(sent)
        _, errors = child.communicate(timeout=60)
    assert errors == ""
    assert child.returncode == (130 if sent == signal.SIGINT else -signal.SIGKILL)
    assert not store.exists()
    done = (tmp_path / "rows.csv.journal").stat().st_size // RECORD
    assert 4 <= done < 39
    model = LoadedSphere(pause_s=0.02)
    resumed = run_study(model, 20_000, 1, store=store)
    assert resumed.rows.tobytes() == run_study(LoadedSphere(), 20_000, 1).rows.tobytes()


def test_a_disk_that_takes_no_more_is_told(tmp_path: Path) -> None:
    """The limit on file sizes is a real refusal of the operating system in the midst of a batch."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    store = tmp_path / "rows.csv"
    with script(store, limit) as child:
        _, errors = child.communicate(timeout=60)
    assert child.returncode == 1
    assert "rows.csv.journal could not be written" in errors
    assert errors.count("\n") == 1
    assert not store.exists()
    resumed = run_study(LoadedSphere(pause_s=0.02), 20_000, 1, store=store)
    assert resumed.rows.tobytes() == run_study(LoadedSphere(), 20_000, 1).rows.tobytes()


def test_a_fingerprint_is_of_what_the_fields_say() -> None:
    model = LoadedSphere(margin_mm=0.25)
    before = fingerprint(model)
    assert model.nominal is model.nominal
    assert fingerprint(model) == before == fingerprint(LoadedSphere(margin_mm=0.25))
    things = [
        model,
        LoadedSphere(margin_mm=0.25000000000000006),
        np.arange(6.0),
        np.arange(6.0).reshape(2, 3),
        np.arange(6),
        (1, 2),
        (1, (2,)),
        (1.0, 2.0),
        "12",
        b"12",
        {"a": 1, "b": 2},
        {"a": 2, "b": 1},
        {"ab": (1, 2)},
        frozenset({1, 2}),
        None,
        0,
        0.0,
        False,
        np.float32(0.0),
    ]
    assert len({fingerprint(thing) for thing in things}) == len(things)
    assert fingerprint({"b": 2, "a": 1}) == fingerprint({"a": 1, "b": 2})
    assert fingerprint(np.arange(6.0)[::2]) == fingerprint(np.array([0.0, 2.0, 4.0]))
