"""Media as lens files name them: catalogue glasses, model glasses of n_d and V_d, plastics and liquids, air."""

import re
from collections.abc import Sequence
from dataclasses import replace
from math import sqrt

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import AIR, C_LINE, D_LINE, F_LINE, Glass, GlassError, from_formula
from lensbench.core.text import fixed, significant
from lensbench.lenses.file_error import RowError
from lensbench.lenses.glass import catalogue as glass_catalogue
from lensbench.lenses.tables.design import Design
from lensbench.lenses.tables.rows import HIGHEST_INDEX
from lensbench.lenses.tables.text import file_number, is_number

AIR_NAMES = {"", "AIR", "VACUUM", "VACUO"}
LINES = (F_LINE, D_LINE, C_LINE)
ROUNDING = 4e-5         # µm: 656.3 nm is the C line
MIRROR_NAMES = {"MIRROR", "REFL", "RFL", "RFH"}

MISC = "MISC"           # the catalogue of media that no maker lists
MISC_NAMES = {"SPECIAL", "MALITSON", "MISC"}        # what design programs call it, or cite for crystals
GAS = 1e-3              # greatest difference of the index of a gas, or vacuum, from that of air

# n_d and V_d of media of which no formula is known, by the names that design programs give them
OTHERS = {
    "COC": (1.533732, 56.23), "WATER": (1.333041, 55.77), "SEAWATER": (1.339462, 54.90), "COP": (1.5311, 56.0),
    "APEL": (1.5445, 56.0), "OKP4": (1.6073, 27.0), "OKP1": (1.6422, 22.4), "EP5000": (1.6355, 23.9),
    "EP7000": (1.6510, 21.5), "EP8000": (1.6610, 20.4), "EP10000": (1.6830, 18.4),
    "PC": (1.5855, 29.9), "PS": (1.5905, 30.9),
}

# Water of 20 °C, whose index depends on its salt: grams in a kilogram
WATERS = {"WATER": 0.0, "SEAWATER": 35.0}
DAIMON = ((0.5684027565, 0.005101829712), (0.1726177391, 0.01821153936), (0.02086189578, 0.02620722293),
          (0.1130748688, 10.69792721))          # B and C (µm²) of its formula
AIR_INDEX = 1.00027

# Powers of the wavelength in the formulas of `optics.glass` that give n²
POWERS = {"schott": (0, 2, -2, -4, -6, -8, -10, -12), "extended-2": (0, 2, -2, -4, -6, -8, 4, 6),
          "extended-3": (0, 2, 4, -2, -4, -6, -8, -10, -12)}


def model(n_d: float, v_d: float, name: str = "") -> Glass:
    """The model glass of n_d and V_d (0: unknown). RowError: numbers that no glass has.

    A gas thinner than air is a medium of index 1, whose name says so.
    """
    if n_d == 1.0:
        return AIR
    if 1.0 - GAS <= n_d < 1.0:
        return Glass(1.0, name=f"{name or 'the gas'} of index {fixed(n_d, 6)}")
    if not 1.0 < n_d <= HIGHEST_INDEX:
        raise RowError(f"index n_d is {significant(n_d)}: it must be at least 1 (air), and no lens is made "
                       f"of more than {significant(HIGHEST_INDEX)}")
    if v_d < 0.0:
        raise RowError(f"Abbe number V_d is {significant(v_d)}: it must be positive, or 0 where it is not known")
    return Glass(n_d, v_d or None, name)


