"""The truth of a scene as it is kept with the results."""

from __future__ import annotations

from dataclasses import dataclass, field

from comparisons.facts.methods import CLOSED_FORM
from comparisons.judging.proofs import Verification
from comparisons.judging.verdicts import Number


@dataclass(frozen=True)
class Bar:
    """The widest bar of a quantity on the very same surfaces, and at which load step."""

    bar: Number
    step: int


@dataclass(frozen=True)
class Reference:
    """Which solution the others were compared with, and how well it is known.

    Attributes
    ----------
    method, resolution, text : str, int, str
        "" where there is none; the text is a sentence.
    uncertainty : dict
        Quantity -> relative 95 % half-width, rms over the load steps; NaN where not known.
    sources : dict
        Quantity -> source -> its part of that.
    bars : dict
        Quantity that it gives -> `Bar`.
    footnotes : tuple of str
        Disagreements that are small against the tolerance, in words.
    proved : Verification, optional
        Its bars held against theorems.
    chance : str
        Why lines that agree with it do so by chance (`comparisons.results.scene_record`).
    """

    method: str
    resolution: int
    text: str
    uncertainty: dict[str, Number] = field(default_factory=dict)
    sources: dict[str, dict[str, Number]] = field(default_factory=dict)
    bars: dict[str, Bar] = field(default_factory=dict)
    footnotes: tuple[str, ...] = ()
    proved: Verification | None = None
    chance: str = ""

    @property
    def exact(self) -> bool:
        """Whether it is a closed form."""
        return self.method == CLOSED_FORM


NO_REFERENCE = Reference("", 0, "")
