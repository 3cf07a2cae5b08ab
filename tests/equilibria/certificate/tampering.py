"""Certificates changed by someone who signs them again, as the format says how to."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Any

from gomboc_cad.equilibria.certificate import Certificate, Verification, dumps, loads, verify

Document = dict[str, Any]


def signed(document: Document) -> str:
    """The document with a digest that fits."""
    content = {key: value for key, value in document.items() if key != "sha256"}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return json.dumps({**content, "sha256": hashlib.sha256(canonical.encode()).hexdigest()})


def verify_changed(certificate: Certificate, change: Callable[[Document], object]) -> Verification:
    """Change a certificate's document, sign it again and check it."""
    document = json.loads(dumps(certificate))
    change(document)
    return verify(loads(signed(document)))
