"""Measure the mesh census: beside trimesh on the same mesh, over a range of sizes, and its memory.

`python benchmarks/mesh_census.py` prints the tables; `benchmarks/run.py` puts them into docs/benchmarks.md.
"""

from __future__ import annotations

import json
import math
import resource
import statistics
import subprocess
import sys
import time
from typing import Any

REPEATS = 5
COMPARED_FACETS, LEAST_RATIO = 20_480, 50.0
LARGE_FACETS, LARGE_LIMIT_S = 327_680, 3.0
LARGEST_FACETS, LARGEST_LIMIT_GIB = 2_000_000, 4.0
SIZES = (5_120, 20_480, 81_920, LARGE_FACETS, 1_310_720, LARGEST_FACETS)


def mesh_of(facets: int) -> tuple[Any, Any]:
    """The primary meshed with a number of facets: a geodesic sampling where there is one, else a spiral."""
    import numpy as np
    from scipy.spatial import ConvexHull

    from gomboc_cad.body import catalog
    from gomboc_cad.body.sphere import fibonacci_directions, geodesic_triangulation

    body = catalog()["primary"]
    level = math.log(facets / 20, 4)
    if level == round(level):
        directions, faces = geodesic_triangulation(round(level))
        return body.position_mm(directions), faces
    points = body.position_mm(fibonacci_directions(facets // 2 + 2))
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("nx,nx->n", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def measure_size(facets: int) -> dict[str, Any]:
    """Time the census of one mesh, hull included, and the memory of this process."""
    from gomboc_cad.equilibria import mesh_census

    mesh = mesh_of(facets)
    seconds = []
    for _ in range(REPEATS if facets <= LARGE_FACETS else 1):
        start = time.perf_counter()
        census = mesh_census(*mesh)
        seconds.append(time.perf_counter() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert census.mesh is not None
    return {
        "seconds": statistics.median(seconds),
        "peak_gib": peak / (1024**3 if sys.platform == "darwin" else 1024**2),
        "verdict": census.verdict,
        "raw": census.mesh.raw_stable,
    }


def measure_comparison() -> dict[str, Any]:
    """Time our census and trimesh's stable poses on one mesh, taking turns."""
    import trimesh

    from gomboc_cad.equilibria import mesh_census

    vertices, faces = mesh_of(COMPARED_FACETS)
    ours, theirs = [], []
    for _ in range(REPEATS):
        start = time.perf_counter()
        census = mesh_census(vertices, faces)
        ours.append(time.perf_counter() - start)
        start = time.perf_counter()
        transforms, _ = trimesh.Trimesh(vertices, faces, process=False).compute_stable_poses()
        theirs.append(time.perf_counter() - start)
    return {
        "ours_s": statistics.median(ours),
        "theirs_s": statistics.median(theirs),
        "ours": census.stable,
        "theirs": len(transforms),
    }


def _in_a_new_process(task: str) -> dict[str, Any]:
    done = subprocess.run([sys.executable, __file__, task], capture_output=True, text=True, check=True)
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def tables() -> tuple[str, bool]:
    """The Markdown tables, and whether all limits are kept."""
    compared = _in_a_new_process("compare")
    ratio = compared["theirs_s"] / compared["ours_s"]
    within = ratio >= LEAST_RATIO and compared["ours"] == 1
    lines = [
        f"| {COMPARED_FACETS:,} facets, convex | median of {REPEATS} | stable poses found (true: 1) |",
        "|---|---|---|",
        f"| `mesh_census` with hull, persistence and COM | {compared['ours_s']:.3f} s | {compared['ours']} |",
        f"| `trimesh.poses.compute_stable_poses` | {compared['theirs_s']:.2f} s | {compared['theirs']} |",
        f"| ratio, at least {LEAST_RATIO:g} asked for | {ratio:.0f} | |",
        "",
        "| facets | census, hull included | limit | peak memory | limit | verdict | raw stable facets |",
        "|---|---|---|---|---|---|---|",
    ]
    times = {}
    for facets in SIZES:
        found = _in_a_new_process(str(facets))
        times[facets] = found["seconds"]
        limit_s = LARGE_LIMIT_S if facets == LARGE_FACETS else None
        limit_gib = LARGEST_LIMIT_GIB if facets == LARGEST_FACETS else None
        within &= found["verdict"] == "monostable"
        within &= limit_s is None or found["seconds"] <= limit_s
        within &= limit_gib is None or found["peak_gib"] <= limit_gib
        lines.append(
            f"| {facets:,} | {found['seconds']:.3f} s | {f'{limit_s:g} s' if limit_s else '–'} "
            f"| {found['peak_gib']:.2f} GiB | {f'{limit_gib:g} GiB' if limit_gib else '–'} "
            f"| {found['verdict']} | {found['raw']} |"
        )
        print(f"{facets:,} facets: {found['seconds']:.2f} s", file=sys.stderr, flush=True)
    power = growth(times)
    lines += ["", f"Fit over these sizes: time ∝ (n log n)^{power:.2f}."]
    return "\n".join(lines), within


def growth(times: dict[int, float]) -> float:
    """Power p of the fit `time ∝ (n log n)^p` by least squares in the logarithms."""
    x = [math.log(n * math.log(n)) for n in times]
    y = [math.log(seconds) for seconds in times.values()]
    return statistics.linear_regression(x, y).slope


if __name__ == "__main__":
    if len(sys.argv) == 1:
        text, fine = tables()
        print(text)
        sys.exit(0 if fine else 1)
    json.dump(
        measure_comparison() if sys.argv[1] == "compare" else measure_size(int(sys.argv[1])), sys.stdout
    )
