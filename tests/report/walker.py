"""Walks a report page and looks every number of it up in the JSON files beside it."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, NamedTuple

VOID = {"meta", "input", "br", "hr", "img", "link", "path", "use", "rect", "circle", "stop", "image"}
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


class Text(NamedTuple):
    """A text node that is shown, with the attributes of the elements around it, the innermost first."""

    text: str
    around: tuple[dict[str, str | None], ...]


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[tuple[str, dict[str, str | None]]] = []
        self.found: list[Text] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = dict(attrs)
        self.links += [value for key, value in attrs if key in {"src", "href", "action", "data"} and value]
        if tag not in VOID:
            self.open.append((tag, attributes))

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            while self.open and self.open.pop()[0] != tag:
                pass

    def handle_data(self, data: str) -> None:
        if data.strip() and not {"style", "script"} & {tag for tag, _ in self.open}:
            self.found.append(Text(data, tuple(attributes for _, attributes in reversed(self.open))))


def read_page(page: str) -> tuple[list[Text], list[str]]:
    """All texts that a page shows, and everything it links to."""
    reader = _Reader()
    reader.feed(page)
    reader.close()
    return reader.found, reader.links


def untraced(folder: Path) -> list[str]:
    """Texts of a folder's page with a number that does not stand where the page says, or says nowhere."""
    texts, _ = read_page((folder / "report.html").read_text(encoding="utf-8"))
    documents: dict[str, Any] = {}
    return [
        each.text for each in texts if re.search(r"\d", each.text) and not _traced(each, folder, documents)
    ]


def _traced(text: Text, folder: Path, documents: dict[str, Any]) -> bool:
    for attributes in text.around:
        if "data-json-key" in attributes:
            return _pointer(attributes["data-json-key"])[1][-1] == text.text
        if "data-json" in attributes:
            name, keys = _pointer(attributes["data-json"])
            if name not in documents:
                documents[name] = json.loads((folder / name).read_text(encoding="utf-8"))
            value = documents[name]
            for key in keys:
                value = value[int(key)] if isinstance(value, list) else value[key]
            if isinstance(value, str):
                return value == text.text
            return _agrees(text.text, value * float(attributes.get("data-scale") or 1.0))
    return False


def _pointer(address: str | None) -> tuple[str, list[str]]:
    assert address is not None
    name, _, pointer = address.partition("#")
    return name, [part.replace("~1", "/").replace("~0", "~") for part in pointer.split("/")[1:]]


def _agrees(shown: str, value: float) -> bool:
    """Whether a written number is the value, to half a unit of its last place."""
    mantissa, _, power = shown.replace("−", "-").partition("·10")
    exponent = int(power.translate(SUPERSCRIPTS)) if power else 0
    decimals = len(mantissa.partition(".")[2])
    half_a_unit = 0.5 * 10.0 ** (exponent - decimals)
    return abs(float(mantissa) * 10.0**exponent - value) <= half_a_unit * (1.0 + 1e-9) + 1e-12 * abs(value)
