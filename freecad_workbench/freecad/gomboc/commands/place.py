"""The button that places a centre of mass."""

from __future__ import annotations

from freecad.gomboc import gui_texts
from freecad.gomboc.panels import place

from . import selected
from .command import Command


def _place() -> None:
    product, picked = selected.product(), selected.point()
    if product is not None:
        place.ask_for_product(product, picked)
    else:
        place.ask_for_part(selected.part(), picked)


COMMANDS = (
    Command(
        "Gomboc_PlaceCom",
        "gomboc-place-com",
        gui_texts.PLACE_COM,
        gui_texts.PLACE_COM_TIP,
        _place,
        lambda: selected.product() is not None or selected.part() is not None,
    ),
)
