"""The sentences of the workbench, in one table that can be translated.

Qt's `lupdate` finds the literals of `QT_TRANSLATE_NOOP`; `tr` gives the user's language when they are said.
"""

from __future__ import annotations

from typing import Any

from . import door

CONTEXT = "gomboc"


def QT_TRANSLATE_NOOP(context: str, text: str) -> str:
    """Mark a literal for translation, and leave it as it is."""
    return text


def tr(text: str, /, **values: Any) -> str:
    """The text in the user's language, with its places filled."""
    translated = door.translate(CONTEXT, text)
    return translated.format(**values) if values else translated


NO_PACKAGE = QT_TRANSLATE_NOOP(
    "gomboc",
    "The package gomboc-cad was not found; install it from the Gomboc menu, or choose a Python that has it.",
)
NO_PROGRAM = QT_TRANSLATE_NOOP(
    "gomboc", "{program} could not be started ({reason}); choose another Python in the Gomboc menu."
)
NOT_IN_PYTHON = QT_TRANSLATE_NOOP(
    "gomboc",
    "{python} does not have a gomboc-cad that runs ({reason}); install it there, or choose another Python.",
)
WRONG_VERSION = QT_TRANSLATE_NOOP(
    "gomboc",
    "gomboc-cad {found} was found in {python}, but this workbench needs a version from {low} to below "
    "{high}; update the package or the workbench.",
)
NO_BASE_PYTHON = QT_TRANSLATE_NOOP(
    "gomboc",
    "No Python {version} or newer with the module venv was found; install one from python.org or your "
    "system's packages (on Debian also python3-venv), or choose a Python that has gomboc-cad.",
)
INSTALL_FAILED = QT_TRANSLATE_NOOP("gomboc", "The installation failed: {reason}")
INSTALL_STOPPED = QT_TRANSLATE_NOOP("gomboc", "The installation was stopped.")
NOT_A_SOURCE = QT_TRANSLATE_NOOP(
    "gomboc", "{source} is neither a wheel (.whl) nor a folder with pyproject.toml; choose one of them."
)

CRASHED = QT_TRANSLATE_NOOP(
    "gomboc", "gomboc-cad ended unexpectedly{after}; nothing was changed. Recompute to try again."
)
AFTER_STAGE = QT_TRANSLATE_NOOP("gomboc", " while {stage}")
NO_ANSWER = QT_TRANSLATE_NOOP(
    "gomboc",
    "gomboc-cad gave an answer that cannot be read ({reason}); check its version in the Gomboc menu.",
)
CANCELLED = QT_TRANSLATE_NOOP("gomboc", "{title} was stopped; recompute to start it again.")
OUT_OF_TIME = QT_TRANSLATE_NOOP("gomboc", "{title} did not end within {seconds:g} s and was stopped.")
QUEUED = QT_TRANSLATE_NOOP("gomboc", "{title} waits until {running} is done.")
WAITED_TOO_LONG = QT_TRANSLATE_NOOP("gomboc", "Not everything was computed within {seconds:g} s.")

