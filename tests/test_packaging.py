"""What is published: what the wheel and the source contain, whether tools find fault with it, and its versions."""

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
PACKAGE = {
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / "gyrodata").rglob("*")
    if path.is_file() and "__pycache__" not in path.parts
}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("dist")
    line = [sys.executable, "-m", "hatchling", "build", "--directory", str(folder)]
    subprocess.run(line, cwd=ROOT, check=True, capture_output=True)
    return folder


def test_the_wheel_contains_the_package_alone(built: Path) -> None:
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        names = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert names == PACKAGE
    assert {"gyrodata/py.typed", "gyrodata/docs/theory.md", "gyrodata/reporting/report.css"} < names


def test_the_source_contains_what_its_tests_read(built: Path) -> None:
    with tarfile.open(next(built.glob("*.tar.gz"))) as source:
        names = {member.name.partition("/")[2] for member in source.getmembers() if member.isfile()}
    beside = {"README.md", "pyproject.toml", ".github/CONTRIBUTING.md", ".ci/run", ".gitignore", "PKG-INFO"}
    assert {name for name in names if not name.startswith(("gyrodata/", "tests/", "sample_data/"))} == beside
    assert names >= {*PACKAGE, "tests/test_packaging.py", "tests/promises.toml", "sample_data/notebook.ipynb"}
    assert not any(name.endswith((".pyc", ".part")) for name in names)


@pytest.mark.parametrize("tool", ["twine check --strict", "check-wheel-contents", "pyroma"])
def test_a_tool_finds_no_fault_but_what_the_owner_gives(tool: str, built: Path) -> None:
    if shutil.which(tool.split()[0]) is None:
        pytest.skip(f"no {tool} on this machine")
    files = {"check-wheel-contents": "*.whl", "pyroma": "*.tar.gz"}.get(tool, "*")
    done = subprocess.run([*tool.split(), *map(str, built.glob(files))], capture_output=True, text=True)
    if tool == "pyroma":
        faults = [fault for fault in done.stdout.split("-" * 30)[2].splitlines() if fault]
        assert [fault for fault in faults if not re.search("author|url|license", fault)] == [], done.stdout
    else:
        assert done.returncode == 0, done.stdout + done.stderr


def test_every_library_has_a_floor_and_one_has_a_cap() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    assert [one for one in named if not re.fullmatch(r"[\w-]+>=[\d.]+", one)] == ["typer>=0.20,<0.29"]


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
