"""Make the tables of docs/rubber-and-impact.md: Problem 1 as printed and corrected, and in 3-D.

Run from the repository's root (a minute of one core, seven where others use it too). Tables that
the page shows are written into it, others are printed; all of them, or those that are named::

    python docs/examples/sliding_tables.py NAME
"""

# %%
import sys
from pathlib import Path

import numpy as np

from reduced.loads import Load, LoadPath
from reduced.memory.materials import kelvin_voigt, standard_solid
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import line_of, prescribed
from reduced.rough.press import RoughLines, press
from reduced.rough.surface_spectrum import SelfAffineLaw, measured
from reduced.rubber.history import slide_as_printed, slide_in_time
from reduced.rubber.steady import slide
from reference import loads as reference_loads
from reference import surfaces
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import slide_on_rubber, slide_shape
from reference.viscoelastic.travelling import Travelling
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "rubber-and-impact.md"
LOAD = 3e-3
SPECTRUM = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1, short_cutoff=1 / 16))
RUBBER = kelvin_voigt(1.0, 1.0)


def rough(points: int, count: int = 6) -> np.ndarray:
    """Lines of length 1 with sixteen waves."""
    return RandomLines(SPECTRUM, points, count, seed=7).draw().heights


# %% [markdown]
# The printed scheme over its relaxation number, 512 points, started in contact at rest.


# %%
def printed() -> list[list[str]]:
    """Outcome and errors of the print."""
    rows = [["G dt/eta", "ended", "friction", "work of its forces", "springs in tension"]]
    for number in (0.02, 0.1, 0.5, 1.0, 1.5, 1.9, 1.99, 2.01, 2.1, 5.0, 1000.0):
        speed, ended, errors, works, tensile = 1 / (512 * number), 0, [], [], []
        for line in rough(512):
            still = press(
                RoughLines(line, 1 / 512), 4.0, Load("force", [LOAD]), edges="nodal"
            ).penetration.item()
            run = slide_as_printed(
                RoughLines(line, 1 / 512),
                kelvin_voigt(1.0, 1.0),
                speed,
                LOAD,
                steps=2048,
                level=line.max() - still,
            )
            exact = slide(
                RoughLines(line, 1 / 512), RUBBER, speed, LoadPath("force", LOAD)
            ).tangential_force.item()
            if run.outcome == "completed":
                ended += 1
                errors.append(run.tangential_force[-512:].mean() / exact - 1)
                works.append(run.conjugate_force[-512:].mean() / exact - 1)
                tensile.append(run.tensile_count[-512:].mean())
        means = [f"{100 * np.mean(e):+.3g} %" for e in (errors, works)] if ended else ["-", "-"]
        rows.append(
            [f"{number:g}", f"{ended} of 6", *means, f"{np.mean(tensile):.0f}" if ended else "-"]
        )
    return rows


# %% [markdown]
# Energy over one period of the steady state: the printed F_x on the corrected motion.


# %%
def energy() -> list[list[str]]:
    """Work over dissipation less one: conjugate force, and central differences, by spacing."""
    rows = [["points", "v tau/dx", "work-conjugate", "central difference", "friction against 8192"]]
    for speed in (1e-4, 0.02, 0.2):
        finest = slide(
            RoughLines(rough(8192, 1), 1 / 8192), RUBBER, speed, LoadPath("force", LOAD)
        ).friction_coefficient.item()
        for points in (128, 512, 2048):
            line = rough(points, 1)[0]
            sliding = slide_in_time(
                RoughLines(line, 1 / points), kelvin_voigt(1.0, 1.0), speed, LOAD, steps=4 * points
            )
            steady = slide(RoughLines(line, 1 / points), RUBBER, speed, LoadPath("force", LOAD))
            central = central_work(line, speed, float(line.max()) - steady.penetration.item())
            rows.append(
                [
                    f"{points}",
                    f"{speed * points:.3g}",
                    f"{sliding.energy_error()[0]:+.0e}",
                    f"{100 * (central / steady.dissipation.item() - 1):+.2g} %",
                    f"{100 * (steady.friction_coefficient.item() / finest - 1):+.2g} %",
                ]
            )
    return rows


def central_work(line: np.ndarray, speed: float, level: float) -> float:
    """Nodal forces 4 (w + v tau dw/dx) of the exact motion, times the central difference."""
    points = line.size
    peak = int(np.argmax(line))
    heights = np.append(np.roll(line, -peak), line[peak])
    slopes = (np.roll(line, -1 - peak) - np.roll(line, 1 - peak)) / 2
    w, work, keep = heights[0] - level, 0.0, np.exp(-1 / (points * speed))
    for i in range(1, points):
        g = heights[i] - level
        rate = (heights[i] - heights[i - 1]) * points
        force = 4 * (g + speed * rate)
        touching = g >= w * keep and force > 0
        work += force * slopes[i] if touching else 0.0
        w = g if touching else w * keep
    return work


# %% [markdown]
# The paraboloid: springs against the half-space.


# %%
def limit_of(values: list[float]) -> tuple[float, float]:
    """Return the limit of values on three grids, each of twice the cells, and its bar.

    Extrapolated with the observed order, limited to [1, 2]; the finest if changes differ in sign.
    At order 1, the lowest at contact edges, as much remains as changed last.
    """
    coarse, middle, fine = values
    first, second = middle - coarse, fine - middle
    bar = max(abs(second), abs(first) / 2)
    if first * second <= 0:
        return fine, bar
    return fine + second / (min(max(first / second, 2.0), 4.0) - 1), bar


