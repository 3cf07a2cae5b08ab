"""Measure the tolerance study: variants per second, one and two workers, memory, the paper's oracle too.

`python benchmarks/tolerance.py` prints the tables; `benchmarks/run.py` puts them into docs/benchmarks.md.
"""

from __future__ import annotations

import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

REPEATS = 5
PROCESS, COM_ERROR_MM, DEGREE = "cnc-5axis", 0.01, 16
SPEED_VARIANTS, LARGE_VARIANTS = 20_000, 100_000
LEAST_PER_S, LEAST_SPEEDUP, LARGE_LIMIT_S, LARGE_LIMIT_GIB = 2000.0, 1.7, 120.0, 2.0
ASKED_RATIO = 1000.0
DIRECTIONS = (5_000, 80_000, 1_280_000)
"""Of the paper's oracle: its own number, then each time four times as fine."""


@dataclass(frozen=True)
class Speed:
    """A study timed, without the start of the processes."""

    seconds: float
    variants: int

    @property
    def per_s(self) -> float:
        """Variants per second."""
        return self.variants / self.seconds


def model():
    """The primary, 100 mm, with form error up to order 16 and an error of the centre of mass."""
    from gomboc_cad.body import catalog
    from gomboc_cad.products.process import load_process
    from gomboc_cad.tolerance.product_study import body_study

    study = body_study(catalog()["primary"], load_process(PROCESS), com_error_mm=COM_ERROR_MM, degree=DEGREE)
    return study.only(*(s.name for s in study.sources if s.name in ("form_error", "com_error")))


def timed_study(workers: int, variants: int, folder: str) -> Speed:
    """Run one study with warm workers."""
    from gomboc_cad.tolerance.executors import executor_for
    from gomboc_cad.tolerance.study import run_study

    study = model()
    with executor_for(f"local:{workers}") as pool:
        run_study(study, 512 * workers * 2, 0, executor=pool)
        start = time.perf_counter()
        run_study(study, variants, 1, executor=pool, store=Path(folder) / f"{workers}-{variants}.csv")
        return Speed(time.perf_counter() - start, variants)


def measure_scaling() -> dict[str, float]:
    """Medians of one and of two workers, taking turns."""
    speeds: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(REPEATS):
        for workers, found in speeds.items():
            with tempfile.TemporaryDirectory() as folder:
                found.append(timed_study(workers, SPEED_VARIANTS, folder).per_s)
    return {"one": statistics.median(speeds[1]), "two": statistics.median(speeds[2])}


def measure_large() -> dict[str, float]:
    """The large study with start and end, and the most memory that it and its workers take together."""
    peak = [0.0]
    done = threading.Event()

    def watch() -> None:
        while not done.wait(0.2):
            peak[0] = max(peak[0], _resident_gib(os.getpid()))

    watcher = threading.Thread(target=watch)
    watcher.start()
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        timed_study(2, LARGE_VARIANTS, folder)
    seconds = time.perf_counter() - start
    done.set()
    watcher.join()
    return {"seconds": seconds, "peak_gib": peak[0]}


def _resident_gib(root: int) -> float:
    """Resident memory of a process and all its descendants, from /proc; of this one alone without that."""
    processes = Path("/proc")
    if not (processes / "self" / "stat").exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**3
    parents, pages = {}, {}
    for entry in processes.iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                pages[int(entry.name)] = int((entry / "statm").read_text().split()[1])
            except (OSError, IndexError):
                continue
    family, fresh = set(), {root}
    while fresh:
        family |= fresh
        fresh = {child for child, parent in parents.items() if parent in family} - family
    return sum(pages.get(process, 0) for process in family) * resource.getpagesize() / 1024**3


def measure_oracle() -> list[dict[str, float]]:
    """The paper's oracle on its own mesh of the primary: time, and how far its rest is from the true one."""
    import numpy as np

    from gomboc_cad.body import catalog
    from gomboc_cad.equilibria import smooth_census
    from gomboc_cad.equilibria.drainage import DrainageOptions, drainage_count
    from gomboc_cad.equilibria.drainage_shapes import ring_mesh

    body = catalog()["primary"]
    census = smooth_census(body)
    mesh = ring_mesh(body.position_mm)
    rows = []
    for directions in DIRECTIONS:
        options = DrainageOptions(directions=directions)
        drainage_count(*mesh, options=options)
        seconds = []
        for _ in range(REPEATS if directions == DIRECTIONS[0] else 1):
            start = time.perf_counter()
            found = drainage_count(*mesh, options=options)
            seconds.append(time.perf_counter() - start)
        cosine = np.dot(found.clusters[0].direction, census.rest.direction)
        off = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        rows.append({"directions": directions, "seconds": statistics.median(seconds), "off_deg": float(off)})
    return rows


def _in_a_new_process(task: str):
    done = subprocess.run([sys.executable, __file__, task], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def tables() -> tuple[str, bool]:
    """The Markdown tables, and whether all limits are kept but for the ratio, which is told as it is."""
    scaling, large, oracle = (_in_a_new_process(task) for task in ("scaling", "large", "oracle"))
    speedup = scaling["two"] / scaling["one"]
    within = scaling["two"] >= LEAST_PER_S and speedup >= LEAST_SPEEDUP
    within &= large["seconds"] <= LARGE_LIMIT_S and large["peak_gib"] <= LARGE_LIMIT_GIB
    lines = [
        f"The primary, 100 mm, {PROCESS}: form error up to order {DEGREE} and an error of the centre of "
        f"mass; medians of {REPEATS}, one and two workers taking turns.",
        "",
        "| study | found | limit |",
        "|---|---|---|",
        f"| variants per second, one worker | {scaling['one']:,.0f} | – |",
        f"| variants per second, two workers | {scaling['two']:,.0f} | ≥ {LEAST_PER_S:,.0f} |",
        f"| two workers over one | {speedup:.2f} | ≥ {LEAST_SPEEDUP:g} |",
        f"| {LARGE_VARIANTS:,} variants, rows written, processes started | {large['seconds']:.1f} s "
        f"| {LARGE_LIMIT_S:g} s |",
        f"| memory of all its processes together | {large['peak_gib']:.2f} GiB | {LARGE_LIMIT_GIB:g} GiB |",
        "",
        "The source paper's oracle in the same run, on its own mesh of 40,000 facets. Asked for was a ratio "
        f"of {ASKED_RATIO:,.0f} on meshes of the same accuracy.",
        "",
        "| directions | one body | its rest is off by | variants that the study judges in that time |",
        "|---|---|---|---|",
    ]
    for row in oracle:
        lines.append(
            f"| {row['directions']:,} | {row['seconds']:.3f} s | {row['off_deg']:.2f}° "
            f"| {row['seconds'] * scaling['two']:,.0f} |"
        )
    return "\n".join(lines), within


if __name__ == "__main__":
    if len(sys.argv) == 1:
        text, fine = tables()
        print(text)
        sys.exit(0 if fine else 1)
    measured = {"scaling": measure_scaling, "large": measure_large, "oracle": measure_oracle}[sys.argv[1]]
    print(json.dumps(measured()))
