"""Tables as pandas data frames: the sort key of each cell, under the name of its column."""

from __future__ import annotations

import pandas as pd

from reports.tables.table import Table


def frame(table: Table) -> pd.DataFrame:
    """Return a data frame with one row per table row; numbers stay numeric."""
    columns = [head.csv or head.text for head in table.heads]
    rows = [[cell.key if cell.key != "" else cell.text for cell in row] for row in table.rows]
    return pd.DataFrame(rows, columns=columns)
