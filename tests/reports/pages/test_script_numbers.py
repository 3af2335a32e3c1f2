"""Numbers that the page's script writes are those that Python writes."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

import reports.pages
from comparisons.formatting import number

SCRIPT = Path(reports.pages.__file__).parent / "templates" / "judging.js"
RATIOS = [1e-7, 1.2e-4, 9.6e-4, 0.0012, 0.012, 0.3, 0.96, 1, 4.6, 95, 1234, 5.1e5, 999999, 3e21]


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_ratios_of_times_are_written_as_python_does():
    script = SCRIPT.read_text(encoding="utf-8")
    start = script.index("const oneDigit")
    function = script[start : script.index("\nconst ends", start)]
    asked = f"{function}; console.log(JSON.stringify({RATIOS}.map(oneDigit)))"
    told = subprocess.run(["node", "-e", asked], capture_output=True, check=True).stdout
    assert json.loads(told) == [number(ratio, 1) for ratio in RATIOS]
