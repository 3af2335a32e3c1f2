"""Tests run on one thread, as solves do: small matrices are slower on two, and noisy."""

import os

from hypothesis import settings

# Before NumPy is imported, and inherited by the programs that tests start.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# The first example of a test may have to compile.
settings.register_profile("roughline", deadline=None)
settings.load_profile("roughline")
