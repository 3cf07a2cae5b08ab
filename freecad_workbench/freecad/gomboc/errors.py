"""The one kind of error that the workbench raises: a sentence for the user."""

from __future__ import annotations


class GombocCadError(Exception):
    """Something a user can mend; its text is a sentence that says what to do."""


class CancelledError(GombocCadError):
    """The user stopped the computation."""