NO_FREECAD = QT_TRANSLATE_NOOP("gomboc", "This works inside FreeCAD only.")
NO_SOLID = QT_TRANSLATE_NOOP("gomboc", "{label} has no solid; select a solid part, a body or a closed mesh.")
NO_SUBJECT = QT_TRANSLATE_NOOP(
    "gomboc", "{label} is not a body or product of this workbench; choose one of those."
)
POSE = QT_TRANSLATE_NOOP(
    "gomboc", "down ({down}), height {height:.4g} mm, barrier {barrier}, {probability:.3g} % of drops"
)
ONE_REST = QT_TRANSLATE_NOOP(
    "gomboc", "One stable rest: {estimate:.2f} % of the parts (surely {low:.2f} to {high:.2f} %)."
)
GOOD_PARTS = QT_TRANSLATE_NOOP(
    "gomboc", "Good, with one rest and within the tilt: {estimate:.2f} % (surely {low:.2f} to {high:.2f} %)."
)
NO_POINT = QT_TRANSLATE_NOOP("gomboc", "{label} has no single point; choose a vertex or a point.")
NOT_BUILT = QT_TRANSLATE_NOOP("gomboc", "{label} was not computed yet; recompute it first.")
NO_REPORT = QT_TRANSLATE_NOOP("gomboc", "{label} has no report; rebuild it.")
NO_SUCH_PRODUCT = QT_TRANSLATE_NOOP("gomboc", "There is no product {name}; choose one of {names}.")
NO_SUCH_SETTING = QT_TRANSLATE_NOOP("gomboc", "{owner} has no setting {name}; choose from {names}.")
NO_SUCH_CHOICE = QT_TRANSLATE_NOOP("gomboc", "{name} {value!r} is not known; choose one of {names}.")
BAD_VALUE = QT_TRANSLATE_NOOP("gomboc", "{name} cannot be {value!r}; {wanted} is needed.")
A_NUMBER = QT_TRANSLATE_NOOP("gomboc", "a number")
THREE_NUMBERS = QT_TRANSLATE_NOOP("gomboc", "a point of three numbers in mm")
BAD_OVERRIDE = QT_TRANSLATE_NOOP(
    "gomboc", 'The entry "{text}" of Overrides has to be KEY=VALUE, for example mesh.sag_um=20.'
)
WRONG_PARTS = QT_TRANSLATE_NOOP(
    "gomboc",
    "The parts of {file} do not fit the verdict beside it ({reason}); nothing was changed. Rebuild, and "
    "report this if it stays.",
)
ALREADY_THERE = QT_TRANSLATE_NOOP(
    "gomboc", "{file} is there already; choose another folder, or allow it to be replaced."
)
FOLDER_NOT_WRITABLE = QT_TRANSLATE_NOOP("gomboc", "{folder} cannot be written to ({reason}).")

