#!/usr/bin/env python3
"""Stands for a Python that has the package, where a test needs one that is slow, breaks or lies.

Beside it lie `behaviour.json` (what to do, see `main`) and `primary.step`. It writes its process id there.
"""

import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
TEMPLATES = {
    **{name: [] for name in ("boards", "batteries", "seeds", "processes", "trims")},
    "materials": ["PLA"],
    "density_g_cm3": {"PLA": 1.25},
    "specs": {},
}


def say(document):
    print(json.dumps(document))


def body(arguments, behaviour):
    folder = Path(arguments[arguments.index("-o") + 1])
    diameter_mm = float(arguments[arguments.index("--diameter-mm") + 1])
    print("[1/2] making the solid", file=sys.stderr, flush=True)
    (HERE / "pid").write_text(str(os.getpid()))
    if behaviour.get("deaf"):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    time.sleep(behaviour.get("seconds", 0.0))
    if behaviour.get("kill"):
        os.kill(os.getpid(), signal.SIGKILL)
    if "sentence" in behaviour:
        print(f"gomboc-cad: {behaviour['sentence']}", file=sys.stderr)
        return 2
    if "output" in behaviour:
        print(behaviour["output"])
        return 0
    folder.mkdir(parents=True)
    shutil.copy(HERE / behaviour.get("step", "primary.step"), folder / "primary.step")
    document = {
        "body": "primary",
        "diameter_mm": diameter_mm,
        "volume_mm3": 1000.0,
        "com_mm": [-0.25, 0.0, 0.0],
        "s_margin_mm": 1e-3 * diameter_mm,
        "rest": {"direction": [-1.0, 0.0, 0.0], "height_mm": 0.5 * diameter_mm},
        "verdict": "PASS",
        "reasons": ["Said by a test."],
    }
    document.pop(behaviour.get("without"), None)
    say(document)
    return 0


def main(arguments):
    behaviour = json.loads((HERE / "behaviour.json").read_text())
    with (HERE / "calls").open("a") as calls:
        calls.write(" ".join(arguments) + "\n")
    if "--version" in arguments:
        print(f"gomboc-cad {behaviour.get('version', '0.1.0')}")
        return 0
    if "catalog" in arguments:
        say({"bodies": [{"name": "primary", "status": "proven"}, {"name": "bad", "status": "refuted"}]})
        return 0
    if "templates" in arguments:
        say(TEMPLATES)
        return 0
    return body(arguments, behaviour)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
