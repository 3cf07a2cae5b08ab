"""Laying out a closure of any kind."""

from __future__ import annotations

from gomboc_cad.products.closures.dowels import lay_out_dowels
from gomboc_cad.products.closures.press import lay_out_press
from gomboc_cad.products.closures.records import ClosureLayout, ClosureSite
from gomboc_cad.products.closures.screws import lay_out_screws
from gomboc_cad.products.closures.snap import lay_out_snap
from gomboc_cad.products.closures.spec import (
    ClosureSpec,
    DowelsSpec,
    PressSpec,
    ScrewsSpec,
    SnapSpec,
    ThreadRingSpec,
)
from gomboc_cad.products.closures.thread_ring import lay_out_thread_ring

__all__ = ["ClosureLayout", "ClosureSite", "lay_out_closure"]


def lay_out_closure(spec: ClosureSpec, site: ClosureSite) -> ClosureLayout:
    """Find places and sizes for a closure, and make the parts that it brings.

    Args:
        spec: What is asked for.
        site: Where it goes.

    Raises:
        SpecError: If a standard part or a material is not available.
        GeometryError: If it does not fit, meets something that it must stay clear of, or asks too much of
            the material.
    """
    match spec:
        case DowelsSpec():
            return lay_out_dowels(spec, site)
        case ScrewsSpec():
            return lay_out_screws(spec, site)
        case ThreadRingSpec():
            return lay_out_thread_ring(spec, site)
        case SnapSpec():
            return lay_out_snap(spec, site)
        case PressSpec():
            return lay_out_press(spec, site)
