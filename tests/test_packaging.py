"""What is published: what lies in the wheel and in the source, whether tools find fault with it, and its versions."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
OWNERS = ("author", "url", "license")  # are the owner's to give


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("dist")
    line = [sys.executable, "-m", "hatchling", "build", "--directory", str(folder)]
    subprocess.run(line, cwd=ROOT, check=True, capture_output=True)
    return folder


def files(room: str) -> set[str]:
    found = (path for path in (ROOT / room).rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return {path.relative_to(ROOT).as_posix() for path in found}


def test_the_wheel_holds_the_package_alone(built: Path) -> None:
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        names = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert names == files("gyrodata")
    assert {"gyrodata/py.typed", "gyrodata/docs/theory.md", "gyrodata/reporting/report.css"} < names
    assert any(name.endswith(".jinja") for name in names)


def test_the_source_holds_what_its_tests_read(built: Path) -> None:
    with tarfile.open(next(built.glob("*.tar.gz"))) as source:
        names = {member.name.partition("/")[2] for member in source.getmembers() if member.isfile()}
    beside = {"README.md", "pyproject.toml", ".github/CONTRIBUTING.md", ".ci/run", ".gitignore", "PKG-INFO"}
    assert {name for name in names if not name.startswith(("gyrodata/", "tests/", "sample_data/"))} == beside
    assert names >= files("gyrodata")
    assert {"tests/test_packaging.py", "tests/promises.toml", "sample_data/notebook.ipynb"} < names
    assert not any(name.endswith((".pyc", ".part")) for name in names)


@pytest.mark.parametrize("tool", ["twine check --strict", "check-wheel-contents"])
def test_a_tool_finds_no_fault(tool: str, built: Path) -> None:
    name, *options = tool.split()
    if shutil.which(name) is None:
        pytest.skip(f"no {name} on this machine")
    kind = "*" if name == "twine" else "*.whl"
    done = subprocess.run([name, *options, *map(str, built.glob(kind))], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(shutil.which("pyroma") is None, reason="no pyroma on this machine")
def test_what_pyroma_misses_is_the_owners(built: Path) -> None:
    said = subprocess.run(["pyroma", str(next(built.glob("*.tar.gz")))], capture_output=True, text=True).stdout
    faults = said.split("-" * 30)[2].splitlines()
    assert [fault for fault in faults if fault and not any(word in fault for word in OWNERS)] == [], said


def test_every_library_has_a_floor_and_one_has_a_cap() -> None:
    extra = PROJECT["project"]["optional-dependencies"]["test"]
    named = [*PROJECT["project"]["dependencies"], *extra]
    assert [one for one in named if not re.fullmatch(r"[\w-]+>=[\d.]+(,<[\d.]+)?", one)] == []
    assert [one for one in named if "<" in one] == ["typer>=0.20,<0.29"]


def test_a_start_loads_no_pydantic() -> None:
    # The newer typer that does takes half as much again for every log; its cap goes when this passes without it.
    code = (
        "import sys\n"
        "sys.argv = ['gyro', 'analyze', 'sample_data/air_gyroscope.csv', '--no-report', '--format', 'json']\n"
        "from gyrodata.__main__ import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        "print('pydantic' in sys.modules, file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("{")
    assert done.stderr.split()[-1] == "False"
