"""The table of the page is the one that the bench wrote."""

import json
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


def test_the_times_on_the_page_are_those_that_were_measured():
    page = (ROOT / 'docs/bench.md').read_text(encoding='utf-8').replace('\n', ' ')
    workers, whole = (json.loads((ROOT / f'benchmarks/results/{name}.json').read_text())['rows'][0]
                      for name in ('laws', 'laws_whole'))
    assert workers['met'] and whole['met']
    assert f'two workers do the runs {workers["ratio"]:.2f} times as fast as one' in page
    assert f'on two cores {600.0 * whole["ratio"]:.0f} s' in page
