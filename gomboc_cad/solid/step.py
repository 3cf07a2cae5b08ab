"""STEP files of named, coloured parts in place, written to bytes and read back."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import lru_cache
from pathlib import Path

from build123d import Shape
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_PrinterOStream
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Reader, STEPCAFControl_Writer
from OCP.STEPConstruct import STEPConstruct, STEPConstruct_Styles
from OCP.STEPControl import STEPControl_StepModelType
from OCP.StepRepr import StepRepr_HArray1OfRepresentationItem, StepRepr_NextAssemblyUsageOccurrence
from OCP.StepVisual import StepVisual_MechanicalDesignGeometricPresentationRepresentation
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from gomboc_cad.errors import InspectionError, OutputError

Color = tuple[float, float, float]

_MM_IN_M = 1e-3
_NOT_TEXT = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f]")


@dataclass(frozen=True)
class NamedSolid:
    """A B-rep part of a STEP file.

    Attributes:
        name: Name of the part, unique in its file.
        solid: The solid, in place.
        color: RGB in 0…1, or None.
    """

    name: str
    solid: Shape
    color: Color | None = None


def step_bytes(parts: Sequence[NamedSolid], name: str, date: datetime) -> bytes:
    """Translate one part, or an assembly of several parts in place, to a STEP file (AP214) in millimetres.

    Args:
        parts: The parts.
        name: Name of the assembly, and the title in the file's header.
        date: Date in the file's header.

    Raises:
        OutputError: If OCCT cannot translate the parts.
    """
    _prepare()
    own = [replace(part, solid=_own_geometry(part.solid)) for part in parts]
    writer = STEPCAFControl_Writer()
    # The writer's own colours come in an order that differs from run to run.
    writer.SetColorMode(False)
    if not writer.Transfer(_document(own, name), STEPControl_StepModelType.STEPControl_AsIs):
        raise OutputError(f"OCCT could not translate {name!r} to STEP; please report the model.")
    for part in own:
        _add_color(writer, part)
    _number_occurrences(writer)
    header = APIHeaderSection_MakeHeader(writer.Writer().Model())
    header.SetName(_ascii(name))
    header.SetTimeStamp(_ascii(date.strftime("%Y-%m-%dT%H:%M:%S")))
    header.SetOriginatingSystem(_ascii("gomboc-cad"))
    stream = io.BytesIO()
    if writer.WriteStream(stream) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise OutputError(f"OCCT could not write {name!r} as STEP; please report the model.")
    return stream.getvalue()


def read_step(path: Path) -> tuple[NamedSolid, ...]:
    """Read the parts of a STEP file with their names, in place.

    Raises:
        InspectionError: If the file is not a whole STEP file, or OCCT cannot read it.
    """
    _prepare()
    _check_text(path.name, path.read_bytes())
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    document = _empty_document()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InspectionError(f"{path.name} cannot be read as STEP.")
    model = reader.Reader().StepModel()
    # OCCT may crash when it goes on to translate entities that it could not read.
    faulty = sum(model.IsErrorEntity(number) for number in range(1, model.NbEntities() + 1))
    if faulty or not reader.Transfer(document):
        raise InspectionError(f"{path.name} is damaged: OCCT cannot read {faulty or 'any'} of its entities.")
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    roots = TDF_LabelSequence()
    shapes.GetFreeShapes(roots)
    return tuple(part for root in roots for part in _parts(root, TopLoc_Location()))


def _check_text(name: str, data: bytes) -> None:
    """Refuse what is not a whole STEP file."""
    text = data.strip()
    if not text.startswith(b"ISO-10303-21;") or not text.endswith(b"END-ISO-10303-21;"):
        raise InspectionError(f"{name} is not a whole STEP file: its first or last line is missing.")
    if _NOT_TEXT.search(data):
        raise InspectionError(f"{name} is damaged: it holds bytes that are no text.")


def _parts(label: TDF_Label, place: TopLoc_Location) -> list[NamedSolid]:
    """Parts under a label of a document, assemblies taken apart."""
    place = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
    target = TDF_Label()
    if not XCAFDoc_ShapeTool.GetReferredShape_s(label, target):
        target = label
    if XCAFDoc_ShapeTool.IsAssembly_s(target):
        components = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetComponents_s(target, components)
        return [part for component in components for part in _parts(component, place)]
    shape = XCAFDoc_ShapeTool.GetShape_s(target)
    return [NamedSolid(_name(target), Shape.cast(shape if _stays(place) else shape.Moved(place)))]


def _stays(place: TopLoc_Location) -> bool:
    """Whether a location, which an assembly gives to every part, moves nothing."""
    matrix = place.Transformation()
    rows = [[matrix.Value(i, j) for j in (1, 2, 3, 4)] for i in (1, 2, 3)]
    return rows == [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]


def _name(label: TDF_Label) -> str:
    name = TDataStd_Name()
    return name.Get().ToExtString() if label.FindAttribute(TDataStd_Name.GetID_s(), name) else ""


@lru_cache(maxsize=1)
def _prepare() -> None:
    """Set OCCT's process-wide options for STEP once, and keep it from talking on the terminal."""
    Message.DefaultMessenger_s().RemovePrinters(Message_PrinterOStream.get_type_descriptor_s())
    STEPCAFControl_Controller.Init_s()
    Interface_Static.SetCVal_s("write.step.schema", "AP214IS")
    Interface_Static.SetCVal_s("write.step.unit", "MM")


