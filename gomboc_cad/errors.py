"""The one family of errors that a user can cause.

Each carries one sentence that says what is wrong, where, and what to do; the command line prints it
without a traceback and exits with 2.
"""


class GombocError(Exception):
    """Base of all errors that a user can cause and repair."""


class BodyError(GombocError):
    """A body's parameters do not describe a usable surface."""


class UnverifiedBodyError(GombocError):
    """A refuted or non-convex body was asked for where a verified one is needed."""


class CensusError(GombocError):
    """The equilibria of a body cannot be counted as asked."""


class NotConvexError(CensusError):
    """The smooth census was asked of a body that is not strictly convex."""


class DegenerateEquilibriaError(CensusError):
    """The equilibria are not isolated, as on a sphere or on a body of revolution."""


class SpecError(GombocError):
    """A product spec is missing, malformed, or asks for something impossible."""


class GeometryError(GombocError):
    """The requested geometry cannot be made."""


class OutputError(GombocError):
    """The output cannot be written where it was asked for."""


class InspectionError(GombocError):
    """A file could not be read, or does not hold what is needed."""


class StudyError(GombocError):
    """A tolerance study cannot be run as asked."""
