"""Numbers and units as a reader wants them: few digits, prefixes, per cent, a true minus.

Values keep three significant digits and errors two. A relative error is written in per cent down
to 0.01 %, in ppm below that, and as a power of ten where even ppm would be a row of zeros.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np

THIN = "\u202f"  # narrow no-break space: a number never parts from its unit
MINUS = "\u2212"
MISSING = "–"
TINY = f"< 1{THIN}ppm"
ROUND_OFF = 1e-9  # relative differences below this are the arithmetic's, not the models'
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Letters that claim files spell in words.
_GREEK = {
    "alpha": "α",
    "beta": "β",
    "delta": "δ",
    "eta": "η",
    "kappa": "κ",
    "lambda": "λ",
    "mu": "μ",
    "nu": "ν",
    "omega": "ω",
    "pi": "π",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "theta": "θ",
}
_LETTER = re.compile(rf"(?<![\w-])({'|'.join(_GREEK)})(?=\d?(?:_\w+)?(?![\w-]))")
_PREFIXES = {-5: "f", -4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G", 4: "T"}


@dataclass(frozen=True)
class Scale:
    """A prefixed unit: ``value * factor`` is the number to print before `unit`."""

    factor: float
    unit: str


def finite(value: object) -> TypeGuard[float]:
    """Tell whether a value is a finite number (None, text and NaN are not).

    >>> [finite(v) for v in (0, 1.5, None, float("nan"), "a")]
    [True, True, False, False, False]
    """
    try:
        return math.isfinite(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False


def number(value: object, digits: int = 3) -> str:
    """Write a pure number with `digits` significant digits.

    >>> number(1234.5678), number(-0.012345), number(0), number(None)
    ('1\u202f230', '−0.0123', '0', '–')
    >>> number(6.02214e23)
    '6.02×10²³'
    """
    if not finite(value):
        return MISSING
    value = float(value)
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{abs(value):.{digits - 1}e}".split("e")
    power = int(exponent)
    if not -4 < power < 6:
        text = f"{mantissa}×10{str(power).translate(_SUPERSCRIPTS)}"
    else:
        rounded = float(f"{mantissa}e{power}")
        text = f"{rounded:,.{max(digits - 1 - power, 0)}f}".replace(",", THIN)
    return (MINUS if value < 0 else "") + text


def count(value: object) -> str:
    """Write an integer in full, in groups of three.

    >>> count(1048576)
    '1\u202f048\u202f576'
    """
    return f"{round(float(value)):,}".replace(",", THIN) if finite(value) else MISSING


def prefix_for(values: Iterable[object] | object, unit: str, digits: int = 3) -> Scale:
    """Choose one engineering prefix for a set of values: the largest lies between 1 and 1000.

    Areas take the prefix with its square (1 µm² is 1e-12 m²), so they reach from 0.01 to 10⁴;
    volumes take it with its cube, from 0.1 on.

    >>> prefix_for([1e-6, 5e-6], "m")
    Scale(factor=1000000.0, unit='µm')
    >>> prefix_for(3.1e-8, "m2").unit
    'mm²'
    >>> prefix_for([0.0, float("nan")], "N")
    Scale(factor=1.0, unit='N')
    """
    if isinstance(values, np.ndarray) and values.dtype == float:  # by far the most
        sizes = np.abs(values[np.isfinite(values)])
        largest = float(sizes.max(initial=0.0))
    else:
        items = np.asarray(values, dtype=object).ravel()
        largest = max((abs(float(item)) for item in items if finite(item)), default=0.0)
    # 0.019 µm² reads better than 19 000 nm².
    dimension, slack, written = {"m2": (2, 2, "m²"), "m3": (3, 1, "m³")}.get(unit, (1, 0, unit))
    if not unit or largest == 0.0:
        return Scale(1.0, written)
    # The prefix must fit what is printed: 999.9996 is written as 1000.
    printed = float(f"{largest:.{digits - 1}e}")
    step = math.floor((round(math.log10(printed), 9) + slack) / (3 * dimension))
    step = min(max(step, min(_PREFIXES)), max(_PREFIXES))
    if unit in {"s", "B"}:
        step = min(step, 0) if unit == "s" else max(step, 0)
    return Scale(10.0 ** (-3 * dimension * step), _PREFIXES[step] + written)


def with_unit(value: object, unit: str, digits: int = 3) -> str:
    """Write a value with its own prefix.

    >>> with_unit(5e-6, "m"), with_unit(2.1e11, "Pa"), with_unit(None, "m")
    ('5.00\u202fµm', '210\u202fGPa', '–')
    """
    if not finite(value):
        return MISSING
    scale = prefix_for(value, unit, digits)
    return _join(number(float(value) * scale.factor, digits), scale.unit)


def told_apart(first: float, second: float, *, unit: str) -> tuple[str, str]:
    """Write two values with as many digits as tell them apart.

    >>> told_apart(1.0, 2.0, unit="m"), told_apart(1.14471e-3, 1.1447e-3, unit="m")
    (('1.00\u202fm', '2.00\u202fm'), ('1.14471\u202fmm', '1.14470\u202fmm'))
    """
    for digits in range(3, 18):
        texts = with_unit(first, unit, digits), with_unit(second, unit, digits)
        if texts[0] != texts[1]:
            break
    return texts


def relative(value: object, digits: int = 2) -> str:
    """Write a share, a bar or the size of an error: per cent, ppm, or a power of ten.

    >>> relative(0.0123), relative(-1e-5), relative(0.0), relative(None)
    ('1.2\u202f%', '−10\u202fppm', '0\u202f%', '–')
    >>> relative(3e-15)
    '3.0×10⁻¹⁵'
    """
    text, unit = _relative_parts(value, digits)
    return _join(text, unit)


def relative_range(shares: Iterable[float]) -> str:
    """Write the smallest and the largest of those shares that are known.

    >>> relative_range([0.062, 0.57, math.nan]), relative_range([1e-5, 0.02]), relative_range([0.1])
    ('6.2 to 57\u202f%', '10\u202fppm to 2.0\u202f%', '10\u202f%')
    >>> relative_range([2e-10, 7e-10])
    'round-off'
    """
    known = [share for share in shares if finite(share)]
    if not known:
        return MISSING
    if max(known) < ROUND_OFF:
        return "round-off"
    (least, small), (most, large) = (_relative_parts(end(known), 2) for end in (min, max))
    if (least, small) == (most, large):
        return _join(most, large)
    return f"{least if small == large else _join(least, small)} to {_join(most, large)}"


def signed_error(error: object) -> str:
    """Write a relative error with its sign.

    >>> signed_error(0.0123), signed_error(-0.021)
    ('+1.2\u202f%', '−2.1\u202f%')
    """
    return _with_sign(error, relative(error), ratio=False)


def _with_sign(error: object, text: str, ratio: bool) -> str:
    if not finite(error) or not float(error) > 0.0 or text.split()[0] in ("0", "<", "round-off"):
        return text
    large = ratio and float(error) >= 1.0
    return f"+{text}" + (f" ({_join(number(1 + float(error), 2), 'times')})" if large else "")


def tolerance(value: object) -> str:
    """Write a tolerance as it was asked for, without padding zeros.

    >>> tolerance(0.01), tolerance(0.025), tolerance(5e-6), tolerance(1e-9)
    ('1\u202f%', '2.5\u202f%', '5\u202fppm', '1×10⁻⁹')
    """
    text, unit = _relative_parts(value, 3)
    return _join(without_padding(text), unit)


def without_padding(text: str) -> str:
    """Take the zeros off that only fill up to a number of digits.

    >>> without_padding("20.0"), without_padding("1.50×10⁻⁹"), without_padding("100")
    ('20', '1.5×10⁻⁹', '100')
    """
    head, times, power = text.partition("×")
    return (head.rstrip("0").rstrip(".") if "." in head else head) + times + power


def unpadded(value: float, unit: str) -> str:
    """Write a value that a user gave, without padding zeros.

    >>> unpadded(10.0, "N"), unpadded(0.3, "")
    ('10\u202fN', '0.3')
    """
    scale = prefix_for(value, unit)
    return _join(without_padding(number(value * scale.factor, 4)), scale.unit)


def plus_minus(
    error: object, uncertainty: object, *, signed: bool = True, ratio: bool = False
) -> str:
    """Write an error with the half-width of its bar: one unit, both to the same decimal place.

    That is the place of the bar's second digit, or of its first where the error would need more
    than three digits. An error above a tenth of its bar keeps at least two. The size of an error
    has no sign; the error of a `ratio` is that minus 1, and has factors from 2 on beside it.

    >>> plus_minus(0.0123, 0.0004), plus_minus(3.08, 0.04, ratio=True), plus_minus(-0.01, 6e-5)
    ('+1.23 ± 0.04\u202f%', '+308 ± 4\u202f% (4.1\u202ftimes)', '−1.000 ± 0.006\u202f%')
    >>> plus_minus(0.02, None), plus_minus(0.0012, 0.05), plus_minus(2e-4, 3e-6, signed=False)
    ('+2.0\u202f% ± ?', '+0.1 ± 5.0\u202f%', '0.0200 ± 0.0003\u202f%')
    >>> plus_minus(4e-16, 1e-12), plus_minus(4e-16, 1e-6)
    ('round-off', '0 ± 1.0\u202fppm')
    >>> plus_minus(-2e-11, 3e-8), plus_minus(2e-9, 1e-15), plus_minus(3e-11, None)
    ('< 1\u202fppm', '< 1\u202fppm', '< 1\u202fppm ± ?')
    """
    if signed:
        return _with_sign(error, plus_minus(error, uncertainty, signed=False), ratio)
    if not finite(error):
        return MISSING
    size = abs(float(error))
    if not finite(uncertainty):
        return f"{relative(error) if size == 0 or _relative_unit(size)[0] else TINY} ± ?"
    half = float(uncertainty)
    if size + half < ROUND_OFF:
        return "round-off"
    factor, unit = _relative_unit(max(size, half))
    if not factor or size < ROUND_OFF < half < 0.9995e-6:
        return TINY
    if half < 0.002 * size:
        return relative(error)  # a bar below the last digit printed
    if size < ROUND_OFF:
        return _join(f"0 ± {number(half * factor, 2)}", unit)
    value, bar = float(error) * factor, half * factor
    place = _exponent(bar, 2) - 1
    if _exponent(value, 3) - place > 2:
        place = _exponent(bar, 1)
    finer = min(place, _exponent(value, 2) - 1) if size > half / 10 else place
    return _join(f"{_to_place(value, finer)} ± {_to_place(bar, place)}", unit)


def between(low: object, high: object) -> str:
    """Write the ends of a band of relative errors, each with its sign; once where they are one.

    >>> between(-0.31, 0.372), between(-1.0, -0.9999), between(None, 1.0)
    ('−31 to +37\u202f%', '−100\u202f%', '–')
    """
    if not (finite(low) and finite(high)):
        return MISSING
    factor, unit = _relative_unit(max(abs(low), abs(high)))
    ends = [number(end * (factor or 1.0), 2) for end in (low, high)]
    signed = [f"+{text}" if end > 0 else text for text, end in zip(ends, (low, high), strict=True)]
    return _join(" to ".join(dict.fromkeys(signed)), unit)


def _exponent(value: float, digits: int) -> int:
    """Return the power of ten of the leading digit, once rounded to some digits."""
    return int(f"{abs(value):.{digits - 1}e}".partition("e")[2])


def _to_place(value: float, place: int) -> str:
    """Write a number down to a power of ten, without powers for small ones.

    >>> _to_place(0.00031, -4), _to_place(-1234.5, 1), _to_place(0.001, -2)
    ('0.0003', '−1\u202f230', '0')
    """
    if abs(value) < 0.5 * 10.0**place:
        return "0"
    if place > 0:
        return number(value, max(_exponent(value, 3) - place + 1, 1))
    return f"{value:,.{-place}f}".replace(",", THIN).replace("-", MINUS)


def duration(value: object) -> str:
    """Write a time: two digits below two minutes, then minutes and hours.

    >>> duration(3.21e-6), duration(0.95), duration(125), duration(7320)
    ('3.2\u202fµs', '950\u202fms', '2\u202fmin\u202f5\u202fs', '2\u202fh\u202f2\u202fmin')
    >>> duration(996e-6)
    '1.0\u202fms'
    """
    if not finite(value):
        return MISSING
    seconds = float(value)
    if seconds < 100:
        return with_unit(seconds, "s", 2)
    minutes, remainder = divmod(round(seconds), 60)
    hours, minutes_left = divmod(minutes, 60)
    if hours:
        return _join(f"{hours}{THIN}h{THIN}{minutes_left}", "min")
    return _join(f"{minutes}{THIN}min{THIN}{remainder}", "s")


def listed(names: Sequence[str]) -> str:
    """Write names one after another.

    >>> listed(["a", "b", "c"]), listed(["a"])
    ('a, b and c', 'a')
    """
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def capitalised(text: str) -> str:
    """Return a text that begins with a capital letter."""
    return text[:1].upper() + text[1:]


def _relative_parts(value: object, digits: int) -> tuple[str, str]:
    if not finite(value):
        return MISSING, ""
    if float(value) == 0.0:
        return "0", "%"
    factor, unit = _relative_unit(abs(float(value)))
    return number(float(value) * (factor or 1.0), digits), unit


def _relative_unit(size: float) -> tuple[float, str]:
    """Return factor and unit of a relative error: per cent, ppm, or neither (0)."""
    if size >= 0.9995e-4:
        return 100.0, "%"
    return (1e6, "ppm") if size >= 0.9995e-8 else (0.0, "")


def _join(text: str, unit: str) -> str:
    return f"{text}{THIN}{unit}" if unit else text


def greek(text: str) -> str:
    """Return a text with Greek letters in place of their names.

    >>> greek("F/(mu F_N), lambda_l and kappa1, but lambda-rings, muon and Pi")
    'F/(μ F_N), λ_l and κ1, but lambda-rings, muon and Pi'
    """
    return _LETTER.sub(lambda match: _GREEK[match[1]], text)
