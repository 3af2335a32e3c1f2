"""The tables in docs/lammps-tests, made for LAMMPS' test suite, are what the suite computes."""

import pytest


@pytest.fixture(scope="module")
def tables(script):
    return script("lammps_tests")


def numbers(text):
    """Return the rows of a file, and what stands around them."""
    head, rows = text.split("analytic_rows: |2\n")
    return head, [[float(value) for value in row.split()] for row in rows.splitlines()[:-1]]


@pytest.mark.parametrize(
    "name",
    [
        *("hertz-equal", "hertz-unequal", "jkr-in-and-out", "mdr-elastic", "mdr-law"),
        pytest.param("mdr-elements", marks=pytest.mark.slow),
    ],
)
def test_a_table_is_what_the_suite_computes(tables, name):
    """To 1e-9, the last digit, where the formula is closed; Newton's end costs elements 1e-4."""
    written = (tables.FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
    (head, rows), (found_head, found) = numbers(written), numbers(tables.text(name))
    assert head == found_head
    for row, computed in zip(rows, found, strict=True):
        values = slice(0, 3 if name == "mdr-elements" else None)  # beside them are bars
        rel = 1e-4 if name == "mdr-elements" else 2e-9
        assert computed[values] == pytest.approx(row[values], rel=rel)


def test_every_table_is_there(tables):
    assert {path.stem for path in tables.FOLDER.glob("*.yaml")} == set(tables.CONTACTS)
