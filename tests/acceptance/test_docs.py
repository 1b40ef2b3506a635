"""Formulas, tables and numbers on the pages of `gyro explain` are those of the code;
links lead somewhere.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import kinematics
import numpy as np
import pytest
from biases import release_bias, tilt_bias
from documents import DOCUMENTS, PAGES, ROOT, blocks, cells
from gates import published
from rich.cells import cell_len
from typer.testing import CliRunner

import gyrodata
from gyrodata import fitting, physics
from gyrodata.base.diagnostics import explanations
from gyrodata.cli import app, documentation
from gyrodata.grading.criteria import KINDS
from gyrodata.grading.submissions.names import PLATFORMS
from gyrodata.judging import changes
from gyrodata.measurements import (
    DEFAULT_TRANSVERSE_RATIO,
    SOURCES,
    TRANSVERSE_U,
    measure,
)
from gyrodata.physics import motion
from gyrodata.physics.models import MODELS
from gyrodata.readings import read_log
from gyrodata.readings.headers import parse_header

TEXTS = {path.stem: path.read_text(encoding="utf-8") for path in PAGES}
SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"


# --- formulas are carried out as they are printed ---


class Vector(np.ndarray[Any, Any]):
    """× of the page is @ here."""

    def __matmul__(self, other: Any) -> Any:
        return np.cross(self, other).view(Vector)


def value_of(formula: str, names: dict[str, Any]) -> Any:
    """Work a formula of a page out."""
    for printed, meant in {"·": "*", "−": "-", "×": "@", "²": "**2"}.items():
        formula = formula.replace(printed, meant)
    formula = re.sub(r"√(\d)", r"sqrt(\1)", formula).replace("√", "sqrt")
    known = {
        "π": math.pi,
        "sin": np.sin,
        "cos": np.cos,
        "log": np.log,
        "sqrt": np.sqrt,
        "sgn": np.sign,
        **names,
    }
    # What has a letter of its own with the dot is the same letter to Python.
    return eval(
        formula,
        {},
        {unicodedata.normalize("NFKC", name): value for name, value in known.items()},
    )


def equations(page: str) -> dict[str, tuple[str, str]]:
    """Both sides of each equation of a page, by its number or by what it defines."""
    lines = "".join(
        block.body for block in blocks(TEXTS[page]) if block.kind == "text"
    ).splitlines()
    found = (re.fullmatch(r"(?:\((\d[abc]?)\)  )?(.+?) = (.+)", line) for line in lines)
    return {m[1] or m[2]: (m[2], m[3]) for m in found if m}


INERTIA, ACROSS = 4.44e-3, 6.5e-3


def any_state() -> dict[str, Any]:
    """A top that does everything at once, with names as the page has them."""
    theta, angle_rate, rate, spin = 1.1, 0.3, 0.7, 40.0
    turn = kinematics.frame_rotation(angle_rate, rate, theta)
    body = kinematics.body_rotation(angle_rate, rate, spin, theta)
    change = np.array([0.2, -0.4, 0.6])
    names = {
        "θ̇": angle_rate,
        "φ̇": rate,
        "ψ̇": spin,
        "sinθ": math.sin(theta),
        "cosθ": math.cos(theta),
    }
    names |= {f"e{i + 1}": np.eye(3)[i].view(Vector) for i in range(3)}
    names |= {f"ω{i + 1}": body[i] for i in range(3)} | {
        f"ω̇{i + 1}": change[i] for i in range(3)
    }
    names |= {
        "Ω": turn.view(Vector),
        "Ω3": turn[2],
        "I": ACROSS,
        "I_zz": INERTIA,
        "h": 0.15,
        "m": 0.06,
        "g": 9.803,
    }
    names["ω"] = body
    names["H"] = kinematics.angular_momentum(body, INERTIA, ACROSS).view(Vector)
    names["Ḣ"] = kinematics.momentum_change(body, change, turn, INERTIA, ACROSS)
    return names


def test_the_equations_of_rotation_are_those_of_the_code() -> None:
    state, listed = any_state(), equations("theory")
    for number in "12345":
        sides = [
            np.asarray(value_of(side, state), dtype=float) for side in listed[number]
        ]
        np.testing.assert_allclose(*sides, rtol=1e-14, atol=1e-16, err_msg=number)
    torque = physics.torque(state["m"], state["h"], state["g"]) * state["sinθ"]
    assert value_of(listed["6"][1], state).tolist() == pytest.approx([torque, 0.0, 0.0])
    left, right = zip(*(listed[number] for number in ("7a", "7b", "7c")), strict=True)
    assert [value_of(side, state) for side in left] == pytest.approx(
        state["Ḣ"].tolist(), rel=1e-14
    )
    assert [value_of(side, state) for side in right] == pytest.approx(
        [torque, 0.0, 0.0]
    )


@pytest.mark.parametrize("pitch", [0.0, 0.2, -0.5])
def test_steady_precession_and_its_roots_are_those_of_the_code(pitch: float) -> None:
    spin, listed = 400 * physics.RPM, equations("theory")
    load = float(physics.torque(0.06, 0.15, 9.803))
    top = load, spin, INERTIA, ACROSS, pitch
    rate = float(physics.precession_rate(*top))
    names = {
        "I": ACROSS,
        "I_zz": INERTIA,
        "h": 0.15,
        "m": 0.06,
        "g": 9.803,
        "M": load,
        "ψ̇": spin,
        "φ̇": rate,
    }
    names |= {"cosθ": math.sin(pitch), "sinθ": math.cos(pitch)}
    number = "8" if pitch else "9"
    assert value_of(listed[number][0], names) == pytest.approx(
        value_of(listed[number][1], names), rel=1e-14
    )
    names |= {name: value_of(listed[name][1], names) for name in ("a", "b")}
    assert value_of(listed["slow"][1], names) == pytest.approx(rate, rel=1e-14)
    if pitch:
        fast = physics.fast_precession_rate(*top)
        assert value_of(listed["fast"][1], names) == pytest.approx(fast, rel=1e-14)
    # The sag of a rod that is let go, and the condition that is fitted, with b = 0.2 s.
    sag = motion.nutation(
        motion.Top(inertia=INERTIA, transverse_inertia=ACROSS, torque=load), spin
    ).mean_sag
    assert value_of(listed["δ"][1], names) == pytest.approx(sag, rel=4.1 * sag**2)
    names |= {
        "M0": 0.0,
        "f": 1 / 3,
        "b": 0.2,
        "s": 1,
        "T": 2 * math.pi / 3 / rate + 0.2,
    }
    (condition,) = (
        sides for name, sides in equations("statistics").items() if "M0" in name
    )
    assert value_of(condition[0], names) == pytest.approx(
        value_of(condition[1], names), rel=1e-14
    )


# --- approximations ---


def marked(page: str, mark: str) -> list[list[str]]:
    """The rows of the table behind a mark, without its header."""
    table = TEXTS[page].split(f"<!-- {mark} -->\n")[1].split("\n\n")[0]
    return cells(table)[1:]


def benches() -> list[dict[str, float]]:
    """The two example labs, by the symbols of the page."""
    labs: list[dict[str, float]] = [{}, {}]
    for names, *values, _ in marked("approximations", "symbols"):
        for lab, told in zip(labs, values, strict=True):
            for name, formula in zip(
                re.findall("`(.*?)`", names), re.findall("`(.*?)`", told), strict=True
            ):
                lab[name] = float(value_of(formula, lab))
    return labs


PROOFS = re.findall(
    r"^\* (.*?): \[(test_\w+)\]\((.*?)\)$", TEXTS["approximations"], re.MULTILINE
)
SIZES = {
    name: (formula.strip("`"), shown)
    for name, formula, *shown in marked("approximations", "sizes")
}


def test_a_size_is_what_its_closed_form_gives() -> None:
    for formula, shown in SIZES.values():
        assert shown == [
            f"{100 * value_of(formula, lab):+.2g} %".replace("-", "−")
            for lab in benches()
        ], formula


def mean_spin(lab: dict[str, float]) -> float:
    return float(physics.harmonic_mean_spin(lab["start"], lab["end"]))


def total_spin(lab: dict[str, float]) -> float:
    return lab["ψ̇"] + lab["φ̇"] * math.sin(lab["pitch"])


BY_CODE: dict[str, Callable[[dict[str, float]], float]] = {
    "tilted rod, eq. (9) for eq. (8)": lambda lab: tilt_bias(
        lab["φ̇"], lab["ψ̇"], lab["pitch"], lab["I_zz"], lab["I"]
    ),
    "tilted rod, total spin taken for ψ̇": lambda lab: (
        tilt_bias(lab["φ̇"], total_spin(lab), lab["pitch"], lab["I_zz"], lab["I"])
        - (1 - lab["ψ̇"] / total_spin(lab))
    ),
    "nutation after letting go": lambda lab: release_bias(
        lab["M"], lab["ψ̇"], lab["I_zz"], lab["I"]
    ),
    "nutation, its phase at one click, at most": lambda lab: (
        physics.click_error(lab["ψ̇"], lab["I_zz"], lab["I"]) / lab["T"]
    ),
    "falling spin, plain mean of start and end": lambda lab: (
        2 * mean_spin(lab) / (lab["start"] + lab["end"]) - 1
    ),
    # At the midpoint a viscous fall has reached the geometric mean.
    "falling spin, midpoint for the mean": lambda lab: (
        mean_spin(lab) / math.sqrt(lab["start"] * lab["end"]) - 1
    ),
    "law by which the spin falls": lambda lab: physics.decay_law_doubt(
        lab["start"], lab["end"]
    ),
    "rod sighted 1° off at each end": lambda lab: (
        SOURCES["angle"].default.absolute / lab["f"]
    ),
    "ruler's zero off by 1 mm": lambda lab: (
        SOURCES["position_zero"].default.absolute / lab["x"]
    ),
    "weight 25.4 mm wide spins along": lambda lab: (
        physics.cylinder_inertia(lab["m"], 0.0254) / lab["I_zz"]
    ),
    "the Earth's rotation, at a pole": lambda lab: physics.EARTH_ROTATION / lab["φ̇"],
}


@pytest.mark.parametrize(("name", "found"), BY_CODE.items())
def test_a_closed_form_is_that_of_the_code(
    name: str, found: Callable[[dict[str, float]], float]
) -> None:
    for lab in benches():
        assert value_of(SIZES[name][0], lab) == pytest.approx(found(lab), rel=5e-3)


def effects() -> list[str]:
    return [*changes.EFFECTS, *(one.effect for one in MODELS if one.effect)]


def test_approximations_are_complete() -> None:
    assert set(BY_CODE) <= set(SIZES)
    assert [
        one
        for one in map(changes.effect_words, effects())
        if not any(name.startswith(one) for name in SIZES)
    ] == []
    assert [name for name, _, _ in PROOFS] == list(SIZES)
    for _, test, path in PROOFS:
        assert f"def {test}(" in (PAGES[0].parent / path).read_text(encoding="utf-8"), (
            test
        )
    assert all(
        lab["I"] == DEFAULT_TRANSVERSE_RATIO * lab["I_zz"] + lab["m"] * lab["x"] ** 2
        for lab in benches()
    )


# --- tables of what stands in the code ---


def test_tables_of_sources_criteria_and_platforms_are_true() -> None:
    told = [
        [f"`u_{key}`", kind.usual, kind.shared_by or "each run its own"]
        for key, kind in SOURCES.items()
    ]
    assert marked("statistics", "sources") == told
    kinds = [
        [
            f"`{name}`",
            kind.title,
            *(f"`{one}`" if one else "" for one in (kind.full, kind.zero)),
        ]
        for name, kind in KINDS.items()
    ]
    assert marked("instructors", "kinds") == kinds
    shown = {
        name: sample.strip("`") for name, sample in marked("instructors", "platforms")
    }
    assert shown == {name: platform.sample for name, platform in PLATFORMS.items()}


WRITTEN = "".join(path.read_text(encoding="utf-8") for path in DOCUMENTS)
LINES = sorted(set(re.findall(r"`# (?!key:)(\w+: [^`]+)`", WRITTEN)))
NEEDED = {"rod_length": "25 cm", "ball_diameter": "10.16 cm"}
"""What a line may need beside it."""


@pytest.mark.parametrize("line", LINES)
def test_a_log_may_say_what_a_page_says_of_it(line: str) -> None:
    key, _, value = line.partition(": ")
    header, row = (
        "mass [g],position [cm],spin [rpm],time [s],turns",
        "20.0,15.0,400,13.0,1/3",
    )
    lines = "".join(
        f"# {name}: {text}\n" for name, text in (NEEDED | {key: value}).items()
    )
    assert read_log(f"{lines}{header}\n{row}\n".encode()).ok


# --- every other number of the pages ---


def test_shares_of_a_page_are_those_of_fewer_labs() -> None:
    """`python tests/acceptance/gates --only published` compares them with all labs."""
    labs, *told = published.shares_of_the_page()
    few = 60
    for name, share in zip(published.FITS, told, strict=True):
        found = published.shares_of_the_sample(few)[name]
        spread = math.sqrt(share * (100 - share) / few)
        assert labs == 1000
        assert abs(found - share) < 3 * spread, name


def u_of_g(line: str) -> float:
    """Standard uncertainty of g [%] in a log with this line."""
    sources = measure(
        read_log(
            (
                f"{line}mass [g],position [cm],spin [rpm],time [s],turns\n"
                f"20.0,15.0,400,13.0,1\n"
            ).encode()
        )
    ).sources
    return 100 * next(
        float(source.relative[0]) for source in sources if source.name == "g"
    )


Claim = tuple[str, str, Callable[[], Any]]

CLAIMS: list[Claim] = [
    (
        "approximations",
        "changes I_zz by less than {} u is left out",
        lambda: changes.DROP_ONE,
    ),
    ("approximations", "stays below {} u together", lambda: changes.DROP_ALL),
    ("statistics", "gyrodata {}:", lambda: gyrodata.__version__),
    (
        "statistics",
        "one press of the button is {:.2f} s late",
        lambda: SOURCES["time_bias"].default.absolute * math.sqrt(2),
    ),
    (
        "statistics",
        "see to {:.0f}° that a rod is over a screw",
        lambda: 360 * SOURCES["angle"].default.absolute / math.sqrt(2),
    ),
    (
        "statistics",
        "With `# latitude:` it is {:.2f} %",
        lambda: u_of_g("# latitude: 45 deg\n"),
    ),
    (
        "statistics",
        "I = {} I_zz + m x² with {:.0f} %",
        lambda: (DEFAULT_TRANSVERSE_RATIO, 100 * TRANSVERSE_U),
    ),
    ("first-timer", "Below {}, look for the cause", lambda: fitting.UNLIKELY),
]
"""What a page says, with {} for what the code gives in its place."""


@pytest.mark.parametrize(
    ("page", "words", "found"), CLAIMS, ids=[words for _, words, _ in CLAIMS]
)
def test_a_number_is_what_the_code_gives(
    page: str, words: str, found: Callable[[], Any]
) -> None:
    values = found()
    filled = words.format(*(values if isinstance(values, (tuple, list)) else (values,)))
    # What links lead to is left out.
    flowing = " ".join(re.sub(r"\]\([^)]*\)", "]", TEXTS[page]).split())
    assert filled.replace("-", "−") in flowing.replace("-", "−")


def test_a_code_or_column_on_a_page_is_one_of_gyro() -> None:
    whole = "".join(TEXTS.values())
    assert set(re.findall(r"\bG\d{3}\b", whole)) <= set(explanations())
    assert {
        n
        for n in re.findall(r"`(\w+) \[[^\]]+\]`", whole)
        if re.sub(r"_\d$", "", n) not in parse_header(f"{n} [s]").roles
    } == set()


# --- links, and the terminal ---


def anchors(text: str) -> set[str]:
    """What GitHub calls the headings of a page."""
    heads = re.findall(
        r"^#+ (.*)$", re.sub(r"(?ms)^```.*?^```$", "", text), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.stem)
def test_a_link_leads_somewhere(path: Path) -> None:
    for name, anchor in re.findall(
        r"\]\(([^)#\n]*)#?([^)\n]*)\)", path.read_text("utf-8")
    ):
        target = path.parent / name if name else path
        assert target.exists(), name
        assert not anchor or anchor in anchors(target.read_text(encoding="utf-8")), (
            anchor
        )


@pytest.mark.parametrize("page", documentation.PAGES)
@pytest.mark.parametrize("width", [80, 250])
def test_a_terminal_shows_a_page_whole(
    page: str, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    shown = re.sub(
        r"\x1b\[[\d;]*m",
        "",
        documentation.for_terminal(documentation.page_text(page), width),
    )
    assert max(map(cell_len, shown.splitlines())) <= min(width, documentation.WIDEST)
    # Nothing is cut, and no mark of Markdown or of a test is left.
    assert shown.count("…") == documentation.page_text(page).count("…")
    assert re.findall(r"\*\*|```|\|--|<!--|\]\(", shown) == []
    # Rich before 15 puts a frame around it.
    assert shown.lstrip("\n ┏━┓").partition("\n")[0].strip(
        "┃ "
    ) == documentation.page_title(page)


def test_all_pages_are_listed_and_a_pipe_gets_markdown() -> None:
    shown = CliRunner().invoke(app, ["explain"]).stdout
    for page in TEXTS:
        assert f"gyro explain {page} " in shown
        assert CliRunner().invoke(app, ["explain", page]).stdout == TEXTS[page]
    both = CliRunner().invoke(app, ["explain", "THEORY", "G454"]).stdout
    assert both.startswith(TEXTS["theory"])
    assert "\nG454, warning: " in both
