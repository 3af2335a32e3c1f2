"""Tests run on one thread, as solves do: small matrices are slower on two, and noisy."""

import os

from hypothesis import settings

# Sphinx's, and scripts that tests/test_tutorials.py runs as a whole: nothing to import here.
collect_ignore = [f"docs/{name}" for name in ("conf.py", "site", "tutorials", "gallery", "_build")]

# Before NumPy is imported, and inherited by the programs that tests start.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# No deadline: the first example of a test may have to compile. The same examples in every run, so
# that a change is to blame for what it breaks; `pytest --hypothesis-profile=search` looks further.
settings.register_profile("roughline", deadline=None, derandomize=True)
settings.register_profile("search", deadline=None, max_examples=1000)
settings.load_profile("roughline")
