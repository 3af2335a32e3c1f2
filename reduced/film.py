"""Reynolds' equation in one dimension, over a line of springs.

    d/dx (h^3 dP/dx) = L d/dx[(1 - theta) h] (entrained),   = 12 eta dh/dt (squeezed),
    h = h0 + x^2/R + w,    int E* w dx = F,    P >= 0, theta >= 0, P theta = 0,

with mass-conserving cavitation. What the pressure P of the film on a spring means for its force
per length q = E* w is a choice that the model leaves open:

- "local": P is the stress of the local rule (19.37), P = (E*/pi) sqrt(2 w/R1), R1 = R/2: in Hertz's
  units P = sqrt Q;
- "hertz": P = q/B, B = pi a/2, with which P = Q in these units;
- "rigid": P = q/B, B = beta sqrt(R h0) of a rigid ball: beta = 4 when squeezed, 5.33 when entrained
  (half-Sommerfeld). No one width serves both, nor a soft ball.

Everything is solved in units of l = a + c, a Hertz's radius and c the reach of a rigid film.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from scipy.linalg import solve_banded

from reduced.errors import ConvergenceError, choice_faults, count_faults, positive_faults, refuse

Rule = Literal["local", "hertz", "rigid"]
RULES = ("local", "hertz", "rigid")
# Widths of a rigid ball's film over sqrt(R h0): 4, and 10.66/2.
SQUEEZED, ENTRAINED = 4.0, 12 / 5 * np.pi / np.sqrt(2)

_BEGIN, _END = -2.5, 1.5
# Half-widths of the cells in l: a squeezed film's force beyond x falls as 1/x^3, and its pressures
# far out drown in round-off, which grows as x^2.
_GROWTH, _REACH, _SQUEEZED_REACH = 1.1, 1e3, 50.0
_FEWEST = 4
_TRIED = 1000  # films, at most, for the first one
_ROUNDS, _KEPT, _TOLERANCE, _LOST = 60, 0.35, 1e-11, 1e8
# The flow through stiff springs is a small difference: where its error, of second order before,
# no longer falls for some rounds, it is round-off, and what is reached is the film.
_ROUND_OFF, _STILL = 1e-8, 3
_RATIO, _CLOSEST, _STIFF, _FALL = 0.45, 0.95, 0.1, 1.0


@dataclass(frozen=True)
class Ball:
    """A ball of radius R on springs under oil.

    A rough one has `heights` over x, those of its section y = 0 as it is; up to 1.5 l.
    """

    radius: float
    effective_modulus: float
    viscosity: float
    load: float
    rule: Rule = "local"
    heights: Callable[[np.ndarray], np.ndarray] | None = None

    def __post_init__(self) -> None:
        numbers = {k: v for k, v in vars(self).items() if k not in ("rule", "heights")}
        refuse(positive_faults(**numbers) + choice_faults("rule", self.rule, RULES))


@dataclass(frozen=True)
class LineFilm:
    """The film on a line.

    `penetration` is how much closer the bodies are than at dry first touch. Shear is the friction
    of sliding at a speed difference equal to the speed, over the width q/P that the film of a
    spring stands for, drag that of the pressure's flow. The error is the largest imbalance of mass
    in a cell, relative, or of forces.
    """

    film_central: float
    film_minimum: float
    load: float
    penetration: float
    shear: float
    drag: float
    x: np.ndarray = field(repr=False)
    pressure: np.ndarray = field(repr=False)
    thickness: np.ndarray = field(repr=False)
    vapour: np.ndarray = field(repr=False)
    error: float


@dataclass(frozen=True)
class _State:
    """Pressure or, negative, vapour in every cell, and the separation."""

    s: np.ndarray
    separation: float
    error: float = np.inf


def entrain(ball: Ball, speed: float, resolution: int) -> LineFilm:
    """Return the steady film at an entrainment speed U, the mean of both surfaces'.

    Cells have the width l/resolution; ConvergenceError if the film is too thin for them.
    """
    refuse(positive_faults(speed=speed) + count_faults(_FEWEST, resolution=resolution))
    reach = 2 * ENTRAINED * ball.viscosity * speed * ball.radius**2 / ball.load
    line = _FilmLine(ball, np.sqrt(2) * reach, ENTRAINED, _edges(resolution, _REACH))
    number = 12 * ball.viscosity * speed * ball.radius**2 / (ball.load * line.length)
    reached, state = line.start(number)
    state, ratio = line.solved(_Flow(line, reached), state, 1.0), _RATIO
    while reached != number:
        target = number if number >= reached * ratio else reached * ratio
        try:
            state, reached = line.solved(_Flow(line, target), state, 1.0), target
        except ConvergenceError:
            ratio = float(np.sqrt(ratio))
            if ratio > _CLOSEST:
                raise
    return line.film(state, speed)


def approach(ball: Ball, speed: float, resolution: int) -> LineFilm:
    """Return the film below a ball that comes from afar at a speed, when it carries the load."""
    refuse(positive_faults(speed=speed) + count_faults(_FEWEST, resolution=resolution))
    rigid = 6 * np.pi * ball.viscosity * ball.radius**2 * speed / ball.load
    reach = np.sqrt(2 * ball.radius * rigid)
    line = _FilmLine(ball, reach, SQUEEZED, _edges(resolution, _SQUEEZED_REACH))
    number = 12 * ball.viscosity * speed * ball.radius**3 / (ball.load * line.length**2)
    ratio = 1 - _FALL / resolution
    share, before, state = line.squeezed(number, ratio)
    while share < 1:
        share = min(1.0, share / ratio)
        earlier, before = before, state
        guess = _State(before.s, before.separation - 0.8 * (earlier.separation - before.separation))
        state = line.solved(_Flow(line, 0.0, number, before, earlier), guess, share)
    return line.film(state, speed)


class _FilmLine:
    """The cells of a line, and its springs, in units of l."""

    def __init__(self, ball: Ball, reach: float, width: float, edges: np.ndarray) -> None:
        hertz = float(np.cbrt(0.75 * ball.load * ball.radius / ball.effective_modulus))
        self.ball, self.length = ball, hertz + float(reach)
        self.end = ball.radius / self.length
        if self.end < 3:
            raise ValueError(
                f"the film or the contact reaches {self.length:.3g}: no ball of radius "
                f"{ball.radius:.3g} is a paraboloid there"
            )
        self.edges = edges
        self.x = (self.edges[1:] + self.edges[:-1]) / 2
        self.dx = np.diff(self.edges)
        self.gap, self.face_gap = self._gap(self.x), self._gap(self.edges)
        ends = np.concatenate([self.edges[:1], self.x, self.edges[-1:]])
        self.conductance = 1 / np.diff(ends)
        self.softness = ball.load * ball.radius / (ball.effective_modulus * self.length**3)
        # B over l: c = sqrt(2 R h0)
        own = np.pi * hertz / 2 if ball.rule == "hertz" else width * reach / np.sqrt(2)
        self.width = own / self.length

    def _gap(self, x: np.ndarray) -> np.ndarray:
        """Return x^2 less the heights of a rough ball, which fade from l to 1.5 l."""
        if self.ball.heights is None:
            return x**2
        fades = 0.5 + 0.5 * np.cos(np.pi * np.clip(2 * np.abs(x) - 2, 0, 1))
        unit = self.length**2 / self.ball.radius
        return x**2 - fades * self.ball.heights(x * self.length) / unit

    def springs(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacement under a pressure, and its derivative."""
        if self.ball.rule == "local":
            bend = (np.pi * self.softness / 2) ** 2
            return bend * p**2, 2 * bend * p
        slope = self.softness * self.width
        return slope * p, np.where(p > 0, slope, 0.0)

    def faces(self, state: _State, w: np.ndarray) -> np.ndarray:
        """Return the film in the faces."""
        ends = np.concatenate([w[:1], (w[1:] + w[:-1]) / 2, w[-1:]])
        return self.face_gap + state.separation + ends

    def start(self, number: float) -> tuple[float, _State]:
        """Return a speed at or above a number, and the film of a ball that bends little there."""
        below = 2 * max(0.0, -float(self.gap.min()))
        for separation in below + 0.5 * 2.0 ** np.arange(_TRIED):
            s = np.where(self.x < 0, -self.x / (self.gap + separation) ** 2, -0.5)
            flow, state = _Flow(self, 1.0), _State(s, separation)
            rigid = np.zeros(s.size)
            for _ in range(_ROUNDS):
                mass, _, bands, _ = flow.equations(state, rigid, np.zeros(s.size))
                s = state.s - solve_banded((1, 1), bands, mass)
                settled, state = not ((s > 0) != (state.s > 0)).any(), _State(s, separation)
                if settled:
                    break
            p = np.maximum(state.s, 0.0)
            carried = float(self.springs(p)[0] @ self.dx) / self.softness
            speed = 1 / (np.sqrt(carried) if self.ball.rule == "local" else carried)
            bent = float(self.springs(speed * p)[0].max())
            if speed >= number and bent < _STIFF * separation:
                return speed, _State(np.where(s > 0, speed * s, s), separation)
        raise ConvergenceError("no ball so high that it is as good as rigid", [])

    def squeezed(self, number: float, ratio: float) -> tuple[float, _State, _State]:
        """Return a light load, the film that carries it, and that of a lighter one, both rigid."""

        def at(separation: float) -> tuple[float, float, _State]:
            p = number / 4 / (self.gap + separation) ** 2
            w = self.springs(p)[0]
            return float(w @ self.dx) / self.softness, float(w.max()), _State(p, separation)

        for separation in 1e-3 * 1.1 ** np.arange(_TRIED):
            share, bent, state = at(separation)
            if share < ratio**2 and bent < _STIFF * separation:
                return share, at(separation / ratio)[2], state
        raise ConvergenceError("no load so light that the ball is as good as rigid", [])

    def solved(self, flow: _Flow, start: _State, share: float) -> _State:
        """Return the film that carries a share of the load, by Newton's method."""
        state, best = start, start
        highest = np.inf if flow.before is None else flow.before.separation  # bodies come closer
        history: list[float] = []
        for _ in range(_ROUNDS):
            w, slope = self.springs(np.maximum(state.s, 0.0))
            mass, scale, bands, by_separation = flow.equations(state, w, slope)
            force = float(w @ self.dx) / self.softness - share
            error = max(float(np.abs(mass / scale).max()), abs(force) / share)
            if not history or error < min(history):
                best = _State(state.s, state.separation, error)
            history.append(error)
            still = len(history) - 1 - history.index(min(history))
            if best.error <= _TOLERANCE or (best.error < _ROUND_OFF and still >= _STILL):
                return best
            if not error <= _LOST:
                break
            try:
                part, answer = solve_banded((1, 1), bands, np.array([mass, by_separation]).T).T
            except np.linalg.LinAlgError:
                break
            push = slope * self.dx / self.softness
            # A ds + c dl = -m and push ds = -f: dl = (f - push A^-1 m)/(push A^-1 c)
            rise = (force - float(push @ part)) / float(push @ answer)
            # shortened where the film would become too thin
            before, kept = self.gap + state.separation + w, 1.0
            for _ in range(40):
                s = state.s + kept * (-part - rise * answer)
                separation = state.separation + kept * rise
                after = self.gap + separation + self.springs(np.maximum(s, 0.0))[0]
                if (after > _KEPT * before).all() and separation < highest:
                    break
                kept /= 2
            state = _State(s, separation)
        raise ConvergenceError("the film on the line is too thin for its cells", history)

    def film(self, state: _State, speed: float) -> LineFilm:
        """Return a film in the units of the ball."""
        ball, unit = self.ball, self.length**2 / self.ball.radius
        p = np.maximum(state.s, 0.0)
        w, _ = self.springs(p)
        h, q = self.gap + state.separation + w, w / self.softness
        strip = np.divide(q, p, out=np.zeros(p.size), where=p > 0)
        strip *= np.clip((self.end - np.abs(self.x)) / self.dx + 0.5, 0.0, 1.0)  # below the ball
        # the least film: of the parabola through the thinnest cell and its neighbours
        i = min(max(int(np.argmin(h)), 1), h.size - 2)
        before, middle, after = h[i - 1 : i + 2]
        bend = before - 2 * middle + after
        below = (after - before) ** 2 / (8 * bend) if bend > 0 else 0.0
        least = float(middle - (below if below < middle / 4 else 0.0))  # a kink is no parabola
        return LineFilm(
            film_central=float(np.interp(0.0, self.x, h)) * unit,
            film_minimum=least * unit,
            load=float(q @ self.dx) * ball.load,
            penetration=-state.separation * unit,
            shear=float((strip / h) @ self.dx) * ball.viscosity * speed * ball.radius,
            drag=abs(float(q @ np.diff(self.face_gap))) / 2 * ball.load * self.length / ball.radius,
            x=self.x * self.length,
            pressure=p * ball.load / self.length**2,
            thickness=h * unit,
            vapour=np.maximum(-state.s, 0.0),
            error=state.error,
        )


