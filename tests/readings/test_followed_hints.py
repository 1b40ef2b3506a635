"""A log in an unusual form, what gyro says of it, and what a student who does just that
gets: the truth.

What a hint prints to copy is copied from the hint.
"""

from __future__ import annotations

import datetime
import io
import math
import re
from collections.abc import Callable
from typing import Any

import openpyxl
import pytest
from msgspec.structs import asdict
from simulated_labs import analyze_briefly, kinds_of_doubts

import gyrodata
from gyrodata import LogError

TRUTH = 4.4e-3
MASSES, SPINS = (20.1, 40.3, 60.2), (206, 394, 604)
RUNS = [
    (
        mass,
        spin,
        2 * math.pi * TRUTH * spin * math.pi / 30 / (mass * 1e-3 * 9.80665 * 0.148),
    )
    for mass in MASSES
    for spin in SPINS
]
"""Mass [g], spin [rpm] and the time of one turn [s]; the weight hangs at 14.8 cm."""
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns"


def log(head: str, row: Callable[[float, int, float], str]) -> str:
    return "\n".join([head, *(row(*run) for run in RUNS)]) + "\n"


def plain(mass: float, spin: int, time: float) -> str:
    return f"{mass},14.8,{spin},{time:.2f},1"


GOOD = log(HEAD, plain)


def analyze(
    text: str | bytes, **given: Any
) -> tuple[dict[str, Any] | None, list[dict[str, Any]]]:
    """Give the result and what is said of a log."""
    try:
        answer = analyze_briefly(text, **given)
    except LogError as error:
        return None, [asdict(one) for one in error.diagnostics]
    result = {"inertia": asdict(answer.inertia), "runs": answer.run_table}
    return result, [asdict(one) for one in answer.diagnostics]


def hint_of(text: str, code: str) -> str:
    """Give what a log of no answer, or of a doubtful one, is told to do."""
    return next(one["hint"] for one in analyze(text)[1] if one["code"] == code)


def found(pattern: str, text: str) -> str:
    """Give what a hint says to type."""
    match = re.search(pattern, text)
    assert match, text
    return match[1]


def gives_truth(text: str, **given: Any) -> bool:
    result, said = analyze(text, **given)
    assert result, said
    return abs(result["inertia"]["value"] / TRUTH - 1) < 0.02


@pytest.mark.slow
def test_sigma_t_is_the_uncertainty_of_t() -> None:
    unclear = log(
        "m (g),x (cm),f (rpm),T (s),σ_T (s),turns",
        lambda m, s, t: f"{m},14.8,{s},{t:.2f},0.2,1",
    )
    result, said = analyze(unclear)
    assert (result, said[0]["code"]) == (None, "G207")
    text = unclear.replace("T (s),σ_T (s)", "time [s],σ_t (s)")
    assert gives_truth(text)
    results = (
        analyze(text.replace(",0.2,1\n", f",{stated},1\n"))[0] for stated in (0.2, 2)
    )
    u = [result["inertia"]["u"] for result in results if result]
    assert u[1] > 1.4 * u[0]


def test_blanks_between_the_columns_under_a_title_with_a_comma() -> None:
    title = "Mass {} g at 14.8 cm, time for 1/3 turn\nspin rpm    time s\n{}"
    parts = (
        title.format(
            m, "".join(f"{s}    {t / 3:.2f}\n" for mass, s, t in RUNS if mass == m)
        )
        for m in MASSES
    )
    assert gives_truth("\n".join(parts))


def test_a_radius_beside_the_arm() -> None:
    text = log(
        "m (g),r (cm),d (cm),f (rpm),time (s),turns",
        lambda m, s, t: f"{m},5.08,14.8,{s},{t:.2f},1",
    )
    ways = re.findall('--map position="([^"]+)"', hint_of(text, "G237"))
    assert sorted(ways) == ["d (cm)", "r (cm)"]
    assert gives_truth(text, mapping={"position": "d (cm)"})


