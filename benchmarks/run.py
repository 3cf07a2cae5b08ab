"""Measure what docs/benchmarks.md promises: time and memory of the commands, accuracy of the numbers.

Run it with `make bench`; `--write` renews the tables in docs/benchmarks.md. Exits with 1 beyond a limit.
"""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import certify
import mesh_census
import report
import tolerance

REPEATS = 5
KIB_PER_GIB = 1024 * 1024
PAGE = Path(__file__).resolve().parent.parent / "docs" / "benchmarks.md"
BEGIN, END = "<!-- begin results -->", "<!-- end results -->"


@dataclass(frozen=True)
class Command:
    """One command with the median wall time and the memory it may take."""

    name: str
    arguments: tuple[str, ...]
    limit_s: float
    limit_gib: float = 2.0
    repeats: int = REPEATS


COMMANDS = (
    Command("`gomboc-cad --help`", ("--help",), limit_s=0.4),
    Command("`gomboc-cad catalog`", ("catalog", "--json"), limit_s=1.5),
    Command("`gomboc-cad census primary`, with imports", ("census", "primary", "--json"), limit_s=2.0),
    Command("`gomboc-cad body primary`", ("body", "primary", "-o", "OUT", "--force", "-q"), limit_s=30.0),
    Command("`gomboc-cad drillmap primary`", ("drillmap", "primary", "-q"), limit_s=30.0),
    Command("`gomboc-cad zone primary`", ("zone", "primary", "-q"), limit_s=60.0),
    *(
        Command(
            f"`gomboc-cad build {product}`",
            ("build", product, "-o", "OUT", "--force", "-q"),
            limit_s=60.0,
            limit_gib=3.0,
            repeats=3,
        )
        for product in ("imu-housing", "seed-pod", "buoy")
    ),
)


@dataclass(frozen=True)
class Accuracy:
    """A number beside its reference, with the error allowed, in units of `scale` or of the reference."""

    name: str
    value: float
    reference: float
    allowed: float
    scale: float | None = None

    @property
    def error(self) -> float:
        """Error in units of the scale."""
        return abs(self.value - self.reference) / abs(self.scale or self.reference)


def run(arguments: list[str]) -> tuple[float, float]:
    """Wall time in s and peak memory in GiB of one command; RuntimeError if it fails."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    start = time.perf_counter()
    child = os.posix_spawn(
        arguments[0], arguments, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, nowhere, 1)]
    )
    _, status, usage = os.wait4(child, 0)
    seconds = time.perf_counter() - start
    os.close(nowhere)
    if code := os.waitstatus_to_exitcode(status):
        raise RuntimeError(f"{' '.join(arguments)} ended with code {code}")
    memory_kib = usage.ru_maxrss / (1024 if sys.platform == "darwin" else 1)
    return seconds, memory_kib / KIB_PER_GIB


def measure_commands(command: str, out: str) -> tuple[list[str], bool]:
    """Rows of the table of commands, and whether all are within their limits.

    The commands take turns, so that a slow spell of the machine falls on all of them.
    """
    runs: list[list[tuple[float, float]]] = [[] for _ in COMMANDS]
    for turn in range(REPEATS):
        for item, results in zip(COMMANDS, runs, strict=True):
            if turn >= item.repeats:
                continue
            results.append(run([command, *(out if word == "OUT" else word for word in item.arguments)]))
            print(f"{item.name}: {results[-1][0]:.2f} s", file=sys.stderr, flush=True)
    rows, within = [], True
    for item, results in zip(COMMANDS, runs, strict=True):
        seconds = [second for second, _ in results]
        median, memory = statistics.median(seconds), max(memory for _, memory in results)
        within &= median <= item.limit_s and memory <= item.limit_gib
        rows.append(
            f"| {item.name} | {median:.2f} s | {min(seconds):.2f} to {max(seconds):.2f} s | "
            f"{item.limit_s:g} s | {memory:.2f} GiB | {item.limit_gib:g} GiB |"
        )
    return rows, within


def measure_accuracy(command: str) -> tuple[list[str], bool]:
    """Rows of the table of numbers, and whether all agree with their references."""

    def census(*arguments: str) -> dict[str, float]:
        done = subprocess.run(
            [command, "census", *arguments, "--json"], capture_output=True, text=True, check=True
        )
        return json.loads(done.stdout)

    primary, unit, sloan = (
        census("primary"),
        census("primary", "--diameter-mm", "2"),
        census("sloan2-0.030", "--diameter-mm", "2"),
    )
    numbers = (
        Accuracy("volume of the primary, 100 mm (mm³)", primary["volume_mm3"], 523458.313905, 1e-9),
        Accuracy(
            "centroid of the primary, x (mm), error in R₀", primary["com_mm"][0], -0.134778477, 1e-9, 50.0
        ),
        Accuracy("margin of the primary (R₀)", unit["margin_mm"], 0.00330, 0.01),
        Accuracy("S-margin of the primary (R₀)", unit["s_margin_mm"], 0.00339, 0.01),
        Accuracy("height range of the primary (R₀)", unit["height_range_mm"], 0.0518, 0.01),
        Accuracy("smallest curvature of the primary (1/R₀)", unit["min_curvature_per_mm"], 0.0885, 0.01),
        Accuracy("margin of Sloan 2 at β = 0.03 (R₀)", sloan["margin_mm"], 0.00114, 0.01),
    )
    rows = [
        f"| {n.name} | {n.value:.12g} | {n.reference:.12g} | {n.error:.1e} | {n.allowed:g} |" for n in numbers
    ]
    return rows, all(n.error <= n.allowed for n in numbers)


def machine() -> str:
    """One line about the machine."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = [
            line for line in cpuinfo.read_text(encoding="utf-8").splitlines() if line.startswith("model name")
        ]
        model = lines[0].partition(":")[2].strip() if lines else model
    return f"{os.cpu_count()} cores, {model}, {platform.system()}, Python {platform.python_version()}"


def main() -> int:
    command = str(Path(sys.executable).with_name("gomboc-cad"))
    accuracy_rows, accurate = measure_accuracy(command)
    with tempfile.TemporaryDirectory() as out:
        command_rows, quick = measure_commands(command, out)
    census_tables, census_within = mesh_census.tables()
    certificate_table, certificates_within = certify.table()
    study_tables, study_within = tolerance.tables()
    report_table, report_within = report.table()
    text = "\n".join(
        [
            f"Machine: {machine()}. Median of {REPEATS} runs, of 3 builds, taking turns.",
            "",
            "| command | median | range | limit | peak memory | limit |",
            "|---|---|---|---|---|---|",
            *command_rows,
            "",
            "| number | found | reference | relative error | allowed |",
            "|---|---|---|---|---|",
            *accuracy_rows,
            "",
            "## Census of meshes",
            "",
            census_tables,
            "",
            "## Certificates",
            "",
            "Each in a new process on one core.",
            "",
            certificate_table,
            "",
            "## The tolerance study",
            "",
            study_tables,
            "",
            "## The report",
            "",
            report_table,
        ]
    )
    print(text)
    if "--write" in sys.argv[1:]:
        page = PAGE.read_text(encoding="utf-8")
        before, after = page.split(BEGIN)[0], page.split(END)[1]
        PAGE.write_text(f"{before}{BEGIN}\n\n{text}\n\n{END}{after}", encoding="utf-8")
    within = (quick, accurate, census_within, certificates_within, study_within, report_within)
    return 0 if all(within) else 1


if __name__ == "__main__":
    sys.exit(main())