TIPS = {
    "Product": QT_TRANSLATE_NOOP("gomboc", "Which product it is"),
    "Body": QT_TRANSLATE_NOOP("gomboc", "Body of the catalogue"),
    "Diameter": QT_TRANSLATE_NOOP("gomboc", "Nominal diameter; the overall size differs by a few percent"),
    "Wall": QT_TRANSLATE_NOOP("gomboc", "Thickness of the wall"),
    "Material": QT_TRANSLATE_NOOP("gomboc", "What it is made of"),
    "Process": QT_TRANSLATE_NOOP("gomboc", "How it is made"),
    "Board": QT_TRANSLATE_NOOP("gomboc", "Sensor board in the housing"),
    "Species": QT_TRANSLATE_NOOP("gomboc", "Seed in the pod"),
    "Battery": QT_TRANSLATE_NOOP("gomboc", "Battery inside"),
    "Mark": QT_TRANSLATE_NOOP("gomboc", "Part id and arrow, drilled as small dots; empty for none"),
    "Trim": QT_TRANSLATE_NOOP("gomboc", "What may help the cavity's place to bring the COM to its target"),
    "ComTarget": QT_TRANSLATE_NOOP("gomboc", "Where the COM is to be: best place, centroid, or a point"),
    "ComTargetPoint": QT_TRANSLATE_NOOP("gomboc", "That point in mm, in the frame of the body"),
    "Overrides": QT_TRANSLATE_NOOP(
        "gomboc", "Any other key of the spec, a line of KEY=VALUE each: mesh.sag_um=20"
    ),
    "Part": QT_TRANSLATE_NOOP("gomboc", "The part that is checked"),
    "ComFrom": QT_TRANSLATE_NOOP("gomboc", "COM: the part's own, one that is given, or a point"),
    "Com": QT_TRANSLATE_NOOP("gomboc", "The centre of mass that is given, in the frame of the document"),
    "ComPoint": QT_TRANSLATE_NOOP("gomboc", "The vertex or point that is the centre of mass"),
    "Subject": QT_TRANSLATE_NOOP("gomboc", "The body or product that it is about"),
    "Variants": QT_TRANSLATE_NOOP("gomboc", "How many parts as made are looked at"),
    "Answers": QT_TRANSLATE_NOOP("gomboc", "Look for what to change too; takes most of the time"),
    "Sites": QT_TRANSLATE_NOOP("gomboc", "How many places of the surface are looked at"),
    "Seed": QT_TRANSLATE_NOOP("gomboc", "Of all random samples: the same seed gives the same study"),
    "Status": QT_TRANSLATE_NOOP("gomboc", "How far the computation is"),
    "Verdict": QT_TRANSLATE_NOOP("gomboc", "What the package says of it"),
    "Good": QT_TRANSLATE_NOOP("gomboc", "Whether the verdict is the one that is wanted"),
    "Reasons": QT_TRANSLATE_NOOP("gomboc", "Why"),
    "Message": QT_TRANSLATE_NOOP("gomboc", "Why the last computation failed"),
    "BuiltFrom": QT_TRANSLATE_NOOP("gomboc", "The inputs that the results are of"),
    "SMargin": QT_TRANSLATE_NOOP("gomboc", "How far the COM may be off before a second rest appears, in mm"),
    "Mass": QT_TRANSLATE_NOOP("gomboc", "Mass in g"),
    "CentreOfMass": QT_TRANSLATE_NOOP("gomboc", "Centre of mass, in mm"),
    "RestDirection": QT_TRANSLATE_NOOP("gomboc", "What points down at rest"),
    "Parts": QT_TRANSLATE_NOOP("gomboc", "The parts and datums"),
    "Files": QT_TRANSLATE_NOOP("gomboc", "All files of the computation, as a ZIP"),
    "ComError": QT_TRANSLATE_NOOP("gomboc", "Distance of the centre of mass from its target, in µm"),
    "Stable": QT_TRANSLATE_NOOP("gomboc", "Number of stable poses"),
    "Unstable": QT_TRANSLATE_NOOP("gomboc", "Number of unstable poses"),
    "Saddles": QT_TRANSLATE_NOOP("gomboc", "Number of saddles"),
    "Poses": QT_TRANSLATE_NOOP("gomboc", "The stable poses"),
    "NearestBestSMargin": QT_TRANSLATE_NOOP("gomboc", "S-margin at the best place nearby, in mm"),
    "NearestBestCom": QT_TRANSLATE_NOOP("gomboc", "The best place nearby for the centre of mass, in mm"),
    "BestSMargin": QT_TRANSLATE_NOOP("gomboc", "S-margin at the best place of all, in mm"),
    "BestCom": QT_TRANSLATE_NOOP("gomboc", "The best place of all for the centre of mass, in mm"),
    "ZoneVolume": QT_TRANSLATE_NOOP("gomboc", "Volume of the zone, in mm³"),
    "Radii": QT_TRANSLATE_NOOP("gomboc", "Allowed radius at each face, in mm"),
    "MaxRadius": QT_TRANSLATE_NOOP("gomboc", "Radius of the largest hole or flat that is allowed, in mm"),
    "MaxDirection": QT_TRANSLATE_NOOP("gomboc", "Outward normal there"),
    "YieldMonostable": QT_TRANSLATE_NOOP("gomboc", "Share of the parts that have one stable rest"),
    "YieldTilt": QT_TRANSLATE_NOOP("gomboc", "Share of the parts that are good"),
    "Recommend": QT_TRANSLATE_NOOP("gomboc", "What to change"),
    "Colour": QT_TRANSLATE_NOOP("gomboc", "Colour in the assembly"),
    "Role": QT_TRANSLATE_NOOP("gomboc", "Which part or datum it is"),
    "Densities": QT_TRANSLATE_NOOP("gomboc", "Densities of the materials, in g/cm³"),
}
"""What each property is, by its name."""
