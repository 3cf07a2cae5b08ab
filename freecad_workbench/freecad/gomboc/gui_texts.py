"""What menus, buttons, panels and dialogs say; to be translated like `texts`."""

from __future__ import annotations

from .texts import QT_TRANSLATE_NOOP

WORKBENCH = QT_TRANSLATE_NOOP("gomboc", "Gomboc CAD")
WORKBENCH_TIP = QT_TRANSLATE_NOOP(
    "gomboc", "Self-righting bodies and products, and the resting positions of any part"
)
MENU = QT_TRANSLATE_NOOP("gomboc", "&Gomboc")
TOOLBAR_CREATE = QT_TRANSLATE_NOOP("gomboc", "Gomboc products")
TOOLBAR_JUDGE = QT_TRANSLATE_NOOP("gomboc", "Gomboc judgement")
TOOLBAR_OUTPUT = QT_TRANSLATE_NOOP("gomboc", "Gomboc output")

BODY = QT_TRANSLATE_NOOP("gomboc", "New body")
BODY_TIP = QT_TRANSLATE_NOOP("gomboc", "A bare self-righting body of the catalogue as one solid")
HOUSING = QT_TRANSLATE_NOOP("gomboc", "New IMU housing")
HOUSING_TIP = QT_TRANSLATE_NOOP("gomboc", "A self-righting calibration housing around a sensor board")
POD = QT_TRANSLATE_NOOP("gomboc", "New seed pod")
POD_TIP = QT_TRANSLATE_NOOP("gomboc", "A small self-righting body with a seed in it, root down")
BUOY = QT_TRANSLATE_NOOP("gomboc", "New buoy")
BUOY_TIP = QT_TRANSLATE_NOOP("gomboc", "A self-righting buoy with ballast, battery, O-ring and mooring eye")
CHECK = QT_TRANSLATE_NOOP("gomboc", "Check equilibria")
CHECK_TIP = QT_TRANSLATE_NOOP(
    "gomboc",
    "Count the poses in which the selected part, body or mesh rests on a table.\n"
    "It is taken as homogeneous, unless a vertex or point is selected too: that is its centre of mass then",
)
PLACE_COM = QT_TRANSLATE_NOOP("gomboc", "Place centre of mass")
PLACE_COM_TIP = QT_TRANSLATE_NOOP(
    "gomboc",
    "A product: choose where its centre of mass goes and how, and rebuild.\n"
    "Any other part: try a place for its centre of mass and see how the part would rest",
)
ZONE = QT_TRANSLATE_NOOP("gomboc", "Loading zone")
ZONE_TIP = QT_TRANSLATE_NOOP(
    "gomboc", "Show where the centre of mass of the selected body or product may be, as a translucent object"
)
DRILL_MAP = QT_TRANSLATE_NOOP("gomboc", "Drill map")
DRILL_MAP_TIP = QT_TRANSLATE_NOOP(
    "gomboc", "Colour the selected body or product by the largest hole or flat allowed at each place"
)
STUDY = QT_TRANSLATE_NOOP("gomboc", "Tolerance study")
STUDY_TIP = QT_TRANSLATE_NOOP(
    "gomboc", "Tell before machining how likely a made part of the selected product rights itself"
)
REPORT = QT_TRANSLATE_NOOP("gomboc", "Open report")
REPORT_TIP = QT_TRANSLATE_NOOP("gomboc", "Open the report of the selected product in the web browser")
EXPORT = QT_TRANSLATE_NOOP("gomboc", "Export…")
EXPORT_TIP = QT_TRANSLATE_NOOP(
    "gomboc",
    "Write the checked files of the selected object (STEP, STL, 3MF, bill of materials) into a folder",
)
STOP_RUN = QT_TRANSLATE_NOOP("gomboc", "Stop")
STOP_RUN_TIP = QT_TRANSLATE_NOOP("gomboc", "Stop what is being computed; the objects keep what they had")
SETUP = QT_TRANSLATE_NOOP("gomboc", "Set up…")
SETUP_TIP = QT_TRANSLATE_NOOP("gomboc", "Install gomboc-cad, or choose the Python that has it")

