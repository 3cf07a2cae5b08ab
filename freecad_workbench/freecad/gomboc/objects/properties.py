"""Properties as data: what a user may set, and what is read-only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

from freecad.gomboc import texts
from freecad.gomboc.errors import GombocCadError

SETTINGS, RESULTS, INTERNAL = "Gomboc", "Result", "Internal"
"""Groups of the property editor."""

# Prop_Output and Prop_NoRecompute: a result does not ask for a recompute.
_RESULT_ATTRIBUTES = 8 | 16


@dataclass(frozen=True)
class Setting:
    """A property that a user sets.

    Attributes:
        name: Of the property.
        argument: Of `api.create_…`.
        key: Dotted key of the spec.
        kind: `length`, `choice` or `text`.
        choices: For a choice, the name of the list of the package that it is from.
    """

    name: str
    argument: str
    key: str
    kind: str
    choices: str = ""

    @property
    def tip(self) -> str:
        """What it is."""
        return texts.TIPS[self.name]


_TYPE_OF_KIND = {
    "length": "App::PropertyLength",
    "choice": "App::PropertyEnumeration",
    "text": "App::PropertyString",
}

BODY_SETTINGS = (
    Setting("Body", "body", "body.name", "choice", "bodies"),
    Setting("Diameter", "diameter_mm", "body.diameter_mm", "length"),
)
PRODUCT_SETTINGS = (
    *BODY_SETTINGS,
    Setting("Wall", "wall_mm", "shell.wall_mm", "length"),
    Setting("Material", "material", "shell.material", "choice", "materials"),
    Setting("Process", "process", "shell.process", "choice", "processes"),
    Setting("Board", "board", "board.type", "choice", "boards"),
    Setting("Species", "species", "seed.species", "choice", "seeds"),
    Setting("Battery", "battery", "battery.type", "choice", "batteries"),
    Setting("Mark", "mark", "mark.text", "text"),
    Setting("Trim", "trim", "trim.kind", "choice", "trims"),
)

COMMON_RESULTS = {
    "Status": "App::PropertyString",
    "Verdict": "App::PropertyString",
    "Good": "App::PropertyBool",
    "Reasons": "App::PropertyStringList",
    "Message": "App::PropertyString",
}
BUILT_FROM = {"BuiltFrom": "App::PropertyString"}
"""Types of properties by their names; what they are says `texts.TIPS`."""


def add(document_object: Any, kind: str, name: str) -> bool:
    """Add a property that a user sets, unless it is there; tell whether it was added."""
    if name in document_object.PropertiesList:
        return False
    document_object.addProperty(kind, name, SETTINGS, texts.tr(texts.TIPS[name]))
    return True


def add_results(document_object: Any, kinds: Mapping[str, str], group: str = RESULTS) -> None:
    """Add read-only properties that are not there yet; those of the group INTERNAL are hidden too."""
    for name, kind in kinds.items():
        if name not in document_object.PropertiesList:
            tip, hidden = texts.tr(texts.TIPS[name]), group == INTERNAL
            document_object.addProperty(kind, name, group, tip, _RESULT_ATTRIBUTES, True, hidden)


def add_setting(document_object: Any, setting: Setting, default: Any, choices: Sequence[str] = ()) -> None:
    """Add a setting with its default; the default is among the choices even if the list does not have it."""
    add(document_object, _TYPE_OF_KIND[setting.kind], setting.name)
    if setting.kind == "choice":
        setattr(document_object, setting.name, [*([] if default in choices else [default]), *choices])
    setattr(document_object, setting.name, default)


def assign(document_object: Any, setting: Setting, value: Any) -> None:
    """Set a property from a script's argument.

    Raises:
        GombocCadError: If the value does not fit; the text says what does.
    """
    if setting.kind == "length":
        value = number(setting.argument, value)
    elif setting.kind == "choice":
        choices = document_object.getEnumerationsOfProperty(setting.name)
        if value not in choices:
            raise GombocCadError(
                texts.tr(texts.NO_SUCH_CHOICE, name=setting.argument, value=value, names=", ".join(choices))
            )
    setattr(document_object, setting.name, value)


def value_of(document_object: Any, setting: Setting) -> Any:
    """The value of a setting as the spec has it: a number in mm, or text."""
    value = getattr(document_object, setting.name)
    return exact_mm(value.Value) if setting.kind == "length" else str(value)


def exact_mm(length: float) -> float:
    """A length as it was typed: FreeCAD's units leave noise in the last digits."""
    return float(f"{length:.12g}")


def default_of(spec: Mapping[str, Any], key: str) -> Any | None:
    """The value at a dotted key of a spec; None if it has no such table."""
    found: Any = spec
    for name in key.split("."):
        if not isinstance(found, Mapping) or name not in found:
            return None
        found = found[name]
    return found


def number(name: str, value: Any) -> float:
    """A finite number.

    Raises:
        GombocCadError: If it is none.
    """
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = math.nan
    if isinstance(value, bool) or not math.isfinite(result):
        raise GombocCadError(
            texts.tr(texts.BAD_VALUE, name=name, value=value, wanted=texts.tr(texts.A_NUMBER))
        )
    return result


def point(name: str, value: Any) -> tuple[float, float, float]:
    """Three finite numbers, of a sequence or of FreeCAD's vector.

    Raises:
        GombocCadError: If it is something else.
    """
    wanted = texts.tr(texts.THREE_NUMBERS)
    try:
        entries = [] if isinstance(value, str) else list(value)
    except TypeError:
        entries = []
    if len(entries) != 3:
        raise GombocCadError(texts.tr(texts.BAD_VALUE, name=name, value=value, wanted=wanted))
    x, y, z = (number(name, entry) for entry in entries)
    return x, y, z