# Notes that gyro does not apply
# -----------------------------------------------------------------------------------

TWICE = log(HEAD, lambda m, s, t: plain(m, 2 * s, t))


def notes_in(text: str) -> list[str]:
    return [one["message"] for one in analyze(text)[1] if one["code"] == "G240"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "note",
    [
        "2 reflective strips, twice the real rpm!!",
        "# tachometer shows double the speed",
    ],
)
def test_a_note_about_the_spin_is_followed(note: str) -> None:
    result, said = analyze(f"{TWICE}{note}\n")
    told = next(one for one in said if one["code"] == "G240")
    assert (told["severity"], told["line"]) == ("warning", 11)
    assert note.strip("# ") in told["message"]
    assert result
    assert result["inertia"]["value"] == pytest.approx(TRUTH / 2, rel=0.02)
    done = (
        f"# corrected: {note.strip('# ')}" if note[0] == "#" else f"corrected: {note}"
    )
    for corrected in (GOOD, f"{GOOD}{done}\n"):
        assert gives_truth(corrected)
        assert notes_in(corrected) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("note", "role"),
    [
        ("hanger of 5 g not included in the masses", "mass"),
        ("time minus 0.2 s reaction", "time"),
        ("position wrong, see sketch", "position"),
        ("Halter nicht enthalten", "readings"),
        ("spin not corrected", "spin"),
        ("time for half a revolution", "number of turns"),
        ("we counted half turns", "number of turns"),
        ("times are already divided by the number of turns", "time"),
        ("the masses do not include the hanger", "mass"),
    ],
)
def test_a_note_is_quoted_with_its_quantity(note: str, role: str) -> None:
    for text in (f"# {note}\n{GOOD}", f"{GOOD}{note}\n"):
        (message,) = notes_in(text)
        assert note in message
        assert f"may change the {role}" in message


@pytest.mark.slow
@pytest.mark.parametrize(
    "note",
    [
        "rpm already halved",
    ],
)
def test_usual_words_of_this_lab_raise_no_warning(note: str) -> None:
    assert notes_in(f"# {note}\n{GOOD}{note}\n") == []
    assert notes_in(log(f"{HEAD},note", lambda *run: f"{plain(*run)},{note}")) == []


# Cells and names that are missing or wrong
# ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "advice", ["write the spin that was read", "put # before the line"]
)
def test_run_with_a_spin_of_zero_is_corrected_or_left_out(advice: str) -> None:
    row = plain(*RUNS[1])
    text = GOOD.replace(row, row.replace(",394,", ",0,"))
    assert advice in hint_of(text, "G215")
    assert gives_truth(
        GOOD if advice.startswith("write") else GOOD.replace(row, f"# {row}")
    )


@pytest.mark.slow
def test_decimal_sign_that_is_missing_in_a_column_is_written_as_the_hint_says() -> None:
    text = GOOD.replace(",14.8,", ",148,")
    assert "Is a decimal sign missing" in hint_of(text, "G440")
    assert gives_truth(text.replace(",148,", ",14.8,"))
    assert gives_truth(
        text.replace(
            "position [cm]",
            found('write the header as "([^"]+)"', hint_of(text, "G440")),
        )
    )


def test_times_that_a_spreadsheet_took_for_hours_are_written_in_seconds() -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(HEAD.split(","))
    for mass, spin, time in RUNS:
        hours, minutes = divmod(round(100 * time / 3), 100)  # 6.50 s, typed as 6:50
        sheet.append([mass, 14.8, spin, datetime.time(hours, minutes % 60), 1 / 3])
    data = io.BytesIO()
    book.save(data)
    result, said = analyze(data.getvalue())
    assert result is None
    assert [
        one for one in said if "write every time of this column in s" in one["hint"]
    ]
    assert gives_truth(
        log(HEAD, lambda mass, spin, time: f"{mass},14.8,{spin},{time / 3:.2f},1/3")
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "typed"),
    [("spin [rpm]", "spim"), ("mass [g]", "wieght"), ("turns", "trns")],
)
def test_misspelt_name_is_replaced_as_the_hint_says(name: str, typed: str) -> None:
    text = GOOD.replace(name, typed, 1)
    hint = hint_of(text, "G301")
    assert f'if "{typed}" ' in hint
    assert gives_truth(text.replace(typed, found('write "([^"]+)" above', hint), 1))


