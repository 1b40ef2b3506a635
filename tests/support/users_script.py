"""What a user writes who calls every public function: checkers of types see no fault,
and it runs.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, assert_type

import gyrodata


def everything(log: Path, class_folder: Path, folder: Path) -> float:
    readings = gyrodata.read_log(log, mapping={}, settings={"g": "9.803 m/s^2"})
    assert_type(readings, gyrodata.Readings)
    assert_type(readings.constants["g"], float)
    try:
        gyrodata.analyze(b"nothing", name="nothing")
    except gyrodata.LogError as error:
        assert_type(error.diagnostics, tuple[gyrodata.Diagnostic, ...])
    except (gyrodata.InputError, gyrodata.GyroError) as error:
        print(error.exit_code)
    lab = gyrodata.analyze(log, model="horizontal", keep_flagged=True)
    assert_type(lab, gyrodata.Analysis)
    assert_type(lab.inertia, gyrodata.Result)
    assert_type(lab.inertia.u, float | None)
    assert_type(lab.report(folder), Path)
    assert_type(f"{lab.inertia:.2u}", str)
    assert_type(list(lab.ufloats()), list[str])
    print(lab.runs["spin"].mean(), lab.plot("torque").get_title())
    simulation = gyrodata.simulate(
        gyrodata.Truth(inertia=4.4e-3),
        gyrodata.Design(masses=(0.02, 0.04)),
        {"u_time": gyrodata.Uncertainty(0.2)},
        7,
    )
    assert_type(simulation, gyrodata.Simulation)
    checked = gyrodata.selfcheck(lab, labs=20)
    assert_type(checked, gyrodata.SelfCheck)
    line = gyrodata.fit_line([1.0, 2.0, 3.0], [1.0, 2.1, 2.9], cov_y=0.01)
    assert_type(line, gyrodata.LineFit)
    grades = gyrodata.grade(class_folder, workers=0)
    assert_type(grades, gyrodata.ClassGrades)
    assert_type(gyrodata.__version__, str)
    return lab.inertia.value + line.slope + len(grades.grades) + checked.labs


if TYPE_CHECKING:
    # mypy must see that each line is wrong: a comment that it does not need is an
    # error.
    LAB = gyrodata.analyze("log.csv", model="stedy")  # type: ignore[arg-type]
    WORD: str = LAB.inertia.value  # type: ignore[assignment]
    HALF = LAB.inertia.u / 2  # type: ignore[operator]
    OTHER = gyrodata.anlyze("log.csv")  # type: ignore[attr-defined]
    LAB.inertia.value = 3.0  # type: ignore[misc]

if __name__ == "__main__":
    print(everything(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])))