def named(name: str, maker: str | None = None, spare: tuple[float, float] | None = None) -> tuple[Glass, str]:
    """The glass of this name, and the assumption made ("": none).

    spare: n_d and V_d that the file has beside the name, used if no catalogue has the name. RowError: unknown name and
    no spare; it lists the nearest names.
    """
    if name.upper() in AIR_NAMES:
        return AIR, ""
    if name.upper() in MIRROR_NAMES:
        raise RowError("a mirror is not traced")
    if maker and maker.upper() in MISC_NAMES and MISC in glass_catalogue.makers(name):
        return glass_catalogue.find(name, MISC), ""
    try:
        exact = glass_catalogue.lookup(name, maker)
        if exact is not None:
            return exact, glass_catalogue.resolve(name, maker).note
        if name.upper() in WATERS:
            salt = WATERS[name.upper()]
            salty = f" with {significant(salt)} g/kg of salt (X. Quan and E. S. Fry, 1995)" if salt else ""
            return _water(name, salt), (f"{name} is read as water of 20 °C (M. Daimon and A. Masumura, 2007)" + salty)
        if name.upper() in OTHERS:
            n_d, v_d = OTHERS[name.upper()]
            return Glass(n_d, v_d, name), f"{name} is read as n_d {significant(n_d)} and V_d {significant(v_d)}"
        if spare and spare[0] > 1.0 and spare[1] >= 0.0:
            return model(*spare, name), (f"the glass {name} is in no catalogue: n_d {significant(spare[0])} and V_d "
                                         f"{significant(spare[1])}, which the file has next to its name, are used")
        near = glass_catalogue.resolve(name, maker)
        return near.glass, near.note
    except GlassError as error:
        raise RowError(str(error)) from None


def glass_in(design: Design, name: str, maker: str | None = None, spare: tuple[float, float] | None = None) -> Glass:
    """The glass of `named` for a file, whose design gets the assumption as a finding."""
    glass, assumed = named(name, maker, spare)
    if assumed:
        design.found(Kind.GLASS, assumed)
    return glass


def maker_among(name: str, catalogues: Sequence[str]) -> str | None:
    """The maker of a glass by the first of a file's catalogues (such as SUMITA, SUMITA_2011) that has it; else None."""
    known = glass_catalogue.makers(name)
    return next((maker for catalogue in catalogues for maker in known
                 if catalogue == maker or catalogue.startswith(f"{maker}_")), None)


def _water(name: str, salt: float) -> Glass:
    """Water of 20 °C: index in air from 0.2 to 1.12 µm.

    Pure water by M. Daimon and A. Masumura, Appl. Opt. 46, 3811 (2007), who measured it in vacuum; what salt (g/kg)
    adds by X. Quan and E. S. Fry, Appl. Opt. 34, 3477 (1995), who fitted it from 0.40 to 0.70 µm.
    """
    def index(w: float) -> float:
        squared = w * w
        pure = sqrt(1.0 + sum(b * squared / (squared - c) for b, c in DAIMON)) / AIR_INDEX
        return pure + (1.779e-4 - 1.05e-6 * 20.0 + 1.6e-8 * 20.0**2 + 1.155e-5 / w) * salt

    return tabulated(name, [(w / 100.0, index(w / 100.0)) for w in range(20, 113)])


def stated(name: str, n_d: float, v_d: float, maker: str | None = None) -> Glass:
    """The glass with these numbers: that of the catalogue if its numbers are equal, else a model glass."""
    exact = glass_catalogue.lookup(name, maker) if name else None
    if exact is not None and exact.n_d == n_d and (exact.v_d or 0.0) == v_d:
        return exact
    return model(n_d, v_d, name)


def code(text: str) -> Glass | None:
    """The glass of a code such as 517642, 517.642, 517000.641700 or 1.5168:64.17; None for other words."""
    n_d, colon, v_d = text.partition(":")
    if colon and is_number(n_d) and is_number(v_d):
        return model(file_number(n_d, "index n_d"), file_number(v_d, "Abbe number V_d"))
    digits = re.fullmatch(r"(\d{3,12})\.(\d{2,12})", text) or re.fullmatch(r"(\d{3})(\d{3})", text)
    if digits:
        return model(float(f"1.{digits[1]}"), float(f"{digits[2][:2]}.{digits[2][2:] or 0}"))
    return None


