"""Films of a soft ball on 16, 32 and 64 cells, extrapolated; docs/lubrication.md, "Hamrock"."""

from reference.errors import ConvergenceError
from reference.lubrication.formulas import SoftFit, soft_limit
from reference.lubrication.point import Ball, entrain

BALL = {"radius": 0.01, "effective_modulus": 1e6, "viscosity": 1.0, "load": 0.2}


def central(speed: float, resolution: int) -> float:
    """Return the central film in um, or NaN where the cells lose it."""
    try:
        return 1e6 * entrain(Ball(**BALL), speed, resolution).film_central
    except ConvergenceError:
        return float("nan")


def main() -> None:
    """Print a row for each speed."""
    print("mm/s     16      32      64      extrapolated   ratio  fit      limit")
    for speed in (1e-2, 3e-3, 1e-3, 3e-4, 1e-4):
        coarse, middle, fine = (central(speed, n) for n in (16, 32, 64))
        film, bar = fine - (middle - fine) / 3, abs(middle - fine) / 3
        ratio = (coarse - middle) / (middle - fine)
        fit = film / (1e6 * SoftFit(**BALL).central(speed)) - 1
        limit = film / (1e6 * soft_limit(speed=speed, **BALL)) - 1
        print(
            f"{1e3 * speed:4g}  {coarse:.3f}  {middle:.3f}  {fine:.3f}  {film:.3f} +- {bar:.3f}  "
            f"{ratio:4.1f}  {fit:+.1%}  {limit:+.1%}"
        )


if __name__ == "__main__":
    main()
