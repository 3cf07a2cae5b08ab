"""Typed TOML: reading a file safely and turning every mistake in it into one clear sentence."""

from __future__ import annotations

import difflib
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from gomboc_cad.errors import SpecError

MAX_FILE_BYTES = 1_000_000
_QUOTE = "'"

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Count = Annotated[int, Field(strict=True)]
Text = Annotated[str, Field(strict=True, min_length=1, max_length=200)]
Coordinate = Annotated[float, Field(strict=True, ge=-1e4, le=1e4)]
Point = tuple[Coordinate, Coordinate, Coordinate]


class TomlModel(BaseModel):
    """Base of all specs and data files: frozen, and unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")


Model = TypeVar("Model", bound=TomlModel)


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        SpecError: If it is missing, not a file, too large, not UTF-8 or not TOML.
    """
    try:
        if path.is_dir():
            raise SpecError(f"{path} is a folder; give a TOML file.")
        with path.open("rb") as stream:
            data = stream.read(MAX_FILE_BYTES + 1)
    except FileNotFoundError:
        raise SpecError(f"There is no file {path}; check the name, or give the name of a template.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SpecError(f"{path} cannot be read: {reason}.") from None
    if len(data) > MAX_FILE_BYTES:
        raise SpecError(f"{path} is larger than {MAX_FILE_BYTES} bytes, which no spec is; give a TOML file.")
    try:
        return tomllib.loads(data.decode("utf-8"))
    except UnicodeDecodeError:
        raise SpecError(f"{path} is not text in UTF-8; save it as UTF-8.") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise SpecError(f"{path} is not valid TOML: {error}.") from None


def parse_model(model: type[Model], data: dict[str, Any], source: str) -> Model:
    """Validate data against a model.

    Raises:
        SpecError: With every mistake as key, value and what is allowed.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        mistakes = "; ".join(_mistake(model, dict(detail)) for detail in error.errors(include_url=False)[:5])
        raise SpecError(f"{source}: {mistakes}.") from None


@dataclass
class _Place:
    """Where in a model a location of pydantic leads.

    Attributes:
        keys: The keys of the file on the way.
        owner: The model that the last key was looked for in, if it is known.
        field: The last field that was found.
    """

    keys: list[str | int]
    owner: type[BaseModel] | None
    field: FieldInfo | None


def _mistake(model: type[BaseModel], detail: dict[str, Any]) -> str:
    """Say what is wrong with one key."""
    place = _place(model, detail["loc"])
    key = ".".join(str(part) for part in place.keys)
    kind = detail["type"]
    if kind == "extra_forbidden":
        return f"unknown key {key}{_suggestion(place)}"
    if kind == "missing":
        return f"the key {key} is missing"
    if kind == "value_error":
        prefix = f"{key}: " if key else ""
        return prefix + str(detail["ctx"]["error"])
    if kind in {"union_tag_invalid", "union_tag_not_found"}:
        allowed = ", ".join(str(tag) for tag in _variants(place.field))
        key = f"{key}.{detail['ctx']['discriminator'].strip(_QUOTE)}"
        if kind == "union_tag_not_found":
            return f"the key {key} is missing (allowed: {allowed})"
        return f"{key} = {detail['ctx']['tag']!r} is not allowed (allowed: {allowed})"
    allowed = allowed_values(place.field) if place.field is not None else ""
    shown = repr(detail["input"])
    shown = shown if len(shown) <= 60 else shown[:57] + "..."
    reason = detail["msg"][0].lower() + detail["msg"][1:]
    return f"{key} = {shown} is not allowed ({allowed or reason})"


def _place(model: type[BaseModel], location: tuple[str | int, ...]) -> _Place:
    """Follow a location, in which branches of a union carry names that are no keys of the file."""
    place = _Place([], model, None)
    current: type[BaseModel] | None = model
    for part in location:
        if (variant := _variants(place.field).get(part)) and current is None:
            current = variant
            continue
        if isinstance(part, str) and not (part.isidentifier() or part.isalnum()):
            continue
        place.keys.append(part)
        place.owner = current
        field = current.model_fields.get(part) if current is not None and isinstance(part, str) else None
        place.field = field or place.field
        current = _model_within(field.annotation) if field and not _variants(field) else None
    return place


def _variants(field: FieldInfo | None) -> dict[str | int, type[BaseModel]]:
    """Models that a field may hold, by the value of the key that chooses; empty where none does."""
    if field is None or not isinstance(field.discriminator, str):
        return {}
    models = [choice for choice in get_args(field.annotation) if issubclass(choice, BaseModel)]
    tags = [(get_args(choice.model_fields[field.discriminator].annotation), choice) for choice in models]
    return {value: choice for values, choice in tags for value in values}


def _model_within(annotation: Any) -> type[BaseModel] | None:
    candidates = [annotation, *getattr(annotation, "__args__", ())]
    return next((c for c in candidates if isinstance(c, type) and issubclass(c, BaseModel)), None)


def _suggestion(place: _Place) -> str:
    known = list(place.owner.model_fields) if place.owner else []
    near = difflib.get_close_matches(str(place.keys[-1]), known, n=1)
    return f" (did you mean {near[0]}?)" if near else f" (known here: {', '.join(known)})"


def allowed_values(field: FieldInfo) -> str:
    """Describe the range of a field, or its choices, in words; empty if it has none."""
    choices = getattr(field.annotation, "__args__", ())
    if choices and all(isinstance(choice, str) for choice in choices):
        return "allowed: " + ", ".join(choices)
    low, high = -math.inf, math.inf
    opens = closes = ""
    for rule in field.metadata:
        if isinstance(rule, Ge | MinLen):
            low, opens = float(getattr(rule, "ge", getattr(rule, "min_length", 0))), "from "
        elif isinstance(rule, Gt):
            low, opens = float(str(rule.gt)), "more than "
        elif isinstance(rule, Le | MaxLen):
            high, closes = float(getattr(rule, "le", getattr(rule, "max_length", 0))), "to "
        elif isinstance(rule, Lt):
            high, closes = float(str(rule.lt)), "less than "
    if opens and closes:
        return f"allowed: {opens}{low:g} {'' if closes == 'to ' else 'and '}{closes}{high:g}"
    if opens:
        return f"allowed: {opens.replace('from', 'at least')}{low:g}"
    if closes:
        return f"allowed: {closes.replace('to', 'at most')}{high:g}"
    return ""