def tabulated(name: str, points: list[tuple[float, float]]) -> Glass:
    """The glass of (wavelength µm, index) pairs; a model of n_d and V_d if the lines are exactly F, d and C.

    Rounded wavelengths (587.6 nm) count as the lines. RowError: fewer than two pairs, or values that no glass has.
    """
    table = tuple(sorted({next((line for line in LINES if abs(line - w) < ROUNDING), w): n for w, n in points}.items()))
    if len(table) < 2:
        raise RowError(f"the glass {name} needs its indices at two wavelengths at least")
    try:
        glass = Glass(table[0][1], None, name, "table", table)
        low, high = table[0][0], table[-1][0]
        n_d = glass.index(D_LINE) if low <= D_LINE <= high else table[len(table) // 2][1]
        spread = glass.index(F_LINE) - glass.index(C_LINE) if low <= F_LINE and C_LINE <= high else 0.0
        v_d = (n_d - 1.0) / spread if spread > 0.0 and n_d > 1.0 else None
        model(n_d, v_d or 0.0)
        return Glass(n_d, v_d, name) if {w for w, _ in table} == set(LINES) else replace(glass, n_d=n_d, v_d=v_d)
    except (GlassError, ArithmeticError) as error:
        raise RowError(str(error)) from None


def from_database(name: str, number: int, c: list[float], wavelengths: tuple[float, float]) -> Glass:
    """The glass of formula 1, 2, 3, 5 or 6 of refractiveindex.info, with coefficients c and its range (µm).

    1, 2: n² = 1 + c₀ + Σ B λ² / (λ² − C), with C² in formula 1. 3: n² = c₀ + Σ a λ^p; 5: so n. 6: gases. RowError: a
    formula that is not read.
    """
    try:
        if number in (1, 2):
            terms = [x * x if number == 1 and i % 2 else x for i, x in enumerate(c[1:])]
            formula, terms = ("sellmeier", terms) if c[0] == 0.0 else ("sellmeier-4", [1.0 + c[0], *terms])
            return from_formula(name, formula, terms, wavelengths)
        if number in (3, 5):
            by_power = {0.0: c[0]}
            for a, power in zip(c[1::2], c[2::2], strict=True):
                by_power[power] = by_power.get(power, 0.0) + a
            known = POWERS if number == 3 else {"cauchy": tuple(range(0, int(min(by_power)) - 1, -2))}
            for formula, powers in known.items():
                if set(by_power) <= set(powers):
                    return from_formula(name, formula, [by_power.get(float(power), 0.0) for power in powers],
                                        wavelengths)
        if number == 6 and abs(c[0] + sum(a / (b - D_LINE**-2) for a, b in zip(c[1::2], c[2::2], strict=True))) < GAS:
            return Glass(1.0, name=f"the gas {name}")
    except (GlassError, ValueError, ArithmeticError, IndexError) as error:
        raise RowError(f"the material {name}: {error}") from None
    raise RowError(f"the material {name} has formula {number} of refractiveindex.info, with terms that are not read")


def is_plain_table(glass: Glass) -> bool:
    """Whether `tabulated` reproduces this glass from its pairs of wavelength and index."""
    try:
        return glass.formula == "table" and tabulated(glass.name, list(glass.coefficients)) == glass
    except RowError:
        return False


def listed(name: str, maker: str | None, points: list[tuple[float, float]]) -> Glass | None:
    """The catalogue glass of this name if its index equals that of every (wavelength µm, index) pair, else None."""
    glass = glass_catalogue.lookup(name, maker) if name else None
    try:
        if glass is not None and points and all(abs(glass.index(w) - n) < 1e-9 for w, n in points):
            return glass
    except GlassError:
        pass
    return None


def is_known(glass: Glass, maker: str | None = None) -> bool:
    """Whether a reader finds this exact glass by its name, and by the maker where the file says which."""
    return bool(glass.name) and glass.formula != "model" and glass_catalogue.lookup(glass.name, maker) == glass


def maker_of(glass: Glass) -> str:
    """Maker whose catalogue has this exact glass under its name; "" if none has, MISC included."""
    if not glass.name or glass.formula == "model":
        return ""
    return next((maker for maker in glass_catalogue.makers(glass.name)
                 if maker != MISC and glass_catalogue.lookup(glass.name, maker) == glass), "")


def glass_loss(glass: Glass, i: int, with_maker: bool = False,
               is_found: bool | None = None) -> list[Finding]:
    """Finding about what is lost if only name, n_d and V_d of the glass of surface i are written; empty if nothing.

    with_maker: its maker is written as well. is_found: whether a reader finds it in the
    catalogues that the file names; None: it names none.
    """
    if glass.n_d == 1.0:
        lost = f"the name of {glass.name}, of index 1, is left out" if glass.name else ""
    elif glass.formula == "model" or (maker_of(glass) if with_maker else is_known(glass) if is_found is None
                                      else is_found):
        lost = ""
    else:
        lost = f"of the dispersion of {glass.name or 'a glass'} only n_d and V_d are written"
    return [note(Kind.GLASS, f"surface {i}: {lost}", i)] if lost else []
