"""Promises of the project as a whole: what loads what, what the wheel carries, what the lock files hold."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import gomboc_cad

MAX_LINES = 450
LOCKS = ("demo.txt", "test.txt")

# Names the folders directly under site-packages (or single modules there) whose files were loaded.
LIST_LOADED = """
import json, pathlib, sys, sysconfig
homes = [pathlib.Path(sysconfig.get_path(name)).resolve() for name in ("purelib", "platlib")]
names = set()
for module in list(sys.modules.values()):
    file = getattr(module, "__file__", None)
    for home in homes:
        if file and pathlib.Path(file).resolve().is_relative_to(home):
            names.add(pathlib.Path(file).resolve().relative_to(home).parts[0].split(".")[0])
print(json.dumps(sorted(names)))
"""


def loaded_after(statement: str) -> set[str]:
    """Installed packages (top-level names) that a fresh interpreter has loaded after a statement."""

    def names(code: str) -> set[str]:
        command = [sys.executable, "-c", code + LIST_LOADED]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
        assert done.returncode == 0, done.stderr
        return set(json.loads(done.stdout.splitlines()[-1]))

    return names(statement) - names("")


def modules_below(root: Path) -> list[Path]:
    return sorted((root / "gomboc_cad").rglob("*.py"))


@pytest.mark.parametrize("room", ["body", "equilibria"])
def test_mathematics_loads_only_numpy_and_scipy(room: str) -> None:
    assert loaded_after(f"import gomboc_cad.{room}\n") <= {"gomboc_cad", "numpy", "scipy"}


def test_the_census_of_meshes_loads_only_what_scipys_graphs_load() -> None:
    scipys = loaded_after("import scipy.sparse.csgraph, scipy.spatial\n")
    assert loaded_after("from gomboc_cad.equilibria import mesh_census\n") <= {"gomboc_cad"} | scipys


def test_hydrostatics_loads_no_more_than_that() -> None:
    scipys = loaded_after("import scipy.sparse.csgraph, scipy.spatial\n")
    assert loaded_after("import gomboc_cad.hydrostatics\n") <= {"gomboc_cad"} | scipys


def test_the_certificate_loads_only_ball_arithmetic_besides() -> None:
    loaded = loaded_after("import gomboc_cad.equilibria.certificate\n")
    assert loaded <= {"gomboc_cad", "numpy", "scipy", "flint"}


def test_help_loads_no_cad() -> None:
    show_help = (
        "import sys\n"
        "from gomboc_cad.cli import main\n"
        "sys.argv = ['gomboc-cad', '--help']\n"
        "try:\n"
        "    main()\n"
        "except SystemExit as end:\n"
        "    assert not end.code, end.code\n"
    )
    loaded = loaded_after(show_help)
    kernels = {"OCP", "build123d", "bd_warehouse", "cadquery", "vtkmodules"}
    meshes = {"trimesh", "manifold3d", "lib3mf", "pymeshlab"}
    assert not loaded & (kernels | meshes)


def test_version_is_stated_once_and_the_same(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert gomboc_cad.__version__ == project["version"] == metadata.version("gomboc-cad")


def test_modules_can_be_read_in_one_sitting(root: Path) -> None:
    lengths = {
        str(path.relative_to(root)): len(path.read_text(encoding="utf-8").splitlines())
        for path in modules_below(root)
    }
    assert {name: lines for name, lines in lengths.items() if lines > MAX_LINES} == {}


@pytest.fixture(scope="module")
def distributions(root: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The source distribution, and the wheel built from it alone."""
    out = tmp_path_factory.mktemp("dist")

    def build(target: str, source: Path) -> Path:
        command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(out)]
        done = subprocess.run(command, cwd=source, capture_output=True, encoding="utf-8", check=False)
        assert done.returncode == 0, done.stderr
        (built,) = out.glob({"sdist": "*.tar.gz", "wheel": "*.whl"}[target])
        return built

    sdist = build("sdist", root)
    with tarfile.open(sdist) as archive:
        archive.extractall(out / "unpacked", filter="data")
    (source,) = (out / "unpacked").iterdir()
    return sdist, build("wheel", source)


def test_wheel_carries_code_data_and_templates(root: Path, distributions: tuple[Path, Path]) -> None:
    with zipfile.ZipFile(distributions[1]) as wheel:
        names = set(wheel.namelist())

    def files_below(folder: str) -> set[str]:
        paths = (path for path in (root / folder).rglob("*") if path.is_file())
        return {path.relative_to(root).as_posix() for path in paths if "__pycache__" not in path.parts}

    code_and_data = files_below("gomboc_cad")
    templates = {f"gomboc_cad/{name}" for name in files_below("templates")}
    assert "gomboc_cad/body/catalogue.toml" in code_and_data
    assert templates
    expected = code_and_data | templates
    assert {name for name in names if ".dist-info/" not in name} == expected
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in names)


def test_source_distribution_carries_tests_and_documentation(distributions: tuple[Path, Path]) -> None:
    with tarfile.open(distributions[0]) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    assert {"Makefile", "README.md", "mkdocs.yml", "docs/index.md", "requirements/test.txt"} <= names
    assert {"tests/conftest.py", "tests/external.py"} <= names


def pinned(root: Path, lock: str) -> dict[str, list[Requirement]]:
    """The pins of a lock file by package name; several where they depend on the Python version."""
    text = (root / "requirements" / lock).read_text(encoding="utf-8")
    found: dict[str, list[Requirement]] = {}
    for line in text.replace("\\\n", " ").splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            assert "--hash=sha256:" in line, line
            requirement = Requirement(line.split(" --hash=")[0].strip())
            found.setdefault(canonicalize_name(requirement.name), []).append(requirement)
    return found


@pytest.mark.parametrize("lock", LOCKS)
def test_lock_names_no_place(root: Path, lock: str) -> None:
    text = (root / "requirements" / lock).read_text(encoding="utf-8")
    assert not re.search(r"://|--(extra-)?index-url|--find-links|(^|\s)\.?/", text)


@pytest.mark.parametrize("lock", LOCKS)
def test_lock_pins_what_the_project_asks_for(root: Path, lock: str) -> None:
    pyproject = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    asked = pyproject["project"]["dependencies"] + pyproject["dependency-groups"]["build"]
    if lock == "test.txt":
        for extra in pyproject["project"]["optional-dependencies"].values():
            asked = asked + extra
    pins = pinned(root, lock)
    for requirement in map(Requirement, asked):
        name = canonicalize_name(requirement.name)
        if name == "gomboc-cad":
            continue
        assert name in pins, f"{lock} lacks {name}: run `make lock`"
        for pin in pins[name]:
            (exact,) = pin.specifier
            assert exact.operator == "=="
            assert requirement.specifier.contains(exact.version), f"{lock} has {pin}, asked is {requirement}"


def test_locks_agree_and_hold_one_kernel_each(root: Path) -> None:
    demo, test = (pinned(root, lock) for lock in LOCKS)
    kernels = {"cadquery-ocp", "cadquery-ocp-novtk"}
    assert kernels & set(demo) == {"cadquery-ocp-novtk"}
    assert kernels & set(test) == {"cadquery-ocp"}
    common = set(demo) & set(test)
    for name in common:
        assert {str(pin.specifier) for pin in demo[name]} == {str(pin.specifier) for pin in test[name]}
