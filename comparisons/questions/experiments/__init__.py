"""The experiments, by name; one module per statement or family of statements."""

from __future__ import annotations

from comparisons.questions.experiments import (
    active_set,
    adhesive_face,
    adhesive_range,
    analogies,
    asperities,
    bodies,
    contact_ends,
    contact_statistics,
    cost,
    dry_oscillator,
    elements,
    equivalent_body,
    film_plane,
    films,
    friction_judges,
    friction_law,
    harmonic,
    impact,
    kernel,
    line_statistics,
    neighbours,
    outline_rules,
    partial_slip,
    particles,
    procedure,
    proved,
    published_ensemble,
    reading_scan,
    relaxation,
    ridges,
    rolling,
    rough_adhesion,
    rough_area,
    rough_rubber,
    rough_slip,
    rough_yield,
    rubber_sliding,
    second_truth,
    sheets,
    stress_below,
    stress_use,
    tangential,
    two_bodies,
    vibration,
    wear,
    yielding,
)
from comparisons.questions.experiments.base import Experiment, Measurement

# Every module of this package defines a tuple EXPERIMENTS; this is the list of modules.
_MODULES = (
    *(kernel, active_set, bodies, neighbours, impact),
    *(line_statistics, rough_area, reading_scan, stress_use, two_bodies, cost),
    *(friction_law, harmonic, tangential, rubber_sliding, adhesive_face, adhesive_range),
    *(rough_slip, dry_oscillator, vibration, partial_slip, equivalent_body, procedure, ridges),
    *(relaxation, proved, rolling, yielding, rough_yield, particles, elements, films, wear),
    *(outline_rules, sheets, asperities, contact_statistics, published_ensemble),
    *(second_truth, stress_below, film_plane),
    *(contact_ends, analogies, rough_rubber, friction_judges, rough_adhesion),
)
EXPERIMENTS: dict[str, Experiment] = {
    experiment.name: experiment for module in _MODULES for experiment in module.EXPERIMENTS
}

__all__ = ["EXPERIMENTS", "Experiment", "Measurement"]
