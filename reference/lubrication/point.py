"""A smooth or rough ball on a lubricated half-space: entrained steadily, or approaching it.

Everything is solved in units of the contact: lengths in l = a + c with Hertz's radius a and the
reach c = sqrt(2 R h0) of a rigid ball's pressure, films in l^2/R, pressure in F/l^2. Two numbers
are left: 12 eta U R^2/(F l), of an approach 12 eta V R^3/(F l^2), and F R/(E* l^3).
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from reference.arrays import Array
from reference.errors import ConvergenceError, count_faults, positive_faults, refuse
from reference.lubrication import formulas
from reference.lubrication.loaded import BentSurface, LoadedFilm
from reference.lubrication.reynolds import Film, FilmState, Transport, around_point, rigid_film_at

# Where the equal cells begin and end along x, and half of their width, in units of l.
_ALONG, _SQUEEZED, _ACROSS = (-2.5, 1.5), (-2.0, 2.0), 2.0
# Coarsest cells per l, on which the speed is lowered from where the ball is rigid.
_COARSEST = 8
# Ratio of speeds, or of loads, from one film to the next, and the closest to one that is tried: on
# the finest cells, and on coarser ones, whose films need not go far.
_RATIO, _CLOSEST, _NEAR_ENOUGH = 0.45, 0.9, 0.6
# Share by which a load is below the next one, times the cells per l.
_FALL = 2.0
# Fewest cells per l, and per wave of a rough ball on the finest and on coarser cells.
_FEWEST, FEWEST_PER_WAVE, _COARSE_WAVE = 4, 6, 3
# Half-widths of the cells in c. A rigid ball's force beyond r falls as c/r when it is entrained, as
# c^2/r^2 when it is squeezed, where pressures far out drown in round-off: it grows as r^2.
_REACH, _SQUEEZED_REACH = 1e3, 200.0
# The least of them, in l.
_AROUND = 20.0
# Imbalance of a film, and of those from which others start.
_BALANCED, _ROUGHLY = 1e-10, 1e-3
_TINY = float(np.finfo(float).tiny)
# Film of the start, in units of the displacement of the surface.
_STIFF = 8.0
# The shortest wave is one of the lattice whatever the unit of both lengths makes of their ratio.
_ROUNDED = 1e-12


@dataclass(frozen=True)
class SurfaceWaves:
    """Heights sum a cos(k x + m y + phase), positive towards the other body.

    All of shape (n,), k and m in radians per length; exact at every point of any grid.

    >>> float(waviness(1e-6, 1e-3).at(np.zeros((1, 1)), np.zeros((1, 1)))[0, 0])
    1e-06
    """

    heights: Array = field(repr=False)
    along: Array = field(repr=False)
    across: Array = field(repr=False)
    phases: Array = field(repr=False)

    @property
    def shortest(self) -> float:
        """The shortest wavelength."""
        return float(2 * np.pi / np.hypot(self.along, self.across).max())

    @property
    def even(self) -> bool:
        """Whether the heights are even in y."""
        return bool((self.across == 0).all() or ((self.along == 0) & (self.phases == 0)).all())

    def at(self, x: Array, y: Array) -> Array:
        """Return the heights on an open mesh: x of shape (nx, 1), y of shape (1, ny)."""
        along = self.heights * np.exp(1j * (np.outer(x, self.along) + self.phases))
        across = np.exp(1j * np.outer(self.across, y))
        return np.real(along @ across)


def waviness(amplitude: float, wavelength: float, crests: str = "across") -> SurfaceWaves:
    """Return a single wave with a crest in the middle, across the flow (along y) or along it."""
    refuse(positive_faults(amplitude=amplitude, wavelength=wavelength))
    number = 2 * np.pi / wavelength
    along, across = (number, 0.0) if crests == "across" else (0.0, number)
    return SurfaceWaves(*(np.array([v]) for v in (amplitude, along, across, 0.0)))


def self_affine(
    rms_height: float, hurst: float, longest: float, shortest: float, seed: int = 0
) -> SurfaceWaves:
    """Return waves on a lattice of period `longest`, of height q^-(1 + H) and random phase."""
    refuse(positive_faults(rms_height=rms_height, longest=longest, shortest=shortest))
    ratio = longest / shortest * (1 + _ROUNDED)
    most = int(ratio)
    i, j = np.meshgrid(np.arange(0, most + 1), np.arange(-most, most + 1), indexing="ij")
    # one of each pair q, -q
    chosen = (i**2 + j**2 <= ratio**2) & ((i > 0) | (j > 0))
    i, j = i[chosen].astype(np.float64), j[chosen].astype(np.float64)
    refuse([] if i.size else [f"longest must be at least shortest = {shortest!r}, not {longest!r}"])
    heights = np.hypot(i, j) ** -(1 + hurst)
    heights *= rms_height / np.sqrt((heights**2).sum() / 2)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, i.size)
    unit = 2 * np.pi / longest
    return SurfaceWaves(heights, np.multiply(unit, i), np.multiply(unit, j), phases)


@dataclass(frozen=True)
class Ball:
    """A ball of radius R on an elastic half-space (E* infinite: rigid) under oil.

    `meniscus` is the distance from the middle at which the oil before the ball begins to fill the
    gap, more than Hertz's radius; by default the ball is flooded as far as it reaches. `waves` make
    it rough, up to 1.5 l: heights over the ball, which is at rest.
    """

    radius: float
    effective_modulus: float
    viscosity: float
    load: float
    meniscus: float = np.inf
    waves: SurfaceWaves | None = None

    def __post_init__(self) -> None:
        faults = positive_faults(radius=self.radius, viscosity=self.viscosity, load=self.load)
        for name in ("effective_modulus", "meniscus"):
            if not getattr(self, name) > 0:
                faults.append(f"{name} must be positive, not {getattr(self, name)!r}")
        refuse(faults)
        if self.meniscus <= self.hertz_radius:
            raise ValueError(
                f"meniscus must lie before the contact, whose radius is {self.hertz_radius:.3g}, "
                f"not at {self.meniscus!r}"
            )

    @property
    def hertz_radius(self) -> float:
        """Radius of the dry contact."""
        return formulas.hertz_radius(self.radius, self.effective_modulus, self.load)


@dataclass(frozen=True)
class PointFilm:
    """The film below a ball.

    `load` is the integral of the pressure, `penetration` how much closer the bodies are than at dry
    first touch. Friction on the half-space is `shear`, of sliding at a speed difference equal to
    `speed`, over r < R, and `drag`, of the pressure's flow. `x` and `y` are centres of the cells,
    of which those in `core` are equal; fields are (nx, ny). `error` is the largest relative
    imbalance, of mass or of forces.
    """

    speed: float
    film_central: float
    film_minimum: float
    load: float
    penetration: float
    shear: float
    drag: float
    x: Array = field(repr=False)
    y: Array = field(repr=False)
    core: tuple[slice, slice] = field(repr=False)
    pressure: Array = field(repr=False)
    thickness: Array = field(repr=False)
    vapour: Array = field(repr=False)
    area: Array = field(repr=False)
    error: float
    rounds: int


def entrain(ball: Ball, speed: float, resolution: int) -> PointFilm:
    """Return the steady film at one entrainment speed U, the mean of both surfaces'.

    On `resolution` cells per l = a + c. The speed is lowered from where the ball is as good as
    rigid, on coarse cells; finer ones start from the coarse film.

    >>> soft = Ball(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)
    >>> film = entrain(soft, 1e-2, 8)
    >>> round(1e6 * film.film_central, 1)
    13.7
    """
    refuse(positive_faults(speed=speed) + count_faults(_FEWEST, resolution=resolution))
    rigid_film = formulas.sphere_film(ball.radius, ball.viscosity, speed, ball.load)
    problem = _Scaled(ball, rigid_film)
    number = 12 * ball.viscosity * speed * ball.radius**2 / (ball.load * problem.length)
    # cells per l, from the fewest on which a film can start to those asked for
    coarsest: float = _COARSEST
    if ball.waves is not None:
        waves = problem.length / ball.waves.shortest
        if resolution < FEWEST_PER_WAVE * waves:
            raise ValueError(
                f"waves of {ball.waves.shortest:.3g} need {FEWEST_PER_WAVE} cells, "
                f"{int(np.ceil(FEWEST_PER_WAVE * waves))} per {problem.length:.3g}, "
                f"not {resolution}"
            )
        coarsest = max(_COARSEST, _COARSE_WAVE * waves)
    levels = [resolution]
    while levels[0] >= 2 * coarsest:
        levels.insert(0, levels[0] // 2)
    # The film of a rigid ball at that speed or a higher one, thicker than its displacement,
    # F/(pi E* c) with c = sqrt(2 h0); crests stay in the oil.
    grid = problem.on(levels[0])
    separation = max(
        (number * formulas.HALF_SOMMERFELD / 12) ** 2,
        (_STIFF * (grid.surface.compliance / np.pi) / np.sqrt(2)) ** (2 / 3),
    )
    separation += max(0.0, -float(grid.film.gap.min()))
    rigid = rigid_film_at(grid.film, separation)
    carried = float((rigid.pressure * grid.film.cells.area).sum())
    s = np.where(rigid.s > 0, rigid.s / carried, rigid.s)
    start = 1 / carried, FilmState(s, separation, rigid.displacement)
    # the speed is lowered on the coarsest cells; finer ones follow
    films, failure = _lowered(grid, [start], number, finest=levels[0] == resolution)
    for per_length in levels[1:]:
        coarse, grid = grid, problem.on(per_length)
        starts = [(at, _prolonged(coarse, film, grid)) for at, film in films]
        films, failed = _lowered(grid, starts, number, finest=per_length == resolution)
        failure = failed or failure
    if failure is not None and not (films and films[-1][0] == number):
        raise ConvergenceError(
            f"no film on {resolution} cells per {problem.length:.3g}: {failure}", failure.history
        )
    return problem.film_of(grid, films[-1][1], speed)


def approach(ball: Ball, speed: float, resolution: int) -> PointFilm:
    """Return the film below a ball that comes from afar at a speed V, when it carries the load.

    The load grows from where the ball is as good as rigid, step by step; the film is a function of
    it, for there is no other time. V is constant, far from the contact; steps of the load are finer
    with the cells per l.
    """
    refuse(positive_faults(speed=speed) + count_faults(_FEWEST, resolution=resolution))
    rigid = formulas.squeezed_film(ball.radius, ball.viscosity, speed, ball.load)
    problem = _Scaled(ball, rigid)
    number = 12 * ball.viscosity * speed * ball.radius**3 / (ball.load * problem.length**2)
    ratio = 1 - _FALL / resolution
    # a rigid film thick beside its displacement, w/(pi E* c): w^(3/2) < ...
    displacement = max(_STIFF * problem.compliance / np.pi, np.finfo(float).tiny)
    share = float(min(ratio**4, (np.pi * number / 2) ** 0.6 / displacement**0.4))
    full = problem.on(resolution, _SQUEEZED, _SQUEEZED_REACH)

    def squeezed(loaded: LoadedFilm) -> FilmState:
        """Return the film of a rigid ball under a load: p = 3 eta V R/h^2."""
        separation = np.pi * number / (2 * loaded.load)
        s = number / 4 / (loaded.film.gap + separation) ** 2
        return FilmState(s, separation, loaded.displacement(s))

    grid = replace(full, load=share)
    state, before = squeezed(grid), squeezed(replace(full, load=share * ratio))
    while share < 1:
        share = min(1.0, share / ratio)
        earlier, before = before, state
        grid = replace(full, load=share)
        guess = before.separation - 0.8 * (earlier.separation - before.separation)
        start = FilmState(before.s, guess, before.displacement)
        state = grid.solve(Transport(0.0, number, (before, earlier)), start)
    return problem.film_of(grid, state, speed)


class _Scaled:
    """A ball in units of its contact."""

    def __init__(self, ball: Ball, rigid_film: float) -> None:
        length = formulas.contact_length(ball.radius, ball.effective_modulus, ball.load, rigid_film)
        self.ball, self.length = ball, length
        self.thickness = length**2 / ball.radius
        self.pressure = ball.load / length**2
        self.compliance = ball.load * ball.radius / (ball.effective_modulus * length**3)

    def gap(self, x: Array, y: Array) -> Array:
        """Return the gap of the undeformed bodies where the smooth ball touches."""
        gap: Array = (x**2 + y**2) / 2
        if self.ball.waves is None:
            return gap
        heights = self.ball.waves.at(x * self.length, y * self.length) / self.thickness
        # one up to l, falling smoothly to zero at 1.5 l, where the gap is wide: farther out cells
        # grow, and would not resolve the waves
        faded = 0.5 + 0.5 * np.cos(np.pi * np.clip(2 * np.hypot(x, y) - 2, 0, 1))
        return gap - faded * heights

    def on(
        self, per_length: int, along: tuple[float, float] = _ALONG, reach: float = _REACH
    ) -> LoadedFilm:
        """Return the problem on cells."""
        begins = self.ball.meniscus / self.length
        reach = max(_AROUND, reach * (1 - self.ball.hertz_radius / self.length))
        even = self.ball.waves is None or self.ball.waves.even
        cells = around_point(per_length, along, _ACROSS, reach, begins, even)
        return LoadedFilm(Film(cells, self.gap), BentSurface(cells, self.compliance))

    def film_of(self, loaded: LoadedFilm, state: FilmState, speed: float) -> PointFilm:
        """Return a film in the units of the ball."""
        cells, ball = loaded.film.cells, self.ball
        x, y = cells.centres
        # The rate of shear over r < R, of cells that R cuts their share. Beyond the last cells
        # there is full film before the ball alone, h = r^2/2R, where there is oil.
        thickness = loaded.film.thickness(state)
        end = ball.radius / self.length
        inside = np.clip((end - np.hypot(x, y)) / np.maximum(*cells.widths) + 0.5, 0.0, 1.0)
        full = min(end, ball.meniscus / self.length)
        rest = 2 * np.pi * max(0.0, float(np.log(full / cells.x[-1])))
        shear = float((cells.area * inside * ((1 - state.vapour) / thickness)).sum()) + rest
        slope = np.diff(self.gap(cells.x[:, None], y), axis=0) / cells.widths[0]
        drag = 0.5 * abs(float((state.pressure * cells.area * slope).sum()))
        # at x = y = 0: across by the cubic of four cells, along by the line of two
        thickness = cells.whole(thickness)
        first = thickness.shape[1] // 2 - 2
        middle = thickness[:, first : first + 4] @ np.array([-1, 9, 9, -1]) / 16
        centre = float(np.interp(0.0, x.ravel(), middle))
        # the thinnest film: of the parabolas through the thinnest cell and its neighbours
        core = thickness[cells.whole_core]
        i, j = np.unravel_index(int(np.argmin(core)), core.shape)
        least = float(core[i, j])
        for line in (core[max(i - 1, 0) : i + 2, j], core[i, max(j - 1, 0) : j + 2]):
            if line.size == 3:
                before, between, after = line
                bend = before - 2 * between + after
                below = (after - before) ** 2 / (8 * bend) if bend > 0 else 0.0
                least -= below if below < least / 4 else 0.0  # a kink is no parabola
        return PointFilm(
            speed=speed,
            film_central=float(centre * self.thickness),
            film_minimum=float(least * self.thickness),
            load=float((state.pressure * cells.area).sum()) * ball.load,
            penetration=float(-state.separation * self.thickness),
            shear=shear * (ball.viscosity * speed * ball.radius),
            drag=float(drag) * ball.load * self.length / ball.radius,
            x=x.ravel() * self.length,
            y=cells.whole(y, odd=True).ravel() * self.length,
            core=cells.whole_core,
            pressure=cells.whole(state.pressure) * self.pressure,
            thickness=thickness * self.thickness,
            vapour=cells.whole(state.vapour),
            area=cells.whole(cells.area) / cells.copies * self.length**2,
            error=state.error,
            rounds=state.rounds,
        )


def _lowered(
    loaded: LoadedFilm, starts: list[tuple[float, FilmState]], number: float, *, finest: bool
) -> tuple[list[tuple[float, FilmState]], ConvergenceError | None]:
    """Lower the speed to a number, or as far as films go that the cells resolve; and what ended it.

    Of the films nearby, `starts`, the slowest that leads to a film is taken. On the `finest` cells
    the last film is the answer; all others are starts, balanced roughly.
    """
    closest = _CLOSEST if finest else _NEAR_ENOUGH

    def solved(speed: float, start: FilmState) -> FilmState:
        flow = Transport(speed)
        return loaded.solve(flow, start, _BALANCED if finest and speed == number else _ROUGHLY)

    films: list[tuple[float, FilmState]] = []
    ratio, failure = _RATIO, None
    while not films and starts:
        reached, start = starts.pop()
        try:
            films = [(reached, solved(reached, start))]
        except ConvergenceError as error:
            failure = error
    while films and films[-1][0] != number and ratio <= closest:
        reached, state = films[-1]
        # equal steps, none of them short
        steps = max(1, int(np.ceil(np.log(number / reached) / np.log(ratio))))
        target = number if steps == 1 else reached * (number / reached) ** (1 / steps)
        try:
            films.append((target, solved(target, state)))
        except ConvergenceError as error:
            failure, ratio = error, float(np.sqrt(ratio))
    return films, failure


def _prolonged(coarse: LoadedFilm, state: FilmState, fine: LoadedFilm) -> FilmState:
    """Return a film between coarse cells on finer ones, lifted where it would be too thin.

    Pressure and vapour are interpolated apart, by Akima's curves, which neither overshoot where the
    film ruptures nor kink: straight lines kink at every coarse cell, where thin films are lost.
    """
    grids = coarse.film.cells, fine.film.cells

    def between(values: Array) -> Array:
        whole = grids[0].whole(values)
        for axis in (0, 1):
            source, target = (
                cells.whole(cells.centres[axis], odd=True).ravel()
                if axis
                else cells.centres[0].ravel()
                for cells in grids
            )
            curve = Akima1DInterpolator(source, whole, axis=axis)
            whole = curve(np.clip(target, source[0], source[-1]))
        return np.asarray(whole)[:, -grids[1].shape[1] :]

    pressure, vapour = between(state.pressure), between(state.vapour)
    full = between(np.sign(state.s)) > 0
    s = np.where(full, np.maximum(pressure, _TINY), -np.clip(vapour, _TINY, 1.0))
    film = FilmState(s, state.separation, fine.displacement(np.maximum(s, 0.0)))
    least = 0.7 * float(coarse.film.thickness(state).min())
    short = least - float(fine.film.thickness(film).min())
    return replace(film, separation=state.separation + max(0.0, short))