STOP = QT_TRANSLATE_NOOP("gomboc", "Stop")
CLOSE = QT_TRANSLATE_NOOP("gomboc", "Close")
BROWSE = QT_TRANSLATE_NOOP("gomboc", "Browse…")

SETUP_TITLE = QT_TRANSLATE_NOOP("gomboc", "Set up gomboc-cad")
SETUP_INTRO = QT_TRANSLATE_NOOP(
    "gomboc",
    "The buttons of this workbench run the program gomboc-cad in a Python beside FreeCAD, so that neither "
    "disturbs the other. Install it here, or choose a Python that has it already.",
)
SETUP_INSTALL_BOX = QT_TRANSLATE_NOOP("gomboc", "Install gomboc-cad")
SETUP_WHERE = QT_TRANSLATE_NOOP(
    "gomboc", "Into the folder {folder}, about 1 GB with all that it needs; nothing else is changed."
)
SETUP_FROM_INDEX = QT_TRANSLATE_NOOP("gomboc", "From the Python package index")
SETUP_FROM_WHEEL = QT_TRANSLATE_NOOP("gomboc", "From a wheel (.whl)")
SETUP_FROM_FOLDER = QT_TRANSLATE_NOOP("gomboc", "From a folder with the source")
SETUP_INSTALL = QT_TRANSLATE_NOOP("gomboc", "Install")
SETUP_EXISTING_BOX = QT_TRANSLATE_NOOP("gomboc", "Or use a Python that has gomboc-cad")
SETUP_PYTHON = QT_TRANSLATE_NOOP("gomboc", "Python executable")
SETUP_USE = QT_TRANSLATE_NOOP("gomboc", "Use this one")
SETUP_OUTPUT = QT_TRANSLATE_NOOP("gomboc", "What the installation prints appears here.")
SETUP_NO_SOURCE = QT_TRANSLATE_NOOP("gomboc", "Choose the wheel or the folder to install from.")
SETUP_INSTALLING = QT_TRANSLATE_NOOP("gomboc", "Installing; this takes a few minutes.")
SETUP_READY = QT_TRANSLATE_NOOP("gomboc", "Ready: gomboc-cad {version} in {python}")

OTHER_TASK = QT_TRANSLATE_NOOP("gomboc", "Another task is open in FreeCAD; finish it first.")
PROCESS = QT_TRANSLATE_NOOP("gomboc", "Process")
OWN_PROCESS = QT_TRANSLATE_NOOP("gomboc", "as the product has it")
VARIANTS = QT_TRANSLATE_NOOP("gomboc", "Variants")
SEED = QT_TRANSLATE_NOOP("gomboc", "Seed of all samples")
STUDY_OF = QT_TRANSLATE_NOOP("gomboc", "Tolerance study of {label}")
PLACE_OF = QT_TRANSLATE_NOOP("gomboc", "Centre of mass of {label}")
TARGET = QT_TRANSLATE_NOOP("gomboc", "Target")
TARGET_TIP = QT_TRANSLATE_NOOP(
    "gomboc",
    "best: forgives the largest error; centroid: as if the body were homogeneous; point: given below",
)
TARGET_BEST = QT_TRANSLATE_NOOP("gomboc", "best")
TARGET_CENTROID = QT_TRANSLATE_NOOP("gomboc", "centroid")
TARGET_POINT = QT_TRANSLATE_NOOP("gomboc", "a point")
TRIM = QT_TRANSLATE_NOOP("gomboc", "Trim")
NO_CENTROID = QT_TRANSLATE_NOOP("gomboc", "The part will be checked about this point.")
WAY = QT_TRANSLATE_NOOP(
    "gomboc",
    "A homogeneous part has its centre of mass at ({x:.4g}, {y:.4g}, {z:.4g}) mm. The point is "
    "{shift:.4g} mm from there; the part will be checked about it.",
)
EXPORT_TITLE = QT_TRANSLATE_NOOP("gomboc", "Folder for the files of {label}")
EXPORTED = QT_TRANSLATE_NOOP("gomboc", "The files are in {folder}.")
OVERRIDES = QT_TRANSLATE_NOOP("gomboc", "Other keys")
OVERRIDES_TIP = QT_TRANSLATE_NOOP(
    "gomboc",
    "Any other key of the product's template, a line of KEY=VALUE each; they win over the fields above",
)