# Texts that contradict the table, and cells of another script
# -------------------------------------------------------


def doubts_of(text: str) -> list[str]:
    return [doubt.kind for doubt in gyrodata.analyze(text).doubts]


@pytest.mark.slow
@pytest.mark.parametrize(
    "note",
    [
        "weight always at x = 10.0 cm from centre",
        "moved the weight 4 cm outwards",
        "x bis Außenkante Gewicht gemessen",
        "flyttade vikten utåt 4 cm",
    ],
)
def test_answer_is_not_safe_to_quote_if_a_text_gives_another_position(
    note: str,
) -> None:
    for text in (f"{note}\n{GOOD}", f"{GOOD}\n{note}\n"):
        assert kinds_of_doubts(analyze_briefly(text)) == ["note"]
        corrected = analyze_briefly(text.replace(note, f"corrected: {note}"))
        assert kinds_of_doubts(corrected) == []


@pytest.mark.slow
def test_position_that_a_text_repeats_is_not_a_contradiction() -> None:
    assert doubts_of(f"{GOOD}\nweight always at x = 148 mm from centre\n") == []


@pytest.mark.slow
def test_ball_of_a_metre_is_an_error_with_what_to_type() -> None:
    surface = "# position_from: surface\n" + GOOD.replace(",14.8,", ",9.72,")
    hint = hint_of(f"# ball_diameter: 1016 mm\n{surface}", "G306")
    example = found('"(# ball_diameter: [^"]+)"', hint)
    assert doubts_of(f"{example}\n{surface}") == []


@pytest.mark.parametrize(
    ("unit", "pattern"), [("ms", "write ([0-9]+) or"), ("s", "or ([0-9.]+) ")]
)
def test_time_with_a_mark_that_may_separate_thousands_is_written_as_the_hint_says(
    unit: str, pattern: str
) -> None:
    head = HEAD.replace(",", ";").replace("time [s]", f"time [{unit}]")
    text = log(
        head, lambda m, s, t: f"{m:.1f};14.8;{s};".replace(".", ",") + f"{t:.3f};1"
    )
    result, said = analyze(text)
    assert result is None
    hints = [one["hint"] for one in said if one["code"] == "G203"]
    for time, hint in zip([f"{time:.3f}" for *_, time in RUNS], hints, strict=True):
        text = text.replace(f";{time};", f";{found(pattern, hint)};")
    assert gives_truth(text)


def test_points_typed_as_colons_are_asked_about() -> None:
    head = "mass (g);r (cm);rpm;turns;time (s)"
    text = log(
        head, lambda m, s, t: f"{m};14.8;{s};1/3;" + f"{t / 3:05.2f}".replace(".", ":")
    )
    assert "if the last colon is a point, write" in hint_of(text, "G233")
    assert gives_truth(re.sub(r"(\d\d):(\d\d)$", r"\1.\2", text, flags=re.M))


