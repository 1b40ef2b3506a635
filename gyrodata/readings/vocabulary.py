"""The words and symbols that students write above their columns, by role, in the languages of the lab."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from gyrodata.units import ROLE_KINDS, fold_letters

CONSTANTS = ("g", "ball_diameter", "ball_mass")
"""Constants of a log that are no role."""

ROLES = tuple(role for role in ROLE_KINDS if role not in CONSTANTS)

SHARED_UNCERTAINTIES = (
    "u_time_bias",
    "u_spin_scale",
    "u_mass_scale",
    "u_position_zero",
    "u_imbalance",
    "u_g",
    "u_ball_mass",
    "u_ball_diameter",
)
UNCERTAINTIES = (
    *(f"u_{role}" for role in ROLES if ROLE_KINDS[role] not in ("sign", "text")),
    *SHARED_UNCERTAINTIES,
)
BALANCE = ("balance_tilt", "balance_drift")
MOTION = "motion"
MOTIONS = ("steady", "released")
"""How the rod was started: led along until it precesses steadily, or let go from rest."""
KEYS = (*ROLES, *CONSTANTS, *UNCERTAINTIES, *BALANCE, MOTION)
"""Everything that ``# key: value``, ``--set`` and ``--config`` can give."""

# Symbols: here case matters ("m" is no "M", "t" no "T"). Roles that a unit tells apart may share one.
_SYMBOLS = {
    "m": "mass",
    "M": "torque mass",
    "D": "torque",
    "Γ": "torque",
    "F": "force",
    "x": "position",
    "X": "position",
    "r": "position",
    "R": "position",
    "l": "position",
    "L": "position",
    "d": "position",
    "ω": "spin",
    "w": "spin",
    "ν": "spin",
    "f": "spin",
    "ψdot": "spin",
    "Ω": "precession_rate",
    "Ωp": "precession_rate",
    "ΩP": "precession_rate",
    "ωp": "precession_rate",
    "ωP": "precession_rate",
    "wp": "precession_rate",
    "φdot": "precession_rate",
    "ωs": "spin",
    "ωS": "spin",
    "n": "turns spin",
    "N": "turns spin",
    "Noб": "turns",
    "Np": "turns",
    "NP": "turns",
    "t": "time",
    "T": "time precession_period",
    "tP": "time precession_period",
    "tp": "time precession_period",
    # So many periods: the whole time.
    "NT": "time",
    "nT": "time",
    "Tp": "precession_period",
    "TP": "precession_period",
    "TΩ": "precession_period",
    "τ": "precession_period torque",
    "Ts": "spin_period",
    "TG": "spin_period",
    "Tspin": "spin_period",
    "tR": "spin_period",
    "TR": "spin_period",
    "TGi": "spin_period_start",
    "TGf": "spin_period_end",
    "φ": "angle",
    "I": "inertia",
    "J": "inertia",
    "Izz": "inertia",
    "Iz": "inertia",
    "I0": "inertia",
    "I3": "inertia",
    "Jz": "inertia",
    # Some number the states before and after, some the two rotations.
    "ω0": "spin_start spin",
    "w0": "spin_start spin",
    "n0": "spin_start spin",
    "f0": "spin_start spin",
    "ω1": "spin_start spin_end precession_rate",
    "w1": "spin_start spin_end precession_rate",
    "n1": "spin_start spin_end",
    "f1": "spin_start spin_end",
    "ω2": "spin_end precession_rate",
    "w2": "spin_end precession_rate",
    "n2": "spin_end",
    "f2": "spin_end",
    "№": "run",
    "#": "run",
    "No": "run",
    "Nr": "run",
    "nr": "run",
}

