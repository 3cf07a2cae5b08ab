"""Measure the certificates: time and peak memory of each body, in a fresh process each, beside the limits.

`python benchmarks/certify.py` prints the table; `benchmarks/run.py` puts it into docs/benchmarks.md.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time

LIMIT_S, LIMIT_MB = 60.0, 500.0


def measure(name: str) -> dict[str, float | str | bool]:
    """Certify one body and check the certificate, in this process."""
    start = time.process_time()
    from gomboc_cad.body.catalogue import exact_parameters
    from gomboc_cad.equilibria.certificate import certify, dumps, loads, verify

    certificate = certify(exact_parameters(name))
    text = dumps(certificate)
    certified = time.process_time()
    accepted = verify(loads(text)).accepted
    verified = time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {
        "status": certificate.status,
        "accepted": accepted,
        "certify_s": certified - start,
        "verify_s": verified - certified,
        "peak_mb": peak / (1e6 if sys.platform == "darwin" else 1e3),
        "kilobytes": len(text) / 1e3,
    }


def table() -> tuple[str, bool]:
    """The Markdown table, and whether all limits are kept."""
    from gomboc_cad.body.catalogue import catalogue_names

    lines = [
        f"| certificate of | status | certify, limit {LIMIT_S:g} s | verify | memory, limit {LIMIT_MB:g} MB "
        "| size |",
        "|---|---|---|---|---|---|",
    ]
    within = True
    for name in catalogue_names():
        done = subprocess.run([sys.executable, __file__, name], capture_output=True, text=True, check=True)
        found = json.loads(done.stdout)
        within &= found["accepted"] and found["certify_s"] <= LIMIT_S and found["peak_mb"] <= LIMIT_MB
        lines.append(
            f"| {name} | {found['status']} | {found['certify_s']:.2f} s | {found['verify_s']:.3f} s | "
            f"{found['peak_mb']:.0f} MB | {found['kilobytes']:.0f} kB |"
        )
    return "\n".join(lines), within


if __name__ == "__main__":
    if len(sys.argv) == 1:
        text, fine = table()
        print(text)
        sys.exit(0 if fine else 1)
    json.dump(measure(sys.argv[1]), sys.stdout)