def test_digit_of_another_alphabet_is_corrected_as_the_hint_says() -> None:
    hint = hint_of(GOOD.replace("40.3,", "40.З,", 1), "G203")
    assert "did you mean 40.3?" in hint


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["x/cm from centre", "r / cm from the centre", "distance / cm (from centre)"],
)
def test_words_may_follow_the_unit_of_a_header(name: str) -> None:
    assert gives_truth(GOOD.replace("position [cm]", name))


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        "tempo di 1 giro (precessione); posizione dal centro",
    ],
)
def test_line_of_names_above_the_header_states_the_turns(line: str) -> None:
    assert gives_truth(
        log(
            f"{line}\nmass (g);x (cm);rpm;time (s)",
            lambda m, s, t: f"{m};14.8;{s};{t:.2f}",
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        (
            "la distance d est mesurée entre la surface de la bille et le milieu de la "
            "masse, Ø bille 101.6 mm"
        ),
        "Etäisyys d on mitattu pallon pinnasta punnuksen keskelle. Pallon halkaisija on 101.6 mm.",
        "x = Abstand zwischen Kugeloberfläche und Gewichtsmitte, Kugeldurchmesser 101.6 mm",
        "r is the distance between the surface of the ball and the weight; ball diameter 101.6 mm",
    ],
)
def test_distance_between_the_surface_and_the_weight_is_understood(line: str) -> None:
    runs = log(
        "mass (g);d (cm);rpm;turns;time (s)", lambda m, s, t: f"{m};9.72;{s};1;{t:.2f}"
    )
    assert gives_truth(f"# ball_diameter: 101.6 mm\n{line}\n\n{runs}")


def test_position_from_the_centre_that_a_later_line_denies_is_asked_about() -> None:
    line = (
        "Correction: r is from the surface of the ball to the weight, not from its "
        "centre. Ball diameter 101.6 mm."
    )
    text = log(
        "mass (g);r from centre (cm);rpm;turns;time (s)",
        lambda m, s, t: f"{m};9.72;{s};1;{t:.2f}",
    )
    assert hint_of(f"{text}\n{line}\n", "G340")


@pytest.mark.slow
@pytest.mark.parametrize(
    "note",
    [
        (
            "N: we counted one each time the rod lay along the edge, no matter which "
            "of its ends pointed to the window"
        ),
        "Tachometer compared with the strobe: true rpm = 1.074 x display",
        "calibration factor of the tachometer: 1.074",
    ],
)
def test_note_about_a_factor_makes_an_answer_unsafe(note: str) -> None:
    assert doubts_of(f"{GOOD}\n{note}\n") == ["note"]


@pytest.mark.slow
def test_angles_in_a_column_of_turns_are_asked_about_and_mended_in_both_ways() -> None:
    text = log(HEAD, lambda m, s, t: f"{m},14.8,{s},{t / 3:.2f},120")
    hint = hint_of(text, "G215")
    assert gives_truth(
        text.replace(",120\n", f",{found('write ([0-9/]+) in its cell', hint)}\n")
    )
    header = found('or "([^"]+)" above a column of degrees', hint)
    assert gives_truth(text.replace("turns\n", f"{header}\n"))
    assert gives_truth(text.replace("turns\n", "turns [deg]\n"))


def test_name_without_a_unit_that_is_left_over_is_proposed() -> None:
    hint = hint_of(GOOD.replace("spin [rpm]", "вращение"), "G301")
    assert gives_truth(
        GOOD.replace("spin [rpm]", found('if "вращение" is .*, write "([^"]+)"', hint))
    )


def test_names_that_differ_in_their_case_are_two_columns_of_one_run() -> None:
    head = "m (g),x (cm),spin (rpm),turns,t (s),Omega (rad/s),omega (rad/s)"
    rates = [(2 * math.pi / t, s * math.pi / 30) for _, s, t in RUNS]
    rows = [
        f"{m},14.8,{s},1,{t:.2f},{slow:.4f},{fast:.2f}"
        for (m, s, t), (slow, fast) in zip(RUNS, rates, strict=True)
    ]
    assert gives_truth("\n".join([head, *rows]) + "\n")


