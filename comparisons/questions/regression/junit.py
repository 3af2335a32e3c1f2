"""Findings as JUnit XML, which continuous integration servers read."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

from comparisons.files import write_named_text
from comparisons.questions.regression.findings import Finding


def write_junit(path: Path, findings: list[Finding]) -> None:
    """Write one test case per finding: class is the scene, name the subject."""
    drifted = sum(each.drifted for each in findings)
    counts = {"tests": str(len(findings)), "failures": str(drifted), "errors": "0"}
    suite = Xml.Element("testsuite", {"name": "roughline check", **counts})
    for each in findings:
        names = {"classname": f"roughline.{each.scene}", "name": each.subject}
        case = Xml.SubElement(suite, "testcase", names)
        if each.drifted:
            Xml.SubElement(case, "failure", {"message": each.text}).text = each.text
        else:
            Xml.SubElement(case, "system-out").text = each.text
    root = Xml.Element("testsuites")
    root.append(suite)
    Xml.indent(root)
    write_named_text(path, Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n")
