"""Explanations of the terms and definitions of the measures that the report uses."""

from __future__ import annotations

from comparisons.results.record import WHERE

TERMS = {
    "reduced": (
        "reduced model",
        "The method of dimensionality reduction: the three-dimensional contact is replaced by a "
        "row of independent springs indented by an equivalent one-dimensional profile. This is the "
        "model under test.",
    ),
    "bem": (
        "BEM",
        "Boundary element method: only the surface of an elastic half-space is discretised, into "
        "cells of uniform pressure. 'Dense' stores every influence coefficient; 'FFT' evaluates "
        "the convolution by fast Fourier transforms.",
    ),
    "mca": (
        "MCA",
        "Movable cellular automata: the body is a packing of particles with forces between them.",
    ),
    "fem": (
        "FEM",
        "Finite element method: the whole body is discretised, into small bricks. 'FFT FEM': below "
        "rough surfaces and in layers the mesh repeats from cell to cell, so that each wave of the "
        "surface is a problem of one column of bricks; as fast as boundary elements.",
    ),
    "closed-form": (
        "closed form",
        "A formula that solves the contact problem exactly, such as that of Hertz.",
    ),
    "half-space": (
        "half-space",
        "An elastic body that fills all the space below a plane: a good approximation of any body "
        "that is large compared with the contact.",
    ),
    "penetration": (
        "penetration depth",
        "The displacement of the rigid indenter towards the body since first contact.",
    ),
    "effective-modulus": (
        "effective modulus E*",
        "E* = E/(1 − ν²) for one elastic body; for two, their compliances 1/E* add.",
    ),
    "contact-area": (
        "contact area",
        "The area that carries pressure. Counting cells overestimates it; the value shown ends at "
        "the contact line, located inside the cells from pressure and gap (with friction, adhesion "
        "or memory it is corrected for the perimeter), and the counted value is kept as 'raw'.",
    ),
    "stiffness": (
        "contact stiffness",
        "The derivative of the force with respect to penetration at fixed contact area.",
    ),
    "mean-gap": ("mean gap", "The distance between the two surfaces, averaged over the area."),
    "resolution": (
        "resolution N",
        "Springs, cells or elements per contact radius at the largest load; for rough surfaces, "
        "points per side.",
    ),
    "realisation": ("realisation", "One of many random rough surfaces with the same statistics."),
    "standard-error": (
        "standard error",
        "The expected deviation of a mean over a few realisations from the ensemble mean.",
    ),
    "reference": (
        "reference",
        "The most accurate solution of a scene, with which all others are compared.",
    ),
    "uncertainty": (
        "uncertainty",
        "The half-width of an error, combining the scatter of the realisations and the "
        f"discretisation errors of the reference and of the reduced model: {WHERE}.",
    ),
    "tolerance": ("tolerance", "The relative error that is acceptable for the scene."),
    "von-mises": (
        "von Mises stress",
        "An equivalent stress that measures how close the material is to yielding.",
    ),
    "set-up": (
        "set-up",
        "The part of the time that further loads on the same scene would not need again.",
    ),
    "violation": (
        "violation",
        "The violation of the contact conditions: the largest overlap of the surfaces or tension "
        "between them, relative to penetration or pressure.",
    ),
    "unknowns": ("unknowns", "The number of unknowns in the discretised problem."),
    "path": (
        "path",
        "An ordered sequence of loads, increasing or decreasing. With friction, adhesion or "
        "viscoelasticity the state depends on the preceding loads.",
    ),
    "partial-slip": (
        "stick and slip",
        "Under a tangential load a contact slips from its edge inwards while its centre still "
        "sticks. In full slip the tangential force is µ times the normal force.",
    ),
    "viscoelastic": (
        "viscoelastic",
        "A material whose force relaxes after a step in penetration, and whose penetration creeps "
        "after a step in force.",
    ),
    "pull-off": (
        "pull-off force",
        "The largest tensile force needed to separate adhesive surfaces.",
    ),
    "jkr": (
        "JKR",
        "Johnson, Kendall and Roberts: adhesion of vanishing range, which acts only at the edge of "
        "the contact.",
    ),
    "restitution": (
        "coefficient of restitution",
        "The speed after an impact divided by the speed before it.",
    ),
    "singular": (
        "singular pressure",
        "In linear elasticity the pressure is unbounded at a sharp edge or tip.",
    ),
}

MEASURES = (
    (
        "Relative error",
        "(value − reference) / reference at every step, at the same prescribed load: force, area "
        "and others at equal penetration; penetration, area and others at equal force.",
    ),
    (
        "Error along a path",
        "(value − reference) / largest magnitude of the reference along the path, at the same step "
        "or time, because values may pass through zero. Prescribed quantities are not compared.",
    ),
    (
        "Largest and rms error",
        "The largest magnitude, bar included, and the root mean square of the relative error over "
        "all load steps, never at a single depth.",
    ),
    (
        "Pressure error",
        "The area-weighted rms difference over the contact area of the reference, divided by the "
        "rms of the reference pressure. Where the reference is singular, a ring of stated width is "
        "left out.",
    ),
    ("Ensembles", "The ratio of the means over the realisations, with its standard error."),
    (
        "Verdict",
        "With the error e, its uncertainty u and the tolerance t: within if |e| + u ≤ t at every "
        "load step; outside if |e| − u > t at any; otherwise not resolved. Each quantity is "
        "compared at equal prescribed load (the prescribed one, force or penetration, at an equal "
        "value of the other); the deciding step is named. The worst quantity decides; a quantity "
        "that the method does not compute is no result. Verdicts, advice and tables use the same "
        "rule.",
    ),
    (
        "Time",
        "The total time of a method for the scene, including the mesh or the spectrum and all load "
        "steps, excluding compilation and imports; median of repeats. The set-up is the part that "
        "other loads could reuse. Every time was measured on a setting that was run; times within "
        "a factor of 1.5 are not ranked.",
    ),
)
