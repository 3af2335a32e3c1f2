"""The terms of the field, each explained once, and the definitions of what is measured."""

from __future__ import annotations

TERMS = {
    "reduced": (
        "reduced model",
        "The method of dimensionality reduction: the three-dimensional contact is replaced by a "
        "row of independent springs under an equivalent one-dimensional profile. This is the "
        "model under test.",
    ),
    "bem": (
        "BEM",
        "Boundary element method: only the surface of an elastic half-space is divided into cells "
        "of uniform pressure. 'Dense' keeps every influence coefficient; 'FFT' multiplies by fast "
        "Fourier transforms.",
    ),
    "fem": ("FEM", "Finite element method: the whole body is divided into small bricks."),
    "closed-form": (
        "closed form",
        "A formula that solves the contact problem exactly, such as that of Hertz.",
    ),
    "half-space": (
        "half-space",
        "An elastic body that fills everything below a plane: a good picture of any body that is "
        "large compared with the contact.",
    ),
    "penetration": (
        "penetration depth",
        "How far the rigid indenter has come nearer since it first touched the surface.",
    ),
    "effective-modulus": (
        "effective modulus E*",
        "E/(1 − ν²) for one elastic body; 1/E* adds for two.",
    ),
    "contact-area": (
        "contact area",
        "The area that really carries pressure. Counting cells overestimates it; the value shown "
        "is corrected for the perimeter, the counted one is kept as 'raw'.",
    ),
    "stiffness": (
        "contact stiffness",
        "The change of force per change of penetration at a contact area held fixed.",
    ),
    "mean-gap": ("mean gap", "The distance between the two surfaces, averaged over the area."),
    "resolution": (
        "resolution N",
        "Springs, cells or elements per contact radius at the largest load; on rough surfaces the "
        "number of points per side.",
    ),
    "realisation": (
        "realisation",
        "One random rough surface out of many with the same statistics.",
    ),
    "standard-error": (
        "standard error",
        "How far a mean over a few realisations is likely to be from the mean over all.",
    ),
    "reference": (
        "reference",
        "The most trustworthy solution of a scene, against which all others are measured.",
    ),
    "uncertainty": (
        "uncertainty",
        "The 95 % half-width of an error: scatter of the realisations, discretisation of the "
        "reference and of the reduced model taken together.",
    ),
    "tolerance": ("tolerance", "The relative error the user of the scene can accept."),
    "von-mises": (
        "von Mises stress",
        "One number for how close a material is to yielding under stresses in all directions.",
    ),
    "set-up": (
        "set-up",
        "The part of the time that another list of loads on the same scene would not need again.",
    ),
    "violation": (
        "violation",
        "How far a solution breaks the contact conditions: the largest overlap of the surfaces or "
        "tension between them, relative to penetration or pressure.",
    ),
    "unknowns": ("unknowns", "How many numbers a method solves for."),
    "path": (
        "path",
        "Loads in the order in which they are applied, up and down, where what is found depends on "
        "what came before: with friction, adhesion, or a material that remembers.",
    ),
    "partial-slip": (
        "stick and slip",
        "A contact that is pulled sideways slips from its edge inwards while its middle still "
        "sticks; when all of it slips, the force is µ times the normal force.",
    ),
    "viscoelastic": (
        "viscoelastic",
        "A material that answers a step in depth with a force that relaxes, and a step in force "
        "with a depth that creeps.",
    ),
    "pull-off": (
        "pull-off force",
        "The largest force with which adhesive surfaces have to be drawn apart.",
    ),
    "jkr": (
        "JKR",
        "Johnson, Kendall and Roberts: adhesion of so short a range that it acts at the edge of "
        "the contact only.",
    ),
    "restitution": (
        "coefficient of restitution",
        "The speed of a mass after an impact over that before it.",
    ),
    "singular": (
        "singular pressure",
        "Under a sharp edge or a tip the pressure of linear elasticity grows without bound.",
    ),
}

MEASURES = (
    (
        "Relative error",
        "(value − reference) / reference, step by step at the same prescribed load: force, area "
        "and others at equal penetration; penetration, area and others at equal force.",
    ),
    (
        "Error along a path",
        "(value − reference) / largest size of the reference along the path, at the same step or "
        "time: single values pass zero. What is prescribed is not compared.",
    ),
    (
        "Largest and rms error",
        "The largest size, bar included, and the root mean square of the relative error over all "
        "load steps. Never one depth alone.",
    ),
    (
        "Pressure error",
        "Root of the area-weighted mean square difference over the contact of the reference, "
        "divided by that of the reference's pressure. Where the reference is singular, a ring is "
        "left out and its width stated.",
    ),
    (
        "Ensembles",
        "The ratio of the means over the realisations, with its standard error.",
    ),
    (
        "Verdict",
        "With the error e, its uncertainty u and the tolerance t: within if |e| + u ≤ t at every "
        "load step; outside if |e| − u > t at any; otherwise not resolved. Each quantity is judged "
        "at the load that the scene prescribes, what is prescribed itself at the other; the step "
        "that decided is named. Of several quantities the worst counts, and one that a method "
        "does not give is no result. The same rule makes verdicts, advice and tables.",
    ),
    (
        "Time",
        "Everything a method does for the scene on warm code, the mesh or the spectrum and all "
        "load steps included, compilation and imports left out; the median of repeats. The set-up "
        "is the part another list of loads could reuse. A time is always that of a setting that "
        "was run; times closer than a factor of 1.5 are not ranked.",
    ),
)


def explain(term: str) -> str:
    """Return the explanation of a term (its key in TERMS).

    >>> explain("tolerance")
    'The relative error the user of the scene can accept.'
    """
    return TERMS[term][1]
