"""The panels that place a centre of mass: of a product for good, of any other part for a trial."""

from __future__ import annotations

from typing import Any, Callable, Tuple

from freecad.gomboc import door, gui_texts, recorded
from freecad.gomboc.texts import tr

from . import task

Point = Tuple[float, float, float]

_BEST, _CENTROID, _POINT = "best", "centroid", "point"
_ICON = "gomboc-place-com"
_AXES = "XYZ"
_LARGEST_MM = 10_000.0


def ask_for_product(product: Any, picked: Point | None) -> None:
    """Choose the target and the help for it, then rebuild the product."""
    widgets = door.QtWidgets
    layout = widgets.QFormLayout()
    target = widgets.QComboBox()
    target.setObjectName("GombocTarget")
    target.setToolTip(tr(gui_texts.TARGET_TIP))
    for value, text in (
        (_BEST, gui_texts.TARGET_BEST),
        (_CENTROID, gui_texts.TARGET_CENTROID),
        (_POINT, gui_texts.TARGET_POINT),
    ):
        target.addItem(tr(text), value)
    place = _Place(tuple(product.CentreOfMass) if picked is None else _in_frame_of(product, picked))
    place.enable(False)
    target.currentIndexChanged.connect(lambda _: place.enable(target.currentData() == _POINT))
    trim = widgets.QComboBox()
    trim.setObjectName("GombocTrim")
    if "Trim" in product.PropertiesList:
        trim.addItems(product.getEnumerationsOfProperty("Trim"))
        trim.setCurrentText(product.Trim)
    layout.addRow(tr(gui_texts.TARGET), target)
    place.add_to(layout)
    if trim.count():
        layout.addRow(tr(gui_texts.TRIM), trim)
    if picked is not None:
        target.setCurrentIndex(target.findData(_POINT))

    def rebuild() -> Any:
        chosen = place.value() if target.currentData() == _POINT else target.currentData()
        trims = f", trim={trim.currentText()!r}" if trim.count() else ""
        recorded.call(f"place_com({recorded.name(product)}, {chosen!r}{trims})")
        return product

    task.show(task.Task("GombocPlace", tr(gui_texts.PLACE_OF, label=product.Label), _ICON, layout, rebuild))


def ask_for_part(part: Any, picked: Point | None) -> None:
    """Try a centre of mass: the part is checked about it, and the way there is told."""
    widgets = door.QtWidgets
    layout = widgets.QFormLayout()
    own = _centroid(part)
    place = _Place(picked or own or (0.0, 0.0, 0.0))
    way = widgets.QLabel()
    way.setObjectName("GombocWay")
    way.setWordWrap(True)

    def tell_way() -> None:
        if own is None:
            way.setText(tr(gui_texts.NO_CENTROID))
        else:
            shift = [there - here for there, here in zip(place.value(), own)]
            length = sum(each * each for each in shift) ** 0.5
            way.setText(tr(gui_texts.WAY, x=own[0], y=own[1], z=own[2], shift=length))

    place.changed.append(tell_way)
    tell_way()
    place.add_to(layout)
    layout.addRow(way)

    def check() -> Any:
        return recorded.call(
            f"create_check({recorded.document(part)}, {recorded.name(part)}, com_mm={place.value()!r})"
        )

    task.show(task.Task("GombocPlace", tr(gui_texts.PLACE_OF, label=part.Label), _ICON, layout, check))


class _Place:
    """Three numbers, a row each."""

    def __init__(self, point: Point) -> None:
        self.changed: list[Callable[[], None]] = []
        self._boxes = []
        for axis, coordinate in zip(_AXES, point):
            box = door.QtWidgets.QDoubleSpinBox()
            box.setObjectName(f"GombocPoint{axis}")
            box.setRange(-_LARGEST_MM, _LARGEST_MM)
            box.setDecimals(4)
            box.setSuffix(" mm")
            box.setValue(coordinate)
            box.valueChanged.connect(lambda _: self._tell())
            self._boxes.append(box)

    def add_to(self, layout: Any) -> None:
        """Append the rows to a form."""
        for axis, box in zip(_AXES, self._boxes):
            layout.addRow(axis, box)

    def _tell(self) -> None:
        for tell in self.changed:
            tell()

    def value(self) -> Point:
        """The point."""
        x, y, z = (box.value() for box in self._boxes)
        return x, y, z

    def enable(self, enabled: bool) -> None:
        """Let it be changed, or not."""
        for box in self._boxes:
            box.setEnabled(enabled)


def _in_frame_of(product: Any, point: Point) -> Point:
    x, y, z = product.Placement.inverse().multVec(door.App.Vector(*point))
    return x, y, z


def _centroid(part: Any) -> Point | None:
    shape = getattr(part, "Shape", None)
    if shape is None or not getattr(shape, "Solids", None):
        return None
    centre = shape.CenterOfGravity
    return centre.x, centre.y, centre.z