# Words: here nothing but the letters matters. Commas separate; English first, then de, fr, ru, es, pl, pt, ko.
_WORDS = {
    "mass": (
        "mass, weight, load, added mass, added weight, add-on mass, additional mass, hanging mass, masses, mass "
        "added, Masse, Zusatzmasse, Gewicht, Zusatzgewicht, Auflagemasse, masse ajoutée, masse additionnelle, "
        "surcharge, масса, масса груза, груз, масса грузика, m груза, masa, masa añadida, peso, masa ciężarka, "
        "obciążenie, ciężarek, masa obciążnika, massa, massa adicionada, 질량, 추의 질량"
    ),
    "position": (
        "position, arm, lever arm, lever, radius, distance, moment arm, arm length, location, offset, distance from "
        "centre, distance from center, distance from pivot, Position, Abstand, Hebelarm, Hebel, Arm, Radius, "
        "Hebelarmlänge, Entfernung, bras, bras de levier, rayon, plече, плечо, расстояние, длина плеча, радиус, "
        "положение, brazo, brazo de palanca, distancia, radio, posición, ramię, ramię siły, odległość, położenie, "
        "posição, distância, raio, braço, braço de alavanca, 반경, 반지름, 거리, 팔 길이"
    ),
    "torque": (
        "torque, moment, moment of force, applied torque, couple, moment du couple, Drehmoment, Moment, moment de "
        "force, момент, момент силы, момент сил, вращающий момент, par, momento, momento de fuerza, torca, moment "
        "siły, torque aplicado, 토크, 돌림힘"
    ),
    "force": "force, applied force, Kraft, сила, fuerza, siła, força, 힘",
    "spin": (
        "spin, spin speed, spin rate, spin frequency, rotor speed, rotation speed, rotational speed, rotation rate, "
        "speed, tachometer, tacho, tachometer reading, wheel speed, disc speed, disk speed, ball speed, gyro speed, "
        "psidot, psi dot, omega, angular speed of spin, spin angular velocity, Drehzahl, Drehfrequenz, "
        "Eigendrehzahl, Eigenrotation, Kreiseldrehzahl, Rotationsfrequenz, vitesse de rotation, vitesse de rotation "
        "propre, rotation propre, fréquence de rotation, régime, обороты ротора, частота вращения, скорость "
        "вращения, частота ротора, частота вращения ротора, velocidad de giro, velocidad de rotación, frecuencia de "
        "giro, prędkość obrotowa, obroty, częstotliwość obrotów, velocidade de rotação, "
        "frequência de rotação, 자전 각속도, 회전 속도, 회전수"
    ),
    "spin_period": (
        "spin period, period of spin, rotation period, rotor period, time per revolution, time per turn, "
        "Drehperiode, Rotationsperiode, Eigenperiode, période de rotation, période de rotation propre, период "
        "вращения, период вращения ротора, tiempo de giro, periodo de giro, periodo de rotación, okres obrotu, "
        "okres wirowania, período de rotação, 자전 주기"
    ),
    "time": (
        "time, stopwatch, stop watch, stopwatch time, stopwatch reading, timing, measured time, precession time, "
        "duration, elapsed time, total time, Zeit, Stoppuhr, Messzeit, gemessene Zeit, Dauer, Präzessionszeit, "
        "temps, durée, chrono, chronomètre, temps de précession, temps mesuré, время, секундомер, время прецессии, "
        "полное время, общее время, tiempo, cronómetro, tiempo medido, tiempo de precesión, czas, stoper, czas "
        "precesji, zmierzony czas, tempo, tempo de precessão, 시간, 측정 시간"
    ),
    "turns": (
        "turns, revs, revolutions, number of turns, number of revolutions, precession turns, precession "
        "revolutions, count, laps, rounds, cycles, no of turns, no of revolutions, fraction of turn, Umdrehungen, "
        "Umläufe, Anzahl Umläufe, Anzahl Umdrehungen, Anzahl der Umdrehungen, tours, nombre de tours, обороты, "
        "число оборотов, количество оборотов, оборотов, N оборотов, vueltas, número de vueltas, revoluciones, "
        "liczba obrotów, liczba okrążeń, okrążenia, voltas, número de voltas, 횟수, 회전 횟수, 바퀴 수"
    ),
    "angle": (
        "angle, swept angle, precession angle, angle swept, angle of precession, Winkel, überstrichener Winkel, "
        "Präzessionswinkel, angle parcouru, angle de précession, угол, угол поворота, угол прецессии, ángulo, "
        "ángulo barrido, kąt, kąt obrotu, kąt precesji, ângulo, 각도"
    ),
    "precession_period": (
        "period, precession period, period of precession, tau, Periode, Periodendauer, Präzessionsperiode, "
        "Präzessionsdauer, période, période de précession, период, период прецессии, periodo, período, periodo de "
        "precesión, okres, okres precesji, período de precessão, 주기, 세차 주기"
    ),
    "precession_rate": (
        "precession rate, precession speed, precession frequency, rate of precession, precession, phidot, phi dot, "
        "precession angular velocity, angular velocity of precession, Präzessionsfrequenz, "
        "Präzessionsgeschwindigkeit, Präzessionsrate, Präzessionswinkelgeschwindigkeit, vitesse de précession, "
        "fréquence de précession, скорость прецессии, угловая скорость прецессии, частота прецессии, velocidad de "
        "precesión, frecuencia de precesión, prędkość precesji, prędkość kątowa precesji, częstość precesji, "
        "velocidade de precessão, frequência de precessão, 세차 각속도, 세차 속도"
    ),
    "spin precession_rate": (
        "angular velocity, angular speed, angular frequency, frequency, Winkelgeschwindigkeit, Kreisfrequenz, "
        "Frequenz, vitesse angulaire, fréquence, угловая скорость, частота, velocidad angular, frecuencia, prędkość "
        "kątowa, częstotliwość, rotation, frequência, velocidade angular, "
        "각속도, 진동수"
    ),
    "turns precession_period": "периоды, periods",
    "precession_period spin_period": "Umlaufzeit, Umlaufdauer",
    "pitch": (
        "pitch, pitch angle, elevation, inclination, rod angle, tilt, Neigung, Neigungswinkel, inclinaison, наклон, "
        "угол наклона, inclinación, nachylenie"
    ),
    "spin_sense": (
        "spin sense, spin direction, sense of spin, direction of spin, Drehsinn, sens de rotation, направление вращения"
    ),
    "precession_sense": (
        "precession sense, precession direction, sense of precession, direction of precession, Präzessionsrichtung, "
        "sens de précession, направление прецессии"
    ),
    "transverse_inertia": "transverse inertia, transverse moment of inertia",
    "inertia": (
        "inertia, moment of inertia, Trägheitsmoment, moment d'inertie, момент инерции, momento de inercia, moment "
        "bezwładności, momento de inércia, 관성 모멘트, 관성모멘트"
    ),
    "run": (
        "run, run number, run no, run id, trial, measurement, no, nr, number, id, index, row, label, point, test, "
        "attempt, Messung, Messung Nr, Versuch, Lauf, mesure, essai, numéro, опыт, номер, номер опыта, № опыта, № "
        "п/п, измерение, medida, medición, ensayo, número, pomiar, nr pomiaru, nr pom, lp, medição, medida nº, "
        "번호, 실험, 회차"
    ),
    "note": (
        "note, notes, comment, comments, remark, remarks, Bemerkung, Bemerkungen, Kommentar, Notiz, remarque, "
        "commentaire, примечание, примечания, комментарий, nota, notas, observaciones, comentario, uwagi, uwaga, "
        "observações, 비고"
    ),
}

