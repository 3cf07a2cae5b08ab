"""Renew the certificates that are shipped with the catalogue: `python -m gomboc_cad.equilibria.certificate`.

The same catalogue gives the same bytes, so a run without a change in the sources changes no file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

import gomboc_cad.body
from gomboc_cad.body.catalogue import INDEX_NAME, catalogue_names, exact_parameters
from gomboc_cad.equilibria.certificate import certify, dumps

SHIPPED = Path(gomboc_cad.body.__file__).parent / "certificates"


def renew(folder: Path, names: Sequence[str] = catalogue_names()) -> None:
    """Write a certificate for every one of these bodies of the catalogue, and their index."""
    index = {}
    for name in names:
        parameters = exact_parameters(name)
        certificate = certify(parameters)
        text = dumps(certificate)
        (folder / f"{name}.json").write_text(text, encoding="utf-8", newline="\n")
        index[name] = {
            "status": certificate.status,
            "parameters": {
                "family": parameters.family,
                "beta": parameters.beta,
                "coefficients": dict(parameters.coefficients),
            },
            "sha256": hashlib.sha256(text.encode()).hexdigest(),
        }
    (folder / INDEX_NAME).write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    renew(SHIPPED)
