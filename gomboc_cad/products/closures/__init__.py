"""How the two parts of a product are closed: dowels, screws, thread rings, snap and press fits."""

from gomboc_cad.products.closures.spec import (
    ClosureSpec,
    DowelsSpec,
    PressSpec,
    ScrewsSpec,
    SnapSpec,
    ThreadRingSpec,
)

__all__ = ["ClosureSpec", "DowelsSpec", "PressSpec", "ScrewsSpec", "SnapSpec", "ThreadRingSpec"]