_START = (
    "start initial before begin beginning first vorher anfang am_anfang avant début до начальная начальный antes "
    "inicial przed początkowa "
)
_END = "end final after last nachher ende danach après fin после конечная конечный después despues final po końcowa "
_NOISE = (
    "the of a for measured mean average avg observed reading value in der die das des gemessen gemessene mittel "
    "mittlere mittlerer de du la le moyen moyenne mesuré mesurée средний средняя среднее измеренный измеренное "
    "medio media promedio medido średni średnia średnie zmierzony zmierzona at half médio média 측정 평균 "
)
_THEORY = (
    "theory theoretical theor theo calculated calc computed expected predicted theorie theoretisch berechnet théorie "
    "théorique calculé теор теория теоретическая теоретический расчет расчетная teórico teórica calculado calculada "
    "teoria teoretyczna teoretyczny obliczona obliczony esperado 이론 계산 "
)
_UNSURE = (
    "u sigma err error errors uncertainty unc uncert stdev sd std delta unsicherheit fehler messunsicherheit "
    "incertitude erreur погрешность ошибка incertidumbre error niepewność błąd incerteza erro δ σ "
)


@lru_cache(maxsize=8192)
def squeeze(text: str) -> str:
    """Keep the letters of a name: look-alikes folded, accents, blanks, ``_``, ``-`` and dots gone; case stays."""
    folded = fold_letters(text)
    if not folded.isascii():
        # A dot above means a rate ("φ̇"); other accents come and go with the keyboard.
        decomposed = unicodedata.normalize("NFD", folded).replace("\u0307", "dot")
        folded = "".join(c for c in decomposed if unicodedata.category(c) != "Mn").replace("ł", "l").replace("ϕ", "φ")
        folded = folded.replace("ı", "i").replace("ß", "ss")
    return re.sub(r"[\s_\-.:'’<>|^]+", "", folded)


def _words(text: str) -> set[str]:
    return {squeeze(word).lower() for word in text.split()}


START_WORDS, END_WORDS, NOISE_WORDS, UNSURE_WORDS = _words(_START), _words(_END), _words(_NOISE), _words(_UNSURE)
THEORY_WORDS = _words(_THEORY)
"""Words for what was worked out and not measured."""

NAMES: dict[str, tuple[str, ...]] = {}
"""Roles by squeezed lower-case name."""
for _roles, _text in _WORDS.items():
    for _name in _text.split(","):
        NAMES.setdefault(squeeze(_name).lower(), tuple(_roles.split()))
for _role in ROLES:
    NAMES[squeeze(_role).lower()] = (_role,)

SYMBOLS: dict[str, tuple[str, ...]] = {squeeze(name): tuple(roles.split()) for name, roles in _SYMBOLS.items()}
"""Roles by squeezed symbol; case matters."""

_ALL_WORDS = frozenset(
    squeeze(word).lower() for text in _WORDS.values() for word in re.split(r"[\s,]+", text)
) | frozenset(START_WORDS | END_WORDS | NOISE_WORDS | UNSURE_WORDS)


def is_word(text: str) -> bool:
    """Tell whether a word is one that stands in headers, or a unit."""
    from gyrodata.units import kinds_of

    return squeeze(text).lower() in _ALL_WORDS or bool(kinds_of(text))
