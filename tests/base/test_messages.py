"""Messages that the tests of their rooms do not raise: each is printed with its values."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from grading.classes import find_submissions
from places import SAMPLES
from typer.testing import CliRunner

import gyrodata
from gyrodata.analysis import check_log
from gyrodata.base.errors import Diagnostic, GyroError, InputError
from gyrodata.cli import app
from gyrodata.grading.rubric import read_rubric
from gyrodata.trials.simulation import Design, Truth, simulate

HEADER = "mass [g],position [cm],spin [rpm],time [s],turns"
WITHOUT_TURNS = "mass [g],position [cm],spin [rpm]"
IMPOSSIBLE = f"{HEADER}\n20,15,206,20.4,1\n20,15,407,0.0404,1\n40,15,405,2010,1\n"


def found_in(log: str, **options: bool) -> tuple[Diagnostic, ...]:
    try:
        readings = gyrodata.read_log(log.encode(), name="log.csv")
        return (*readings.diagnostics, *check_log(readings, **options)[1])
    except GyroError as error:
        return error.diagnostics


def runs_off_at(wrong: str, column: str, loads: tuple[float, ...]) -> str:
    """Write runs of several loads; the times of one load are 15 % too long."""
    rows = [
        (f"{load:g}", spin, spin * 0.0990 * loads[0] / load)
        for load in loads
        for spin in (206, 406, 603)
    ]
    lines = [
        f"{load},{spin},{time * (1.15 if load == wrong else 1):.2f},1"
        for load, spin, time in rows
    ]
    return "\n".join([f"{column},spin [rpm],time [s],turns", *lines, ""])


LOGS = {
    "numbered spins": (
        (
            "mass [g],position [cm],spin 1 [rpm],spin 2 [rpm],time [s],turns\n"
            "20,15,406,400,13.06,1/3\n"
        ),
        '"spin 1 [rpm]" and "spin 2 [rpm]" may both be spins',
    ),
    "several runs in a row": (
        (
            "position [cm],turns,mass [g],spin [rpm],time [s],mass [g],spin [rpm],time [s]\n"
            "15,1/3,20,406,13.06,40,406,6.6\n15,1/3,20,206,6.7,40,206,3.3\n"
        ),
        'two columns are called "mass [g]"',
    ),
    "an unknown mass": (
        f"{HEADER}\n?,15,406,13.06,1/3\n20,15,406,13.06,1/3\n",
        'the mass of this run is not known: the cell contains "?"',
    ),
    "two spins": (
        (
            "mass [g],position [cm],spin [rpm],spin [rpm],time [s],turns\n"
            "20,15,406,380,13.06,1/3\n"
        ),
        'two columns are called "spin [rpm]"',
    ),
    "two times": (
        f"{WITHOUT_TURNS},time [s],time [s],turns\n20,15,406,13.06,13.1,1/3\n",
        'two columns are called "time [s]"',
    ),
    "turns in header and column": (
        f"{WITHOUT_TURNS},time for 1/3 turn [s],turns\n20,15,406,13.06,1\n",
        '"time for 1/3 turn [s]" covers 1/3 turns, and "turns" says 1',
    ),
    "no turns": (
        f"{WITHOUT_TURNS},time for 0 turns [s]\n20,15,406,13.06\n",
        "0 is not a number of turns: it ",
    ),
    "no torque": (
        f"{HEADER}\n0,,400,120,0\n",
        "no run has a torque, and the rod never moved",
    ),
    "a large weight": (
        f"{HEADER}\n500,40,906,0.6,1\n500,40,1200,0.8,1\n250,40,1200,1.6,1\n",
        "so the weight dominates the ball",
    ),
    "a wrong force": (
        runs_off_at("0.589", "force [N],position [cm]", (0.196, 0.392, 0.589, 0.785))
        .replace(",206,", ",15,206,")
        .replace(",406,", ",15,406,")
        .replace(",603,", ",15,603,"),
        "would agree with the others if its force were ",
    ),
    "a wrong torque": (
        runs_off_at("88.2", "torque [mN*m]", (29.4, 58.8, 88.2, 117.6)),
        "would agree with the others if its torque were ",
    ),
    "a wrong transverse moment of inertia": (
        f"# transverse_inertia: 50 kg m^2\n{IMPOSSIBLE}",
        "no single I_zz fits these runs: ",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(("log", "said"), LOGS.values(), ids=LOGS)
def test_a_seldom_log_gets_its_message(log: str, said: str) -> None:
    assert any(said in one.message for one in found_in(log)), found_in(log)


@pytest.mark.slow
def test_outliers_after_the_first_ones_are_counted() -> None:
    rows = [
        f"{mass}.00,15.00,{spin},{spin * 1.98 / mass * (1.5 if late else 1):.2f},1"
        for mass in (20, 40, 60)
        for spin in range(300, 600)
        for late in [spin % 8 == 0]
    ]
    found = found_in("\n".join([HEADER, *rows, ""]))
    assert any("more suspected outliers" in one.message for one in found)


def test_the_hint_names_the_option_or_value_that_prevents_an_answer() -> None:
    log = f"# transverse_inertia: 50 kg m^2\n{IMPOSSIBLE}"
    for kept, hint in (
        (True, "omit --keep-flagged"),
        (False, "transverse_inertia is 50"),
    ):
        with pytest.raises(GyroError) as caught:
            gyrodata.analyze(log.encode(), keep_flagged=kept)
        assert caught.value.diagnostics[-1].hint.startswith(hint)


COMMANDS = [
    (
        "template --weights 0g --spins 200rpm",
        'G622: --weights "0 g" is impossible',
    ),
    ("check log.csv log.csv --format json", "G602: --format json is for one log"),
    ("predict tip --force 0.5kg --spin 400rpm", "G621: --force: "),
    ("simulate --imbalance '1e9 N m'", "the value must be from 1e-12 to 1e+06 N*m"),
    (
        "predict precession --transverse '1e-9 kg m^2' --spin 400rpm",
        "G622: --transverse 1e-09 kg*m^2 is less than I_zz/2",
    ),
    ("check --fix notes.txt", "G639: notes-fixed.csv is not written"),
    ("grade empty", 'G705: "empty" contains no files'),
    ("grade class.rar", 'G701: "class.rar" is neither a folder nor a zip'),
]


@pytest.mark.parametrize(("command", "said"), COMMANDS)
def test_a_seldom_mistake_of_a_command_gets_its_message(
    command: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    log = (SAMPLES / "air_gyroscope.csv").read_text("utf-8")
    for folder in ("empty", "class"):
        Path(folder).mkdir()
    for name, text in (
        ("log.csv", log),
        ("class/log.csv", log),
        ("notes.txt", "hello,world\n"),
        ("class.rar", "Rar!"),
    ):
        Path(name).write_text(text, "utf-8")
    done = CliRunner().invoke(app, shlex.split(command))
    assert done.exit_code
    assert said in done.output


def test_an_unknown_platform_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='there is no --lms "moodel"'):
        find_submissions(tmp_path, lms="moodel")


RUBRIC = (
    'schema = 1\npoints = 2\n[[criterion]]\nid = "log"\ncheck = "log"\npoints = 2\n'
)
RUBRICS = [
    ('full = "warnings in 3..1"\n', '"warnings in 3..1" is not a condition'),
    ('full = "d <= 1"\n', '"d" cannot be used in a criterion with check = "log"'),
    (
        'full = "warnings outside 1..2"\n',
        '"warnings outside 1..2" gives all points to values that are far out',
    ),
    ('slip = "10 %"\n', '"slip" is not known in a criterion with check = "log"'),
    (
        "[late]\nexception=[{student='a',waive=true},{student='A',extra='2 h'}]\n",
        'two late exceptions are for "a"',
    ),
    (
        "[late]\n[[late.exception]]\nstudent = 'a'\n",
        "exactly one of due, extra and waive",
    ),
    (
        (
            "[late]\n[[late.tier]]\nuntil = '2 days'\ndeduct = 1\n"
            "[[late.tier]]\nuntil = '1 day'\ndeduct = 2\n"
        ),
        "a tier is not later than the one before it",
    ),
    ("[bench]\nu_time = '1 kg'\n", '"kg" is not a unit of a time'),
    ("[bench]\nu_tme = '1 s'\n", '"u_tme" is not known in [bench]'),
]


@pytest.mark.parametrize(("end", "said"), RUBRICS)
def test_a_seldom_mistake_of_a_rubric_gets_its_message(end: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        read_rubric((RUBRIC + end).encode())
    (told,) = caught.value.diagnostics
    assert said in told.message
    assert told.hint
    assert (told.line or 0) > 5


LABS = [
    (Truth(timing_bias=1e9), Design(), "run 1: time is too large for a time"),
    (Truth(), Design(repeats=0), "this design has no run"),
    (
        Truth(decay_time=600.0, motion="released"),
        Design(),
        "a released rod is simulated with a constant spin",
    ),
    (Truth(timing_bias=-1000.0), Design(), "run 1: time must be above zero"),
    (
        Truth(),
        Design(masses=(1e-7,), turns=(1000.0,)),
        "run 1: time is too large for a time",
    ),
]


@pytest.mark.parametrize(("truth", "design", "said"), LABS)
def test_a_lab_that_cannot_be_simulated_gets_its_message(
    truth: Truth, design: Design, said: str
) -> None:
    with pytest.raises(InputError) as caught:
        simulate(truth, design)
    assert said in str(caught.value)


def test_an_unknown_motion_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="did you mean 'released'"):
        simulate(Truth(motion="relased"), Design())  # type: ignore[arg-type]
