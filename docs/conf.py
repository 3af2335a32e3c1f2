"""The documentation site: `sphinx-build -W docs docs/_build` (extra `docs`).

Sphinx and not MkDocs: it reads the docstrings of the Python interface and runs the tutorials.
"""

import os
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
# The packages are those beside this folder, or the installed ones; programs that tutorials start
# find the same.
ROOT = Path(os.environ.get("ROUGHLINE_ROOT", HERE.parent))
sys.path[:0] = [str(ROOT), str(HERE / "site")]
os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])

project = "roughline"
author = "The roughline founders"
release = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
language = "en"

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx_gallery.gen_gallery",
    "mathml",
]
exclude_patterns = ["_build", "examples", "tutorials", "site"]
html_theme = "furo"
html_title = f"roughline {release}"
html_copy_source = False

# --- pages in Markdown
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4

# --- docstrings: numpydoc's sections, members in the order of the source
autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

# --- mathematics as MathML: read by every browser without a network (site/mathml.py)
html_math_renderer = "mathml"

# --- tutorials: run, with what they print and show
sphinx_gallery_conf = {
    "examples_dirs": "tutorials",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "ignore_pattern": "none",
    "within_subsection_order": "FileNameSortKey",
    "capture_repr": ("_repr_html_", "__repr__"),
    "image_scrapers": (),
    "reset_modules": (),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
}
