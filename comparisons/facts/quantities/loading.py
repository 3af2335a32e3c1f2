"""Parameters of load steps other than loads (time, speed, ...), which are never compared."""

from comparisons.facts.quantities.row import Quantity

ROWS = (
    Quantity("time", "time", "t", "s"),
    Quantity("speed", "speed", "v", "m/s"),
    Quantity("velocity", "velocity of impact", "v₀", "m/s"),
    Quantity("sliding_distance", "sliding distance", "s", "m"),
    Quantity("cycles", "cycles", "n"),
    Quantity("step", "step of the path"),
)
