"""Files and folders appear whole or not at all."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gomboc_cad.errors import OutputError
from gomboc_cad.solid.output import atomic_path, open_output, write_bytes


def names(folder: Path) -> list[str]:
    """Everything in a folder, hidden things included."""
    return sorted(path.name for path in folder.iterdir())


def fail_with(number: int):
    """A function that refuses as the operating system does."""

    def refuse(*_args, **_kwargs):
        raise OSError(number, os.strerror(number))

    return refuse


def test_a_file_is_written_and_replaced(tmp_path: Path) -> None:
    write_bytes(tmp_path / "a.bin", b"one")
    write_bytes(tmp_path / "a.bin", b"two")
    assert (tmp_path / "a.bin").read_bytes() == b"two"
    assert names(tmp_path) == ["a.bin"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_an_interrupted_file_leaves_the_old_one(tmp_path: Path, interruption: type[BaseException]) -> None:
    write_bytes(tmp_path / "a.bin", b"old")

    def write_half() -> None:
        with atomic_path(tmp_path / "a.bin") as part:
            part.write_bytes(b"half of the n")
            raise interruption

    with pytest.raises(interruption):
        write_half()
    assert (tmp_path / "a.bin").read_bytes() == b"old"
    assert names(tmp_path) == ["a.bin"]


@pytest.mark.parametrize(
    ("number", "sentence"),
    [
        (errno.ENOSPC, "disk is full"),
        (errno.EACCES, "No permission"),
        (errno.EROFS, "No permission"),
        (errno.EIO, "could not be written"),
    ],
)
@pytest.mark.parametrize("function", ["fsync", "replace"])
def test_refusals_of_the_system_become_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, sentence: str, function: str
) -> None:
    monkeypatch.setattr(os, function, fail_with(number))
    with pytest.raises(OutputError, match=sentence) as caught:
        write_bytes(tmp_path / "a.bin", b"data")
    assert "a.bin" in str(caught.value)
    assert names(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="limits of file size exist on POSIX only")
def test_a_real_limit_of_the_system_leaves_nothing(tmp_path: Path) -> None:
    script = (
        "import resource, sys; from pathlib import Path\n"
        "from gomboc_cad.errors import OutputError\n"
        "from gomboc_cad.solid.output import write_bytes\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try: write_bytes(Path(sys.argv[1]), bytes(5000))\n"
        "except OutputError as error: sys.exit(str(error))\n"
    )
    done = subprocess.run(
        [sys.executable, "-B", "-c", script, str(tmp_path / "a.bin")],
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 1
    assert "a.bin could not be written: File too large." in done.stderr
    assert names(tmp_path) == []


def test_a_missing_or_impossible_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    for parent in ("missing", "file"):
        with pytest.raises(OutputError, match="does not exist; make it first"):
            write_bytes(tmp_path / parent / "a.bin", b"")


def test_a_new_folder_appears_with_all_its_files(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "out"
    with open_output(target) as staging:
        (staging / "a.txt").write_text("a")
        (staging / "figures").mkdir()
        (staging / "figures" / "b.txt").write_text("b")
        assert not (tmp_path / "deep").exists()
    assert names(target) == ["a.txt", "figures"]
    assert (target / "figures" / "b.txt").read_text() == "b"
    assert names(tmp_path) == ["deep"]


def test_an_empty_folder_is_used(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with open_output(tmp_path / "out") as staging:
        (staging / "a.txt").write_text("a")
    assert names(tmp_path / "out") == ["a.txt"]


def test_a_folder_that_holds_something_is_refused_without_force(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with (
        pytest.raises(OutputError, match="not empty; name another folder or use --force"),
        open_output(tmp_path),
    ):
        pytest.fail("the block must not run")
    assert names(tmp_path) == ["mine.txt"]


def test_force_replaces_only_what_it_writes(tmp_path: Path) -> None:
    target = tmp_path / "out"
    target.mkdir()
    (target / "mine.txt").write_text("mine")
    (target / "a.txt").write_text("old")
    with open_output(target, force=True) as staging:
        (staging / "a.txt").write_text("new")
    assert (target / "mine.txt").read_text() == "mine"
    assert (target / "a.txt").read_text() == "new"
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt])
@pytest.mark.parametrize("force", [False, True])
def test_an_interrupted_folder_is_as_before(
    tmp_path: Path, interruption: type[BaseException], force: bool
) -> None:
    target = tmp_path / "out"
    if force:
        target.mkdir()
        (target / "a.txt").write_text("old")

    def write_some() -> None:
        with open_output(target, force) as staging:
            (staging / "a.txt").write_text("new")
            raise interruption

    with pytest.raises(interruption):
        write_some()
    assert names(tmp_path) == (["out"] if force else [])
    assert not force or (target / "a.txt").read_text() == "old"


def test_a_file_in_the_place_of_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    for folder in (tmp_path / "out", tmp_path / "out" / "deeper"):
        with pytest.raises(OutputError, match="is a file"), open_output(folder, force=True):
            pytest.fail("the block must not run")


def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_moves(tmp_path: Path) -> None:
    (tmp_path / "out" / "b.txt").mkdir(parents=True)

    def write_both() -> None:
        with open_output(tmp_path / "out", force=True) as staging:
            (staging / "a.txt").write_text("a")
            (staging / "b.txt").write_text("b")

    with pytest.raises(OutputError, match="is a folder where a file must go"):
        write_both()
    assert names(tmp_path / "out") == ["b.txt"]


def test_a_folder_without_permission_is_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(OutputError, match="No permission"), open_output(tmp_path / "out"):
        pytest.fail("the block must not run")


def test_a_disk_that_fills_up_at_the_end_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write_until_full() -> None:
        with open_output(tmp_path / "out") as staging:
            (staging / "a.txt").write_text("a")
            monkeypatch.setattr(os, "replace", fail_with(errno.ENOSPC))

    with pytest.raises(OutputError, match="disk is full"):
        write_until_full()
    assert not list(tmp_path.rglob("*.txt"))
    assert not list(tmp_path.rglob("*.part"))
