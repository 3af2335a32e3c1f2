"""Tables as pandas data frames: what cells are sorted by, under the names of their columns."""

from __future__ import annotations

import pandas as pd

from reports.tables.table import Table


def frame(table: Table) -> pd.DataFrame:
    """Return one row per row; numbers are numbers."""
    columns = [head.csv or head.text for head in table.heads]
    rows = [[cell.key if cell.key != "" else cell.text for cell in row] for row in table.rows]
    return pd.DataFrame(rows, columns=columns)
