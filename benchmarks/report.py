"""Measure the report: time, memory and size, written with a build and again from the JSON alone.

`python benchmarks/report.py` prints the table; `benchmarks/run.py` puts it into docs/benchmarks.md.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

PRODUCTS = ("imu-housing", "buoy")
LIMIT_S, LIMIT_GIB, LIMIT_MB = 10.0, 1.0, 8.0
_TO_GIB = (1 << 30) if sys.platform == "darwin" else (1 << 20)


@dataclass(frozen=True)
class Written:
    """A report that was written.

    Attributes:
        with_build_s: Last stage of a build: what only the design can tell, figures and page.
        again_s: `gomboc-cad report`, with the start of the program.
        peak_gib: Memory of that.
        page_mb: Size of the page.
    """

    with_build_s: float
    again_s: float
    peak_gib: float
    page_mb: float


def measure_build(product: str, folder: Path) -> float:
    """Seconds from the beginning of the last stage of a build to its end."""
    from gomboc_cad.products.build import build_product

    began: list[tuple[str, float]] = []
    build_product(product, folder, progress=lambda stage: began.append((stage, time.perf_counter())))
    stage, start = began[-1]
    if stage != "writing the report":
        raise RuntimeError(f"the last stage of a build is {stage!r}")
    return time.perf_counter() - start


def measure_again(folder: Path) -> tuple[float, float]:
    """Wall time in s and peak memory in GiB of writing a report from the JSON alone, imports included."""
    start = time.perf_counter()
    from gomboc_cad.report.write import write_report

    write_report(folder)
    return time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _TO_GIB


def measure(product: str) -> Written:
    """Build a product and write its report again, each in a new process."""
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / "out"
        with_build_s = _in_a_new_process("build", product, str(folder))
        again_s, peak_gib = _in_a_new_process("again", str(folder))
        page_mb = 1e-6 * (folder / "report.html").stat().st_size
    return Written(with_build_s, again_s, peak_gib, page_mb)


def _in_a_new_process(*task: str) -> Any:
    done = subprocess.run([sys.executable, __file__, *task], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def table() -> tuple[str, bool]:
    """The Markdown table, and whether all limits are kept."""
    lines = [
        f"| report of | with the build, at most {LIMIT_S:g} s | again from the JSON, at most {LIMIT_S:g} s "
        f"| peak memory, at most {LIMIT_GIB:g} GiB | page, less than {LIMIT_MB:g} MB |",
        "|---|---|---|---|---|",
    ]
    within = True
    for product in PRODUCTS:
        found = measure(product)
        print(f"report of {product}: {asdict(found)}", file=sys.stderr, flush=True)
        within &= max(found.with_build_s, found.again_s) <= LIMIT_S
        within &= found.peak_gib <= LIMIT_GIB and found.page_mb < LIMIT_MB
        lines.append(
            f"| {product} | {found.with_build_s:.1f} s | {found.again_s:.1f} s | {found.peak_gib:.2f} GiB "
            f"| {found.page_mb:.1f} MB |"
        )
    return "\n".join(lines), within


def main(arguments: list[str]) -> int:
    if not arguments:
        text, fine = table()
        print(text)
        return 0 if fine else 1
    task, *rest = arguments
    if task == "build":
        json.dump(measure_build(rest[0], Path(rest[1])), sys.stdout)
    else:
        json.dump(measure_again(Path(rest[0])), sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
