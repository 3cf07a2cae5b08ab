"""The workbench for scripts and macros, with and without windows.

    from freecad.gomboc import api
    housing = api.create_product(doc, "imu-housing", diameter_mm=60)
    print(housing.Verdict, housing.SMargin, housing.Mass)
    print(api.check(doc.Box)["stable"])

With windows the `create_…` functions return at once and the object is computed beside FreeCAD (`api.wait`);
without windows they return when it is done. Lengths in mm, masses in g.
"""

from __future__ import annotations

import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Sequence, Tuple

from . import cli, door, environment, jobs, process, texts
from .errors import CancelledError, GombocCadError
from .lists import lists
from .objects import check as checks
from .objects import files, properties
from .objects.body import SETTINGS as BODY_SETTINGS
from .objects.body import Body
from .objects.check import Check
from .objects.computed import kind_of
from .objects.maps import DRILL_SITES, DrillMap, Study, Zone, is_subject
from .objects.product import Product, set_target

__all__ = [
    "CancelledError",
    "GombocCadError",
    "check",
    "create_body",
    "create_check",
    "create_drill_map",
    "create_product",
    "create_study",
    "create_zone",
    "export",
    "place_com",
    "rebuild",
    "report_page",
    "wait",
]

Point = Tuple[float, float, float]

_NAMES = {"imu-housing": "ImuHousing", "seed-pod": "SeedPod", "buoy": "Buoy"}


def create_product(doc: Any, name: str, **settings: Any) -> Any:
    """Add a product to a document.

    Args:
        doc: A FreeCAD document.
        name: `imu-housing`, `seed-pod` or `buoy`.
        settings: Any of body, diameter_mm, wall_mm, material, process, trim, mark, and board, species or
            battery where the product has one; com_target (`best`, `centroid` or a point in mm); overrides, a
            list of `KEY=VALUE` for other keys of the spec.

    Returns:
        The document object.

    Raises:
        GombocCadError: If a setting is not known or impossible, or (without windows) the build failed; the
            document is as it was.
    """
    offered = lists()
    if name not in offered.products:
        names = ", ".join(offered.products)
        raise GombocCadError(texts.tr(texts.NO_SUCH_PRODUCT, name=name, names=names))
    with _created(doc, "Part::FeaturePython", _NAMES.get(name, "Product")) as made:
        proxy = Product(made)
        proxy.set_up(made, name, offered)
        target, overrides = settings.pop("com_target", None), settings.pop("overrides", ())
        _assign(made, name, proxy.settings(made), settings, ("com_target", "overrides"))
        if target is not None:
            set_target(made, target)
        made.Overrides = [cli.check_override(line) for line in overrides]
    return made


def create_body(doc: Any, name: str = "primary", **settings: Any) -> Any:
    """Add a bare body of the catalogue to a document.

    Args:
        doc: A FreeCAD document.
        name: Of the catalogue.
        settings: Any of diameter_mm, material.

    Returns:
        The document object.

    Raises:
        GombocCadError: As `create_product`.
    """
    offered = lists()
    with _created(doc, "Part::FeaturePython", "Body") as made:
        Body(made).set_up(made, offered)
        _assign(made, name, BODY_SETTINGS, {"body": name, **settings})
        made.Label = name
    return made


def create_check(
    doc: Any, part: Any, com_mm: Sequence[float] | None = None, point: tuple[Any, str] | None = None
) -> Any:
    """Add a check of the resting poses of a part, which is repeated when the part changes.

    Args:
        doc: A FreeCAD document.
        part: A solid, a body of Part Design, a group of parts, a mesh, or one of our objects.
        com_mm: Centre of mass in the document's frame; by default that of the homogeneous part, and of a
            product its own.
        point: Instead of that, an object and the name of its vertex (`""` if it has one only).

    Returns:
        The document object.

    Raises:
        GombocCadError: If the part has no solid, or (without windows) the check failed.
    """
    checks.digest(part)
    with _created(doc, "Part::FeaturePython", "Check") as made:
        Check(made)
        made.Part, made.Label = part, f"{part.Label} check"
        if point is not None:
            made.ComPoint, made.ComFrom = (point[0], [point[1]]), checks.POINT
            checks.point_of(made.ComPoint)
        elif com_mm is not None:
            made.Com, made.ComFrom = properties.point("com_mm", com_mm), checks.GIVEN
    return made


def create_zone(doc: Any, subject: Any) -> Any:
    """Add the loading zone of a body or product: where its centre of mass may be.

    Raises:
        GombocCadError: If it is neither, or (without windows) the computation failed.
    """
    return _create_about(doc, subject, Zone, "Mesh::FeaturePython", "LoadingZone")


def create_drill_map(doc: Any, subject: Any, sites: int = DRILL_SITES) -> Any:
    """Add the drill map of a body or product: how large a hole or flat may be at each place.

    Args:
        doc: A FreeCAD document.
        subject: A body or product of the workbench.
        sites: How many places of the surface are looked at.

    Raises:
        GombocCadError: If it is neither, or (without windows) the computation failed.
    """
    return _create_about(doc, subject, DrillMap, "Part::FeaturePython", "DrillMap", Sites=sites)