def test_names_of_weights_are_replaced_as_the_question_says() -> None:
    names = {20.1: "A", 40.3: "B", 60.2: "C"}
    rows = "".join(f"{names[m]};14.8;{s};{t:.2f};1\n" for m, s, t in RUNS)
    header = "mass [g];position [cm];spin [rpm];time [s];turns\n"
    with pytest.raises(LogError, match="is the name of a weight"):
        gyrodata.analyze(header + rows)
    masses = {name: str(mass) for mass, name in names.items()}
    typed = [masses[row[0]] + row[1:] for row in rows.splitlines()]
    assert gives_truth(header + "\n".join(typed) + "\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    "sentence",
    [
        "The distance is measured from the surface of the ball",
        "Abstände sind ab der Oberfläche der Kugel gemessen",
        "La distance est mesurée depuis la surface de la bille",
        "La distancia se mide desde la superficie de la bola",
        "La distanza è misurata dalla superficie della sfera",
        "A distância é medida a partir da superfície da esfera",
        "De afstand is gemeten vanaf het oppervlak van de bol",
        "Avståndet är mätt från kulans yta",
        "Afstanden er målt fra kuglens overflade",
        "Avstanden er målt fra overflaten av kula",
        "odległości od powierzchni kuli",
        "vzdálenosti od povrchu koule",
        "A távolságot a golyó felszínétől mértük",
        "Etäisyys mitattiin pallon pinnasta",
        "Uzaklık bilyenin yüzeyinden ölçüldü",
        "расстояния от поверхности шара",
        "Відстань виміряна від поверхні кулі",
        "Η απόσταση μετρήθηκε από την επιφάνεια της σφαίρας",
        "距離は球の表面から測った",
        "距离从球的表面量起",
        "거리는 공의 표면에서 잰 것이다",
        "Udaljenost je mjerena od površine kugle",
    ],
)
def test_positions_from_the_surface_in_a_sentence_lack_the_diameter(
    sentence: str,
) -> None:
    text = log(
        "m (g);d (cm);rpm;turns;time (s)", lambda m, s, t: f"{m};9.72;{s};1;{t:.2f}"
    )
    assert "ball_diameter" in hint_of(f"{sentence}.\n\n{text}", "G340")
    assert gives_truth(f"# ball_diameter: 101.6 mm\n{sentence}.\n\n{text}")


def test_name_that_is_too_many_in_the_header_is_deleted_as_the_hint_says() -> None:
    text = log(
        "run,mass (g),x (cm),rpm,turns,time (s)",
        lambda m, s, t: f"{m},14.8,{s},1,{t:.2f}",
    )
    assert "one name more than the rows have cells, delete that name" in hint_of(
        text, "G202"
    )
    assert gives_truth(text.replace("run,", ""))


def test_number_that_is_split_at_its_comma_is_written_as_the_hint_says() -> None:
    row = plain(*RUNS[4])
    text = GOOD.replace(
        row, "40.3,14.8,394," + f"{RUNS[4][2]:.2f}".replace(".", ",") + ",1"
    )
    assert "write a point (13.06 for 13,06) or quotes" in hint_of(text, "G209")
    assert gives_truth(GOOD)
    quoted = f'40.3,14.8,394,"{RUNS[4][2]:.2f}",1'.replace(
        f"{RUNS[4][2]:.2f}", f"{RUNS[4][2]:.2f}".replace(".", ",")
    )
    assert gives_truth(GOOD.replace(row, quoted))


def test_times_of_a_running_clock_keep_their_last_column_as_the_hint_says() -> None:
    text = log(
        "mass (g);r (cm);rpm;t1 (s);t2 (s);t3 (s)",
        lambda m, s, t: f"{m};14.8;{s};{t:.2f};{2 * t:.2f};{3 * t:.2f}",
    )
    turns = found(
        '"(# turns: [0-9]+)" if the first time covers one turn', hint_of(text, "G303")
    )
    kept = log(
        "mass (g);r (cm);rpm;t3 (s)", lambda m, s, t: f"{m};14.8;{s};{3 * t:.2f}"
    )
    assert gives_truth(f"{turns}\n{kept}")


def test_period_of_the_ball_is_named_as_the_hint_says() -> None:
    text = log(
        "mass [g],r [cm],period (s),it took (sec),turns",
        lambda m, s, t: f"{m},14.8,{60 / s:.4f},{t / 3:.2f},1/3",
    )
    name = found('--map spin_period="([^"]+)"', hint_of(text, "G230"))
    assert gives_truth(text, mapping={"spin_period": name})
