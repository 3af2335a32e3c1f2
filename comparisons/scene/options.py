"""Options of the built-in methods, set by [methods.NAME] in a scene or by --option."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Annotated, Any, Literal

from pydantic import Field

from comparisons.scene.fields import Finite, Positive, SceneTable

# The options that have been read, by class and key, while somebody records them.
_read: ContextVar[set[tuple[type, str]] | None] = ContextVar("read", default=None)


class Options(SceneTable):
    """Base of all options: unknown keys are errors."""

    def __getattribute__(self, name: str) -> Any:
        """Return an attribute; where options are recorded (`recorded`) it counts as read."""
        read = _read.get()
        if read is not None and name in type(self).model_fields:
            read.add((type(self), name))
        return super().__getattribute__(name)

    @property
    def changes(self) -> dict[str, Any]:
        """The options that differ from their defaults; looking at them is no reading."""
        return self.model_dump(exclude_defaults=True)

    def changed(self) -> str:
        """Return the changes as ``key=value`` text."""
        return " ".join(f"{key}={value}" for key, value in sorted(self.changes.items()))


@contextmanager
def recorded() -> Iterator[set[tuple[type, str]]]:
    """Record which options are read meanwhile, by class and key.

    >>> with recorded() as read:
    ...     ReducedOptions().edges
    'sub_cell'
    >>> {key for _, key in read}
    {'edges'}
    """
    read: set[tuple[type, str]] = set()
    token = _read.set(read)
    try:
        yield read
    finally:
        _read.reset(token)


class ClosedFormOptions(Options):
    """A closed form has no options."""


class ReducedOptions(Options):
    """Options of the reduced model."""

    # "mdr" is the exact transform; "half_radius" the chapter's (19.17), for every shape.
    rule: Literal["mdr", "half_radius"] = "mdr"
    # "abel" is exact for axisymmetric bodies; "local" is (19.37) with the curvature at each spring,
    # "one_radius" with the radius of the parabola of the contact's size and depth.
    stress: Literal["abel", "local", "one_radius"] = "abel"
    # "sub_cell" finds the contact edge inside a cell; "nodal" are the printed sums.
    edges: Literal["sub_cell", "nodal"] = "sub_cell"
    # "rings" keeps the rms height exactly; "printed" samples (19.26); "split" keeps height and
    # slope.
    spectrum: Literal["rings", "printed", "split"] = "rings"
    # Of a layered body: E* of the "substrate", the table's own; that of the uppermost "layer"; or
    # an "effective" one for the contact radius (Xu & Pharr 2006).
    layers: Literal["substrate", "layer", "effective"] = "substrate"
    # Length of a rough line in units of the surface's side L.
    line_length: Annotated[Positive, Field(le=1e4)] = 1.0
    # Points of a rough line; by default those that resolve its shortest wave.
    line_points: Annotated[int, Field(strict=True, ge=8, le=2**26)] | None = None
    # "springs" have G*; "matched" a stiffness with which small creep of a circle is right.
    rolling: Literal["springs", "matched"] = "springs"
    # What the pressure of an oil film means to the springs: the stress of the "local" rule, or
    # their force over the width of "hertz" or of a "rigid" ball.
    film: Literal["local", "hertz", "rigid"] = "local"


class DenseOptions(Options):
    """Options of the dense half-space solver: the largest contact it accepts, in cells."""

    max_cells: Annotated[int, Field(strict=True, ge=1, le=5000)] = 5000


class FftOptions(Options):
    """Options of the FFT half-space solver."""

    # Largest overlap outside and tension inside the contact, relative.
    tolerance: Annotated[Positive, Field(gt=1e-13, lt=1e-2)] = 1e-8
    # Of the periodic half-space: "continuum" |q|, or that of uniform pressure on "cells".
    kernel: Literal["continuum", "cells"] = "continuum"


class FemOptions(Options):
    """Options of the finite-element solver; `penalty` is in units of E*/h."""

    # Of a half-space: "nested_dissection", or "conjugate_gradients", which condense nothing and
    # take rigid single contacts; "automatic" is nested dissection up to 300 000 unknowns, and
    # conjugate gradients where they can above, with nu up to 0.499. Of a [body]:
    # "nested_dissection", or "conjugate_gradients" with algebraic multigrid, which "automatic"
    # takes above 200 000 unknowns with nu up to 0.49.
    solver: Literal["automatic", "nested_dissection", "conjugate_gradients"] = "automatic"

    contact: Literal["active_set", "penalty", "augmented_lagrangian"] = "active_set"
    penalty: Positive = 1e3
    # Where an indenter and a half-space meet: in the mesh's "nodes", or in the "quadrature" points
    # of its surface, with contact = "penalty" only.
    points: Literal["nodes", "quadrature"] = "nodes"
    # Of an indenter with a [counter_body]: "effective_modulus" puts both compliances into one,
    # exact without friction; "mortar" or "node_to_surface" mesh both bodies.
    coupling: Literal["effective_modulus", "mortar", "node_to_surface"] = "effective_modulus"
    # Below a rough surface: "repeating" from cell to cell, solved wave by wave, or a "block",
    # condensed like any other mesh (free patches of up to 32 points a side).
    mesh: Literal["repeating", "block"] = "repeating"
    # Of a repeating mesh: quadratic "splines", bilinear ("linear") in the plane, or "quadratic"
    # hexahedra of 27 nodes.
    element: Literal["splines", "linear", "quadratic"] = "splines"
    # Of a repeating mesh: "clamped" two periods down, or the "impedance" of a half-space eight
    # cells down, a theory that it shares with `bem_fft`.
    bottom: Literal["clamped", "impedance"] = "clamped"
    # Of a body that rolls, rho V^2/G; the pressure is that at rest.
    inertia: Annotated[Finite, Field(ge=0, le=0.5)] = 0.0


class McaOptions(Options):
    """Options of the automata."""

    # Largest imbalance of their forces, relative to the reactions.
    balance: Annotated[Positive, Field(gt=1e-12, lt=1e-2)] = 1e-6
    # Of an indenter or a rough patch with a [counter_body]: "effective_modulus" puts both
    # compliances into one half-space, "automata" packs both bodies.
    coupling: Literal["effective_modulus", "automata"] = "effective_modulus"


class PeerOptions(Options):
    """Options of other people's solvers."""

    # Largest violation as we measure it; the peer's own tolerance follows from it.
    tolerance: Annotated[Positive, Field(gt=1e-13, lt=1e-2)] = 1e-8
    seconds: Positive = 600.0  # limit of wall-clock time of one task in the peer's process


class NgSolveOptions(Options):
    """Options of `ngsolve`: limit of wall-clock time of one task in its process."""

    seconds: Positive = 600.0


class MethodOptions(Options):
    """The tables [methods.NAME] of a scene."""

    closed_form: ClosedFormOptions = ClosedFormOptions()
    reduced: ReducedOptions = ReducedOptions()
    bem_dense: DenseOptions = DenseOptions()
    bem_fft: FftOptions = FftOptions()
    fem: FemOptions = FemOptions()
    mca: McaOptions = McaOptions()
    tamaas: PeerOptions = PeerOptions()
    contactmechanics: PeerOptions = PeerOptions()
    ngsolve: NgSolveOptions = NgSolveOptions()

    def of(self, method: str) -> Options:
        """Return the options of one method: none for a method that has no model here."""
        chosen: Any = getattr(self, method, Options())
        return chosen
