"""What all objects of the workbench have in common: they are computed by the package, and keep its answer.

A proxy holds nothing of its own: everything is in the properties of its object, which FreeCAD saves.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping, Sequence

from freecad.gomboc import door, jobs

from . import properties


class Computed:
    """Proxy of a computed object; each kind says how its inputs, command line and results look."""

    kind = ""

    def __init__(self, document_object: Any) -> None:
        document_object.Proxy = self
        self._add_properties(document_object)

    def _add_properties(self, document_object: Any) -> None:
        """Give the object the properties that it lacks."""
        properties.add_results(document_object, properties.COMMON_RESULTS)
        properties.add_results(document_object, properties.BUILT_FROM, properties.INTERNAL)
        if not document_object.Status:
            document_object.Status = jobs.NEW

    def inputs(self, document_object: Any) -> str:
        """Text that tells whether the object has to be computed again."""
        raise NotImplementedError

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """Arguments of the Python that has the package; input files go into the folder.

        Raises:
            GombocCadError: If what the object stands for cannot be computed.
        """
        raise NotImplementedError

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> Any:
        """Make all of an answer that `update` needs; nothing is changed yet.

        Raises:
            GombocCadError: If the answer does not hold together.
        """
        raise NotImplementedError

    def show(self, document_object: Any, results: Any) -> None:
        """Set the properties, the shape and the children from what `read` made."""
        raise NotImplementedError

    def update(self, document_object: Any, results: Any, inputs: str) -> None:
        """Take results over, and remember the inputs they are of."""
        self.show(document_object, results)
        document_object.Message = ""
        document_object.BuiltFrom = inputs
        document_object.Status = jobs.DONE
        door.refresh_view(document_object)

    def execute(self, document_object: Any) -> None:
        """Called by FreeCAD's recompute: compute what changed, in the background where there are windows."""
        if document_object.BuiltFrom and self.inputs(document_object) == document_object.BuiltFrom:
            jobs.queue.withdraw(document_object)
        elif jobs.waits():
            jobs.queue.compute(document_object)
        else:
            jobs.queue.request(document_object)

    def onDocumentRestored(self, document_object: Any) -> None:
        """Called by FreeCAD when a file is opened: nothing is computed again."""
        self._add_properties(document_object)
        if document_object.Status in (jobs.WAITING, jobs.RUNNING):
            document_object.Status = jobs.CANCELLED
        door.attach_view(document_object)

    def dumps(self) -> None:
        """What FreeCAD saves of the proxy itself: nothing."""

    def loads(self, state: Any) -> None:
        """What FreeCAD restores of the proxy itself: nothing."""

    # The names of these two up to FreeCAD 0.20.
    __getstate__ = dumps
    __setstate__ = loads


def kind_of(document_object: Any) -> str:
    """The kind of an object of the workbench; "" for any other object."""
    return getattr(getattr(document_object, "Proxy", None), "kind", "")


def assign_results(document_object: Any, values: Mapping[str, Any]) -> None:
    """Set properties by their names, from values that were all made before the first one is set."""
    for name, value in values.items():
        setattr(document_object, name, value)


def vector(values: Sequence[float]) -> Any:
    """Three numbers as FreeCAD's vector."""
    return door.App.Vector(*values)