@dataclass(frozen=True)
class _Flow:
    """What flows along the line, and what a thicker film keeps.

    Surfaces draw the film along x, L = 12 eta U (`speed`), or approach at V, L = 12 eta V
    (`approach`): then the separation is the clock, and `before` and `earlier` are the films of the
    two steps before this.
    """

    line: _FilmLine
    speed: float
    approach: float = 0.0
    before: _State | None = None
    earlier: _State | None = None

    def equations(
        self, state: _State, w: np.ndarray, slope: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the balance of mass of the cells, its scale, and its derivatives.

        Those are by s, three diagonals, and by the separation; `slope` is dw/dp.
        """
        line, speed, full = self.line, self.speed, state.s > 0
        h, film = line.faces(state, w), line.gap + state.separation + w
        p, vapour = np.maximum(state.s, 0.0), np.maximum(-state.s, 0.0)
        steps = np.diff(np.concatenate([[0.0], p, [0.0]]))  # across the faces
        by_p = line.conductance * h**3
        flow = speed * h - by_p * steps
        flow[1:] -= speed * vapour * film
        mass, through = np.diff(flow), p * (by_p[1:] + by_p[:-1])
        by_h = speed - 3 * line.conductance * h**2 * steps
        before, after = by_h / 2, by_h / 2
        after[0] *= 2
        before[-1] *= 2
        # of each face by the s of the cells on its two sides
        left = np.where(full, by_p[1:] + before[1:] * slope, 0.0)
        left += speed * np.where(full, 0.0, film)
        right = np.where(full, -by_p[:-1] + after[:-1] * slope, 0.0)
        bands = np.array([right, left - right, -left])
        by_h[1:] -= speed * vapour
        by_separation = np.diff(by_h)
        if self.before is None or self.earlier is None:
            return mass, speed * film + through, bands, by_separation

        # what the thicker film keeps: a backward difference of second order over three films
        fall = self.before.separation - state.separation
        last = self.earlier.separation - self.before.separation

        def weights(fall: float) -> np.ndarray:
            both = fall + last
            return np.array(
                [(fall + both) / (fall * both), -both / (fall * last), fall / (last * both)]
            )

        past = (line.springs(s.s)[0] + s.separation for s in (self.before, self.earlier))
        films = line.gap + np.array([w + state.separation, *past])
        step, kept, now = 1e-6 * fall, self.approach * line.dx, weights(fall)
        turned = (weights(fall + step) - weights(fall - step)) / (2 * step)
        bands[1] += kept * now[0] * slope
        by_separation = by_separation + kept * (now[0] - turned @ films)
        return mass + kept * (now @ films), kept + through, bands, by_separation


def _edges(resolution: int, reach: float) -> np.ndarray:
    """Return equal cells in the middle, wider and wider ones around them."""
    inner = np.linspace(_BEGIN, _END, round((_END - _BEGIN) * resolution) + 1)
    step, growth = inner[1] - inner[0], min(_GROWTH, 1 + 1.5 / resolution)
    sides = []
    for length in (reach + _BEGIN, reach - _END):
        count = max(1, int(np.log1p(length / step * (growth - 1)) / np.log(growth)))
        grown = np.cumsum(growth ** np.arange(1, count + 1))
        sides.append(grown * (length / grown[-1]))
    return np.concatenate([_BEGIN - sides[0][::-1], inner, _END + sides[1]])
