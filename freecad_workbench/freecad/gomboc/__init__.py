"""The FreeCAD workbench of gomboc-cad: asks the command line of the package, shows what it answers.

FreeCAD's own Python needs nothing for it but the standard library; see `freecad.gomboc.api` for scripts.
"""

__version__ = "0.1.0"