# %%
def ball() -> list[list[str]]:
    """Friction, its bar, and springs at the same force."""
    rows = [["material", "way/a", "mu R/(v tau)", "bar", "1-D/3-D friction", "1-D/3-D depth"]]
    for name, glassy in (("Kelvin-Voigt", 0.0), ("standard, 11", 11.0), ("standard, 101", 101.0)):
        for way in (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1000.0):
            if glassy:
                springs = standard_solid(0.25, (glassy - 1) / 4, relaxation_time=1 / glassy)
                body = GeneralisedMaxwell.standard(0.25, (glassy - 1) / 4, 1 / glassy)
                slow = (glassy - 1) / glassy
            else:
                springs, slow = RUBBER.scaled(0.25), 1.0
                body = GeneralisedMaxwell.kelvin_voigt(0.25, 0.25)
            speed = 0.1 * way
            depth, reach = reference_loads.Load("penetration", 0.01), (np.sqrt(0.02),) * 2
            contacts = [
                slide_shape(lambda x, y: (x**2 + y**2) / 2, reach, body, speed, cells, depth)
                for cells in (36, 72, 144)
            ]
            force, _ = limit_of([contact.force for contact in contacts])
            mu, bar = limit_of([contact.friction_coefficient for contact in contacts])
            x = np.linspace(-0.3, 0.3, 4001)
            sliding = slide(
                RoughLines(-(x**2), x[1] - x[0], periodic=False),
                springs,
                speed,
                LoadPath("force", force),
            )
            rows.append(
                [
                    name,
                    f"{way:g}",
                    f"{mu / (slow * speed):.4g}",
                    f"{100 * bar / mu:.2f} %",
                    f"{sliding.friction_coefficient.item() / mu:.3f}",
                    f"{sliding.penetration.item() / 0.01:.3f}",
                ]
            )
    return rows


# %% [markdown]
# A sinusoidal ridge in partial contact, and a rough surface, on three grids.


# %%
def study(height, slope, load: float, material, speed: float, counts) -> list:
    """Contacts on the grids, each of twice the points."""
    contacts, start = [], None
    for n in counts:
        h, s = height(n), slope(n)
        width = h.shape[1]
        operator = Travelling((n, width), (1 / n, 1 / n), material, speed, periodic=True)
        contacts.append(
            slide_on_rubber(
                operator,
                h.max() - h,
                reference_loads.Load("force", load * width / n),
                slope=s,
                start=start,
            )
        )
        grown = contacts[-1].mask.repeat(2, axis=0)
        start = grown if width == 2 else grown.repeat(2, axis=1)
    return contacts


def ridge() -> list[list[str]]:
    """Sinusoid of slope 0.1, a tenth of the pressure of full contact."""
    rows = [["v tau/wavelength", "contact", "n = 128", "256", "512", "estimate", "bar"]]
    q = 2 * np.pi
    body = GeneralisedMaxwell.kelvin_voigt(0.25, 0.25)
    for speed in (0.003, 0.03, 0.3):
        contacts = study(
            lambda n: 0.1 / q * np.cos(q * np.arange(n) / n)[:, None] * np.ones((1, 2)),
            lambda n: 0.1 * np.sin(q * np.arange(n) / n)[:, None] * np.ones((1, 2)),
            *(0.005, body, speed, (128, 256, 512)),
        )
        values = [contact.friction_coefficient for contact in contacts]
        estimate, bar = limit_of(values)
        rows.append(
            [
                *(
                    f"{speed:g}",
                    f"{contacts[-1].mask.mean():.3f}",
                    *(f"{v:.5f}" for v in values),
                    f"{estimate:.5f}",
                ),
                f"{100 * bar / estimate:.2f} %",
            ]
        )
    return rows


def surface() -> list[list[str]]:
    """One periodic surface refined, and the lines made from it."""
    rows = [["v lambda/L", "contact", "n = 48", "96", "192", "estimate", "bar", "lines"]]
    h = surfaces.self_affine(
        48,
        1.0,
        surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, long_cutoff=0.5, short_cutoff=0.125),
        seed=3,
        realisation=0,
    )
    body = GeneralisedMaxwell.standard(0.25, 2.5, 1 / 11)
    springs = standard_solid(0.25, 2.5, relaxation_time=1 / 11)
    speeds = (0.003, 0.01, 0.03, 0.1, 0.3)
    spectrum = line_of(measured(h, 1.0, periodic=True))
    many = RandomLines(spectrum, 8 * 48, 100).draw()
    friction = slide(many, springs, speeds, LoadPath("force", 0.005)).friction_coefficient
    mean, scatter = friction.mean(axis=0), friction.std(axis=0, ddof=1) / 10

    def height(n: int) -> np.ndarray:
        return h if n == 48 else surfaces.refine(h, n // 48)

    def slope(n: int) -> np.ndarray:
        modes = 2j * np.pi * np.fft.fftfreq(n, 1 / n)[:, None]
        return -np.fft.ifft(modes * np.fft.fft(height(n), axis=0), axis=0).real

    for k, speed in enumerate(speeds):
        contacts = study(height, slope, 0.005, body, speed, (48, 96, 192))
        values = [contact.friction_coefficient for contact in contacts]
        estimate, bar = limit_of(values)
        rows.append(
            [
                *(
                    f"{speed:g}",
                    f"{contacts[-1].mask.mean():.3f}",
                    *(f"{v:.5f}" for v in values),
                    f"{estimate:.5f}",
                ),
                f"{100 * bar / estimate:.1f} %",
                f"{mean[k]:.5f} +- {scatter[k]:.5f}",
            ]
        )
    return rows


# %%
TABLES = {"printed": printed, "energy": energy, "ball": ball, "ridge": ridge, "surface": surface}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
