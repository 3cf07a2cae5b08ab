"""Files that appear whole or not at all, and output folders that are filled whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from gomboc_cad.errors import OutputError


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path`, and rename it to `path` when the block has ended well.

    After an exception, a keyboard interrupt included, the temporary file is gone and `path` is as before.

    Raises:
        OutputError: If the file cannot be written there.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with writing_to(path):
            yield part
            os.replace(part, path)
    finally:
        with suppress(OSError):
            part.unlink()


def write_bytes(path: Path, data: bytes) -> None:
    """Write a whole file, or none; see `atomic_path`."""
    with atomic_path(path) as part, part.open("xb") as stream:
        stream.write(data)
        stream.flush()
        # A disk may report that it is full only now.
        os.fsync(stream.fileno())


def json_bytes(document: Mapping[str, Any], indent: int = 2) -> bytes:
    """A document as the bytes of its file: UTF-8, and no number that JSON does not have."""
    return (json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False) + "\n").encode()


@contextmanager
def open_output(folder: Path, force: bool = False) -> Iterator[Path]:
    """Give a temporary folder to fill, whose files move into `folder` when the block has ended well.

    After an exception, a keyboard interrupt included, nothing is left behind and `folder` is as before.

    Args:
        folder: Where the files shall be; missing parents are made at the end.
        force: Allow a folder that holds something already. Files of the same name are replaced, others stay.

    Raises:
        OutputError: If the folder holds something and `force` is not set, or cannot be written.
    """
    target = Path(os.path.abspath(folder))
    there = next(path for path in (target, *target.parents) if path.exists())
    if not there.is_dir():
        raise OutputError(f"{there} is a file; name a folder to write to.")
    if not os.access(there, os.W_OK | os.X_OK):
        raise OutputError(f"No permission to write {folder}; name another place.")
    with writing_to(folder):
        if there == target and not force and any(target.iterdir()):
            raise OutputError(f"{folder} exists and is not empty; name another folder or use --force.")
        # Beside the target or nearest to it, so that renaming moves no data between disks.
        staging = (there if there != target else target.parent) / f".{target.name}.{os.getpid()}.part"
        staging.mkdir()
    try:
        yield staging
        with writing_to(folder):
            _move_files(staging, target)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _move_files(staging: Path, target: Path) -> None:
    """Move all files of one folder into another, after looking for names that stand in the way."""
    files = sorted(path.relative_to(staging) for path in staging.rglob("*") if path.is_file())
    for file in files:
        if (target / file).is_dir():
            raise OutputError(f"{target / file} is a folder where a file must go; move it away.")
    target.mkdir(parents=True, exist_ok=True)
    for file in files:
        (target / file).parent.mkdir(parents=True, exist_ok=True)
        os.replace(staging / file, target / file)


@contextmanager
def writing_to(path: Path) -> Iterator[None]:
    """Turn an operating system's refusal to write into one sentence about `path`."""
    try:
        yield
    except OSError as error:
        raise OutputError(_sentence(path, error)) from error


def _sentence(path: Path, error: OSError) -> str:
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"The disk is full: {path} could not be written; free some space and try again."
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return f"No permission to write {path}; name another place."
    if error.errno in (errno.ENOENT, errno.ENOTDIR):
        return f"The folder of {path} does not exist; make it first."
    return f"{path} could not be written: {error.strerror or error}."
