"""The `[body]` table of a spec, and the refusal of bodies that nothing should be built of."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from gomboc_cad.body import Body, catalogue_entries, make_body
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.equilibria import convexity
from gomboc_cad.errors import UnverifiedBodyError
from gomboc_cad.products.toml_model import Number, Text, TomlModel


class BodySpec(TomlModel):
    """The outer shape: a catalogue name, or a family with its parameters.

    Attributes:
        name: Name in the catalogue.
        family: `sloan1`, `sloan2`, `extended` or `harmonic`, instead of a name.
        beta: Amplitude β of a Sloan family.
        coefficients: `{"k" = a}` or `{"l,m" = c}`.
        diameter_mm: Nominal diameter 2 R₀.
    """

    name: Text | None = None
    family: Text | None = None
    beta: Number | None = None
    coefficients: Annotated[dict[str, Number], Field(default_factory=dict, max_length=500)]
    diameter_mm: Annotated[Number, Field(ge=10.0, le=2000.0)] = 100.0

    @model_validator(mode="after")
    def _one_way(self) -> BodySpec:
        if (self.name is None) == (self.family is None):
            raise ValueError("give either name or family, not both and not neither")
        if self.name is not None and (self.beta is not None or self.coefficients):
            raise ValueError("beta and coefficients go with family, not with name")
        return self

    def body(self) -> Body:
        """Make the body.

        Raises:
            BodyError: If the name or the parameters are not usable.
        """
        if self.name is not None:
            return named_body(self.name, self.diameter_mm)
        return make_body(self.family or "", self.beta, self.coefficients, diameter_mm=self.diameter_mm)


def require_verified(body: Body) -> None:
    """Refuse a body that is refuted or not strictly convex.

    Raises:
        UnverifiedBodyError: With the reason and what to do.
    """
    entry = catalogue_entries().get(body.name)
    if entry is not None and entry.status == "refuted":
        raise UnverifiedBodyError(
            f"The body {body.name!r} is refuted and no product should be made of it: {entry.reason} "
            "Choose another body, or add --allow-unverified."
        )
    found = convexity(body)
    if not found.strictly_convex:
        raise UnverifiedBodyError(
            f"The body {body.name!r} is not strictly convex (smallest principal curvature "
            f"{found.min_curvature_per_mm:.3g} per mm), so it rests on its hull and nothing is known of "
            "it; lower beta or the coefficients, or add --allow-unverified."
        )
