"""Buttons that make a body or a product: a panel asks for the main settings, then it is computed."""

from __future__ import annotations

from typing import Any, Callable

from freecad.gomboc import gui_texts, lists, recorded
from freecad.gomboc.objects import body, properties
from freecad.gomboc.panels import form, task
from freecad.gomboc.texts import tr
from freecad.gomboc.views import icons

from .command import Command, has_document


def _ask_body() -> None:
    usual = (body.DEFAULT_BODY, body.DEFAULT_DIAMETER_MM, body.DEFAULT_MATERIAL)
    fields = form.Form(zip(body.SETTINGS, usual), lists.lists())

    def make() -> Any:
        values = fields.changed()
        name = values.pop("body", body.DEFAULT_BODY)
        return recorded.call(f"create_body(App.ActiveDocument, {name!r}{recorded.keywords(values)})")

    task.show(task.Task("GombocNew", tr(gui_texts.BODY), icons.OF_KIND["body"], fields.layout, make))


def _ask_product(name: str, title: str) -> Callable[[], None]:
    def ask() -> None:
        offered = lists.lists()
        spec = offered.products[name]
        template = ((s, properties.default_of(spec, s.key)) for s in properties.PRODUCT_SETTINGS)
        fields = form.Form(((s, value) for s, value in template if value is not None), offered)
        fields.add_overrides()

        def make() -> Any:
            values = recorded.keywords(fields.changed())
            return recorded.call(f"create_product(App.ActiveDocument, {name!r}{values})")

        task.show(task.Task("GombocNew", tr(title), icons.OF_KIND[name], fields.layout, make))

    return ask


COMMANDS = (
    Command("Gomboc_Body", "gomboc-body", gui_texts.BODY, gui_texts.BODY_TIP, _ask_body, has_document),
    *(
        Command(command, icons.OF_KIND[name], title, tip, _ask_product(name, title), has_document)
        for command, name, title, tip in (
            ("Gomboc_ImuHousing", "imu-housing", gui_texts.HOUSING, gui_texts.HOUSING_TIP),
            ("Gomboc_SeedPod", "seed-pod", gui_texts.POD, gui_texts.POD_TIP),
            ("Gomboc_Buoy", "buoy", gui_texts.BUOY, gui_texts.BUOY_TIP),
        )
    ),
)