STARTING = QT_TRANSLATE_NOOP("gomboc", "starting")
STAGE = QT_TRANSLATE_NOOP("gomboc", "stage {number}")
WAITING = QT_TRANSLATE_NOOP("gomboc", "{count} more waiting")
QUEUED = QT_TRANSLATE_NOOP("gomboc", "Waits for what runs now.")
AGAIN = QT_TRANSLATE_NOOP("gomboc", "Try again")
SCALE = QT_TRANSLATE_NOOP("gomboc", "Largest radius of a hole or flat, mm")
GONE = QT_TRANSLATE_NOOP("gomboc", "The object was deleted.")
SHOW_RESULT = QT_TRANSLATE_NOOP("gomboc", "Show result")
VIEW_AT_REST = QT_TRANSLATE_NOOP("gomboc", "View at rest")

HEADING_PASS = QT_TRANSLATE_NOOP("gomboc", "PASS: rights itself to one pose")
HEADING_FAIL = QT_TRANSLATE_NOOP("gomboc", "FAIL")
HEADING_MONOSTABLE = QT_TRANSLATE_NOOP("gomboc", "One stable pose")
HEADING_MULTISTABLE = QT_TRANSLATE_NOOP("gomboc", "Several stable poses")
HEADING_UNDECIDED = QT_TRANSLATE_NOOP("gomboc", "Undecided")
HEADING_RUNNING = QT_TRANSLATE_NOOP("gomboc", "Being computed")
HEADING_STOPPED = QT_TRANSLATE_NOOP("gomboc", "Stopped; what is shown was there before")
HEADING_FAILED = QT_TRANSLATE_NOOP("gomboc", "Failed; what is shown was there before")
HEADING_DONE = QT_TRANSLATE_NOOP("gomboc", "Done")
HEADING_NEW = QT_TRANSLATE_NOOP("gomboc", "Not computed yet")

FACTS = (
    ("Mass", QT_TRANSLATE_NOOP("gomboc", "Mass"), "g"),
    ("SMargin", QT_TRANSLATE_NOOP("gomboc", "S-margin"), "mm"),
    ("CentreOfMass", QT_TRANSLATE_NOOP("gomboc", "Centre of mass"), "mm"),
    ("ComError", QT_TRANSLATE_NOOP("gomboc", "Off its target"), "µm"),
    ("RestDirection", QT_TRANSLATE_NOOP("gomboc", "Down at rest"), ""),
    ("Stable", QT_TRANSLATE_NOOP("gomboc", "Stable poses"), ""),
    ("NearestBestCom", QT_TRANSLATE_NOOP("gomboc", "Best place nearby"), "mm"),
    ("NearestBestSMargin", QT_TRANSLATE_NOOP("gomboc", "S-margin there"), "mm"),
    ("ZoneVolume", QT_TRANSLATE_NOOP("gomboc", "Volume of the zone"), "mm³"),
    ("MaxRadius", QT_TRANSLATE_NOOP("gomboc", "Largest hole, radius"), "mm"),
    ("MaxDirection", QT_TRANSLATE_NOOP("gomboc", "where its normal is"), ""),
    ("YieldMonostable", QT_TRANSLATE_NOOP("gomboc", "Parts with one rest"), "%"),
    ("YieldTilt", QT_TRANSLATE_NOOP("gomboc", "Parts within the tilt allowed"), "%"),
)
"""Properties, what they are called in a panel, and their units."""