def create_study(
    doc: Any, subject: Any, process: str = "", variants: int = 2048, seed: int = 0, answers: bool = True
) -> Any:
    """Add a tolerance study of a body or product: how likely a part as made rights itself.

    Args:
        doc: A FreeCAD document.
        subject: A body or product of the workbench.
        process: How it is made; as designed if not given, and needed for a bare body.
        variants: How many parts as made are looked at.
        seed: Of all random samples: the same seed gives the same study.
        answers: Look for what to change too, which takes most of the time.

    Returns:
        The document object.

    Raises:
        GombocCadError: If it is neither, the process is not known, or (without windows) the study failed.
    """
    _require_subject(subject)
    processes = lists().choices["processes"]
    if process and process not in processes:
        names = ", ".join(processes)
        raise GombocCadError(texts.tr(texts.NO_SUCH_CHOICE, name="process", value=process, names=names))
    with _created(doc, "App::FeaturePython", "ToleranceStudy") as made:
        Study(made).set_up(made, subject, processes)
        made.Label = f"{subject.Label} tolerances"
        made.Variants, made.Seed, made.Answers = variants, seed, answers
        if process:
            made.Process = process
    return made


def check(obj: Any, com_mm: Sequence[float] | None = None) -> dict[str, Any]:
    """Count the resting poses of any part, now; nothing is added to the document.

    Args:
        obj: A solid, a body of Part Design, a group of parts, a mesh, or one of our objects.
        com_mm: Centre of mass in the document's frame; by default that of the homogeneous part, and of a
            product its own.

    Returns:
        The keys of `gomboc-cad check`.

    Raises:
        GombocCadError: If the part has no solid, or cannot be checked.
    """
    com = checks.own_com_mm(obj) if com_mm is None else properties.point("com_mm", com_mm)
    folder = Path(tempfile.mkdtemp(prefix="gomboc-"))
    try:
        arguments = cli.check(checks.write_part(obj, folder), com)
        return process.run(environment.ready_python(), arguments).document()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def place_com(product: Any, target: str | Sequence[float] = "best", trim: str | None = None) -> None:
    """Say where the centre of mass of a product is to be, and rebuild it.

    Args:
        product: A product of the workbench.
        target: `best`, `centroid`, or a point in mm in the body's frame.
        trim: What may help the cavity's place: one of the choices of the property Trim.

    Raises:
        GombocCadError: If it is no product, or a value is not known.
    """
    if kind_of(product) != "product":
        raise GombocCadError(texts.tr(texts.NO_SUBJECT, label=product.Label))
    if trim is not None:
        _assign(product, product.Label, product.Proxy.settings(product), {"trim": trim})
    set_target(product, target)
    product.Document.recompute()


def rebuild(obj: Any) -> None:
    """Compute an object again, even if nothing changed."""
    obj.BuiltFrom = ""
    obj.touch()
    obj.Document.recompute()


def export(obj: Any, folder: str | Path, overwrite: bool = False) -> list[str]:
    """Write the files of a product, body or study: STEP, STL, 3MF, verdict, report.

    They are those of the last computation, kept in the document.

    Returns:
        Their paths.

    Raises:
        GombocCadError: If there are none, or one cannot be written.
    """
    return [str(path) for path in files.unpack(obj, Path(folder), overwrite)]


def report_page(obj: Any) -> str:
    """The report of a product or study, as a file that a browser can open.

    Raises:
        GombocCadError: If it has none.
    """
    folder = Path(tempfile.gettempdir()) / "gomboc-reports" / obj.Document.Uid / obj.Name
    paths = files.unpack(obj, folder, overwrite=True)
    pages = [path for path in paths if path.name == files.REPORT]
    if not pages:
        raise GombocCadError(texts.tr(texts.NO_REPORT, label=obj.Label))
    return str(pages[0])


def wait(obj: Any = None, timeout_s: float | None = None) -> None:
    """Wait until an object, or all, is computed; windows stay alive meanwhile.

    Raises:
        GombocCadError: If time ran out.
    """
    jobs.queue.wait(obj, timeout_s)


@contextmanager
def _created(doc: Any, kind: str, name: str) -> Iterator[Any]:
    """Add an object, let it be set up, and compute it; remove it if that fails."""
    made = doc.addObject(kind, name)
    try:
        yield made
        door.attach_view(made)
        doc.recompute()
        if made.Status in (jobs.FAILED, jobs.CANCELLED):
            raise GombocCadError(made.Message)
    except BaseException:
        group = getattr(made, "Parts", None)
        doc.removeObject(made.Name)
        if group is not None:
            group.removeObjectsFromDocument()
            doc.removeObject(group.Name)
        raise


def _create_about(doc: Any, subject: Any, proxy: Any, kind: str, name: str, **settings: Any) -> Any:
    _require_subject(subject)
    with _created(doc, kind, name) as made:
        proxy(made)
        made.Subject, made.Label = subject, f"{subject.Label} {name}"
        for setting, value in settings.items():
            setattr(made, setting, value)
    return made


def _require_subject(subject: Any) -> None:
    if not is_subject(subject):
        raise GombocCadError(texts.tr(texts.NO_SUBJECT, label=getattr(subject, "Label", subject)))


def _assign(
    made: Any,
    owner: str,
    known: Sequence[properties.Setting],
    settings: dict[str, Any],
    others: Sequence[str] = (),
) -> None:
    by_argument = {setting.argument: setting for setting in known}
    for argument, value in settings.items():
        if argument not in by_argument:
            names = ", ".join([*by_argument, *others])
            raise GombocCadError(texts.tr(texts.NO_SUCH_SETTING, owner=owner, name=argument, names=names))
        properties.assign(made, by_argument[argument], value)
