"""What a user can choose from: bodies, products, boards, materials; the package is asked once a session."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from . import cli, environment
from .process import run

_TIMEOUT_S = 120.0
_CHOICES = ("boards", "batteries", "seeds", "processes", "materials", "trims")


@dataclass(frozen=True)
class Lists:
    """The choices that a version of the package offers.

    Attributes:
        choices: Names by what they are for: `bodies` (those that are not refuted), `boards`, `batteries`,
            `seeds`, `processes`, `materials`, `trims`.
        density_g_cm3: Of each material.
        products: The spec of each product's template, as nested tables.
    """

    choices: Mapping[str, tuple[str, ...]]
    density_g_cm3: Mapping[str, float]
    products: Mapping[str, Mapping[str, Any]]

    @classmethod
    def of_documents(cls, catalog: Mapping[str, Any], templates: Mapping[str, Any]) -> Lists:
        """The lists in the answers of `catalog` and `templates`."""
        choices = {name: tuple(templates[name]) for name in _CHOICES}
        choices["bodies"] = tuple(body["name"] for body in catalog["bodies"] if body["status"] != "refuted")
        return cls(choices, templates["density_g_cm3"], templates["specs"])


_known: dict[tuple[str, str], Lists] = {}


def lists() -> Lists:
    """The lists of the package that is chosen; asked once for each Python and version.

    Raises:
        GombocCadError: If there is no package, or it does not answer.
    """
    python = environment.ready_python()
    found = environment.state()
    key = (python, found.version if isinstance(found, environment.Ready) else "")
    if key not in _known:
        catalog, templates = (
            run(python, arguments, _TIMEOUT_S).document() for arguments in (cli.catalog(), cli.templates())
        )
        _known[key] = Lists.of_documents(catalog, templates)
    return _known[key]
