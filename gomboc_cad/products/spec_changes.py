"""Changes of a spec that are given on the command line instead of in a file."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

from gomboc_cad.errors import SpecError


def changed(data: dict[str, Any], changes: Sequence[str]) -> dict[str, Any]:
    """Apply changes to the tables of a spec; whether the result is allowed is for its model to say.

    Args:
        data: The spec as read; it is changed in place.
        changes: `KEY=VALUE` each. The key is dotted (`body.diameter_mm`), entries of a list count from 0
            (`ports.0.name`). The value is TOML; what is no TOML is text, so names need no quotes.

    Raises:
        SpecError: If a change has no key or no sign of equality, or its key leads through something that is
            no table.
    """
    for change in changes:
        key, equals, text = change.partition("=")
        names = [name.strip() for name in key.split(".")]
        if not equals or not all(names):
            raise SpecError(f"--set {change}: write KEY=VALUE, for example --set body.diameter_mm=60.")
        inner: Any = data
        for name in names[:-1]:
            inner = _entry(inner, name, change)
        _put(inner, names[-1], _value(text.strip()), change)
    return data


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        return text


def _entry(inner: Any, name: str, change: str) -> Any:
    """What a name leads to; a table that is not there yet is begun."""
    if isinstance(inner, dict):
        return inner.setdefault(name, {})
    return _listed(inner, name, change)[int(name)]


def _put(inner: Any, name: str, value: Any, change: str) -> None:
    if isinstance(inner, dict):
        inner[name] = value
    else:
        _listed(inner, name, change)[int(name)] = value


def _listed(inner: Any, name: str, change: str) -> list[Any]:
    """The list that a number is an index of."""
    if not isinstance(inner, list):
        raise SpecError(f"--set {change}: what is before {name!r} is a value and no table.")
    if not (name.isascii() and name.isdigit()) or len(name) > 6 or int(name) >= len(inner):
        raise SpecError(
            f"--set {change}: {name!r} is no entry of a list of {len(inner)} (they count from 0)."
        )
    return inner
