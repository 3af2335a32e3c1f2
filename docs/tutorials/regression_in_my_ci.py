"""
Regression in my CI
===================

Somebody changed the model, a library or the machine. Did the results change - and whose? There are
two tools: two *runs* side by side, and a *baseline* under version control that every build is
checked against.
"""

# %%
# Two runs
# --------
# A study keeps its results in a folder. This is the run of yesterday:
import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd

import roughline

folder = Path(tempfile.mkdtemp())
scenes, methods = ["paraboloid", "cone"], ["closed_form", "reduced"]
before = roughline.Study(scenes, folder / "before", methods=methods).run()
before

# %%
# And this is the run of today, after a colleague has "simplified" the profile rule to R1 = R/2:
after = roughline.Study(
    scenes, folder / "after", methods=methods, changes={"methods.reduced.rule": "half_radius"}
).run()
moved = roughline.compare_runs(before, after)
moved

# %%
# The paraboloid did not notice, for it the two rules are the same; the cone lost a fifth of its
# force, and what moved most is its area: (pi/4)^2 of what it was. A test on the paraboloid alone
# would have been green.
assert {drift.scene for drift in moved.failed if "moved" in drift.kinds} == {"cone"}
print(moved.table().query("bad")[["scene", "resolution", "what", "quantity", "change"]])

# %%
# On the command line this is ``roughline compare before after``, with exit code 1 because something
# moved. Thresholds: ``--tolerance`` (default 1e-5, relative) and ``--slower`` (default 1.5 times).
#
# A baseline
# ----------
# ``roughline check`` keeps a run of the model *and of references that share no code with it*, and
# so can tell who moved. The first call makes the baseline:
baseline = folder / "roughline-baseline"


def check(*arguments):
    """Run ``roughline check`` on one scene, as a CI job would, and return what it says."""
    command = [sys.executable, "-m", "roughline", "check", "paraboloid", *arguments]
    done = subprocess.run(
        [*command, "--baseline", str(baseline)], capture_output=True, text=True, check=False
    )
    return f"{done.stdout}{done.stderr}exit code {done.returncode}"


print(check("--update"))

# %%
# The next build is checked against it. No curve has moved, and the exit code is 0.
report = check()
print(report)
assert "moved" not in report

# %%
# Now let the model be wrong by two per mille, here by editing the stored curve instead of the code:
rows = pd.read_csv(baseline / "results.csv")
rows.loc[rows["method"] == "reduced", "force"] *= 1.002
rows.to_csv(baseline / "results.csv", index=False)
report = check()
print(report)
assert "the reduced model moved" in " ".join(report.split())
assert report.endswith("exit code 1")

# %%
# The check says that the *reduced model* moved and the references did not, which is what a
# developer wants to know first. In a CI job:
#
# .. code-block:: yaml
#
#    - run: pip install roughline
#    - run: roughline check --baseline tests/roughline-baseline
#
# When a change is meant, ``roughline check --update`` prints the drift and renews the folder;
# commit it with the reason. In your own test suite the pytest fixture ``roughline_check`` does the
# same for a method of yours.
