"""Findings as JUnit XML for continuous integration servers."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

from comparisons.files import write_named_text
from comparisons.questions.regression.findings import Finding


def write_junit(path: Path, findings: list[Finding]) -> None:
    """Write one test case per finding: class is the scene, name the subject."""
    drifted = sum(finding.drifted for finding in findings)
    counts = {"tests": str(len(findings)), "failures": str(drifted), "errors": "0"}
    suite = Xml.Element("testsuite", {"name": "roughline check", **counts})
    for finding in findings:
        names = {"classname": f"roughline.{finding.scene}", "name": finding.subject}
        case = Xml.SubElement(suite, "testcase", names)
        if finding.drifted:
            Xml.SubElement(case, "failure", {"message": finding.text}).text = finding.text
        else:
            Xml.SubElement(case, "system-out").text = finding.text
    root = Xml.Element("testsuites")
    root.append(suite)
    Xml.indent(root)
    write_named_text(path, Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n")
