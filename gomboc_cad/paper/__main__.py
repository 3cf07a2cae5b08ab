"""Write the page of the documentation again: `python -m gomboc_cad.paper docs`."""

from __future__ import annotations

import sys
from pathlib import Path

from gomboc_cad.paper.page import page
from gomboc_cad.paper.registry import TABLES, reproduce
from gomboc_cad.paper.write import PAGE_NAME, write_figures
from gomboc_cad.solid.output import write_bytes


def main(folder: Path) -> None:
    """Write `paper.md` into a folder and its figures into `images` below it."""

    def tell(stage: str) -> None:
        print(stage, file=sys.stderr, flush=True)

    write_bytes(folder / PAGE_NAME, page(reproduce(progress=tell)).encode())
    write_figures(folder / "images", TABLES, tell)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs"))
