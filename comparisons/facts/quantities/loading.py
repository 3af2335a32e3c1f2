"""What load steps are walked along, where it is no load: never compared itself."""

from comparisons.facts.quantities.row import Quantity

ROWS = (
    Quantity("time", "time", "t", "s"),
    Quantity("speed", "sliding speed", "v", "m/s"),
    Quantity("velocity", "velocity of impact", "v₀", "m/s"),
    Quantity("step", "step of the path"),
)