def _document(parts: Sequence[NamedSolid], name: str) -> TDocStd_Document:
    """Put named parts into a document, under an assembly where there are several."""
    document = _empty_document()
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    labels = []
    for part in parts:
        labels.append(shapes.NewShape())
        shapes.SetShape(labels[-1], part.solid.wrapped)
        _set_name(labels[-1], part.name)
    if len(parts) > 1:
        assembly = shapes.NewShape()
        _set_name(assembly, name)
        for part, label in zip(parts, labels, strict=True):
            _set_name(shapes.AddComponent(assembly, label, TopLoc_Location()), part.name)
        shapes.UpdateAssemblies()
    return document


def _add_color(writer: STEPCAFControl_Writer, part: NamedSolid) -> None:
    """Give a part that was transferred already its colour."""
    if part.color is None:
        return
    styles = STEPConstruct_Styles(writer.Writer().WS())
    item = STEPConstruct.FindEntity_s(styles.FinderProcess(), part.solid.wrapped)
    color = styles.EncodeColor_s(Quantity_Color(*part.color, Quantity_TypeOfColor.Quantity_TOC_sRGB))
    styled = styles.AddStyle(item, styles.GetColorPSA(item, color), None)
    presentation = StepVisual_MechanicalDesignGeometricPresentationRepresentation()
    items = StepRepr_HArray1OfRepresentationItem(1, 1, styled)
    presentation.Init(_ascii(""), items, styles.FindContext(part.solid.wrapped))
    writer.Writer().Model().AddWithRefs(presentation)


def _number_occurrences(writer: STEPCAFControl_Writer) -> None:
    """Number the parts of the assembly from 1; OCCT goes on counting from file to file."""
    model = writer.Writer().Model()
    entities = (model.Value(index) for index in range(1, model.NbEntities() + 1))
    occurrences = (e for e in entities if isinstance(e, StepRepr_NextAssemblyUsageOccurrence))
    for number, occurrence in enumerate(occurrences, start=1):
        occurrence.SetId(_ascii(str(number)))


def _own_geometry(solid: Shape) -> Shape:
    """Copy a solid with its location applied, so that parts of equal shape do not become one product."""
    place = solid.wrapped.Location().Transformation()
    return Shape.cast(BRepBuilderAPI_Transform(solid.wrapped.Located(TopLoc_Location()), place, True).Shape())


def _set_name(label: TDF_Label, name: str) -> None:
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))


def _ascii(text: str) -> TCollection_HAsciiString:
    return TCollection_HAsciiString(text.encode("ascii", "replace").decode())


def _empty_document() -> TDocStd_Document:
    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    XCAFApp_Application.GetApplication_s().NewDocument(TCollection_ExtendedString("MDTV-XCAF"), document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, _MM_IN_M)
    return document
