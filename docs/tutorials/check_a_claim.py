"""
Check a claim
=============

*An ellipsoid can be represented by a sphere of the Gaussian radius* - so says the chapter, and so
say papers that use it. Whether that is good enough depends on how long the ellipsoid is and on
what "good enough" means. This tutorial puts the statement into a form that can be refuted, and
lets roughline find the range in which it holds.
"""

# %%
# The statement stands among the built-in claims. Each has an id, the equation it comes from, and a
# tolerance.
import roughline

roughline.list_claims().loc[
    ["ellipsoid-force", "ellipsoid-area"], ["equation", "tolerance", "text"]
]

# %%
# ``check_claim`` presses ellipsoids from round (R'/R'' = 1) to long (20), compares the springs with
# the exact solution with its elliptic integrals, and bisects where the error crosses the tolerance.
verdict = roughline.check_claim("ellipsoid-force")
verdict

# %%
# The answer is neither yes nor no. Within 1 % the rule holds up to a ratio of about two, and the
# range is part of the verdict: what was measured just beyond it is outside.
low, high = verdict.ranges[0]
print(f"holds from {low:.2f} to {high:.2f}")
assert verdict.verdict == "holds in a range"
assert 1.9 < high < 2.1

# %%
# The plot shows why a single test at R'/R'' = 1.5 would have been misleading: the error leaves the
# tolerance soon after, and goes on to -16 % at 20.
verdict.plot()

# %%
# A claim of your own
# -------------------
# A claim is a few lines of TOML, or a dict. Here is one that is often assumed without being said:
# that a *worn* tip, flat in the middle, may still be treated with the chapter's rule R1 = R/2.
# ``vary`` names the parameter of the scene, its range, and where to measure first.
worn_tip = {
    "id": "worn-tip",
    "text": "A tip with a flat spot is still a paraboloid for the rule R1 = R/2.",
    "equation": "(19.17)",
    "scene": "rounded-punch",
    "changes": {"methods.reduced.rule": "half_radius"},
    "vary": {
        "path": "indenter.flat_radius",
        "name": "radius of the flat / m",
        "from": 1e-6,
        "to": 1e-3,
        "steps": 5,
        "spacing": "log",
    },
    "quantity": "force",
    "tolerance": 0.05,
    "refuted_by": "an error of the force beyond 5 % for some radius of the flat",
}
worn = roughline.check_claim(worn_tip)
worn

# %%
# What follows from it
# --------------------
# The claim holds for flats up to some 20 um and is lost when they are as wide as the contact. The
# exact transform of the reduced model (``rule = "mdr"``, the default) has no such limit: the same
# claim about it holds over the whole range.
exact = roughline.check_claim(worn_tip | {"changes": {"methods.reduced.rule": "mdr"}}, full=False)
print(f"R1 = R/2: {worn.verdict}; exact transform: {exact.verdict}")
assert worn.verdict == "holds in a range"
assert exact.verdict == "holds"

# %%
# In a file, ``roughline claims worn-tip.toml --full`` judges it with narrower bars, and its exit
# code is 1 if the verdict is not the one that the file's ``expected`` says: a claim is a test.
