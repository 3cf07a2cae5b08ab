"""How long work tells what it is doing: a callback with the name of each stage as it begins."""

from collections.abc import Callable

Progress = Callable[[str], None]


def silent(stage: str) -> None:
    """Tell nobody."""
