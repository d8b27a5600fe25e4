"""The table of the page is the one that the bench wrote."""

from pathlib import Path

import polars

from ur5_ros.bench.entries import LAWS
from ur5_ros.bench.perturbations import PERTURBATIONS
from ur5_ros.bench.table import markdown

ROOT = Path(__file__).resolve().parents[2]


def test_the_table_of_the_page_is_that_of_the_recorded_runs():
    rows = polars.read_parquet(ROOT / 'benchmarks/results/laws.parquet').to_dicts()
    page = (ROOT / 'docs/bench.md').read_text(encoding='utf-8')
    assert page.partition('<!-- table -->\n')[2].partition('\n<!-- end -->')[0] == (
        f'\n{markdown(rows)}')
    runs = {(row['law'], row['perturbation']) for row in rows if row['kind'] == 'run'}
    assert runs == {(law, name) for law in LAWS for name in PERTURBATIONS}
