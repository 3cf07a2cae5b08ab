"""Does a stored study belong to this model? A hash of everything that the fields of its records say.

A pickle would not do: it holds what a record has computed for itself since, and differs by which equal
objects are one and the same.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import PurePath

import numpy as np

_PLAIN = (bool, int, float, complex, str, bytes, Enum, PurePath, type, type(None))


def fingerprint(thing: object) -> str:
    """Hash a tree of dataclasses, collections, arrays and numbers; anything else by its pickle."""
    return _digest(thing).hex()


def _digest(thing: object) -> bytes:
    if isinstance(thing, np.ndarray):
        contents = np.ascontiguousarray(thing).tobytes()
        return _hash("array", [repr((thing.dtype.str, thing.shape)).encode(), contents])
    if is_dataclass(thing) and not isinstance(thing, type):
        own = ((field.name, getattr(thing, field.name)) for field in fields(thing))
        return _hash(f"{type(thing).__module__}.{type(thing).__qualname__}", map(_digest, own))
    if isinstance(thing, Mapping):
        return _hash("mapping", sorted(_digest(item) for item in thing.items()))
    if isinstance(thing, (set, frozenset)):
        return _hash("set", sorted(map(_digest, thing)))
    if isinstance(thing, (tuple, list)):
        return _hash("sequence", map(_digest, thing))
    if isinstance(thing, _PLAIN):
        return _hash(type(thing).__name__, [repr(thing).encode()])
    return _hash("pickle", [pickle.dumps(thing, protocol=5)])


def _hash(kind: str, parts: Iterable[bytes]) -> bytes:
    """Hash parts so that no two different lists of parts look alike."""
    digest = hashlib.sha256(kind.encode() + b"\0")
    for part in parts:
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.digest()
