"""The figures of the source paper (arXiv 2604.17095 v1), as data."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from importlib import resources
from typing import Any


@lru_cache(maxsize=1)
def published() -> dict[str, Any]:
    """All figures by table, as `tables.toml` beside this module has them; lengths of unit-radius bodies."""
    text = resources.files("gomboc_cad.paper").joinpath("tables.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
