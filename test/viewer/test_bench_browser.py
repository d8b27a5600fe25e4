"""The page of the bench in a real browser: every law and number can be read, at every width."""

from pathlib import Path

import polars
import pytest

from ur5_ros.bench.entries import LAWS, load_bench
from ur5_ros.bench.report import write_report

pytestmark = pytest.mark.browser

ROOT = Path(__file__).resolve().parents[2]
#: Texts of a figure that match a selector, and the least height of letters in it [px].
TEXTS = "[...document.querySelectorAll('#plot-laws {} text')].map(each => each.textContent)"
LEAST = ("Math.min(...[...document.querySelectorAll('#plot-laws .heatmaplayer text')].map("
         "each => parseFloat(getComputedStyle(each).fontSize)))")


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    rows = polars.read_parquet(ROOT / 'benchmarks/results/laws.parquet').to_dicts()
    path = tmp_path_factory.mktemp('bench') / 'report.html'
    write_report(rows, load_bench().tried, path)
    return path


@pytest.mark.parametrize('size', [(1400, 900), (420, 900)], ids=['wide', 'narrow'])
def test_the_page_fits_names_every_law_and_has_a_number_in_every_cell(browser, page, size):
    browser.show(page, size, figures=4)
    assert browser.page_width <= size[0]
    assert set(LAWS) <= set(browser.evaluate(TEXTS.format('.yaxislayer-above')))
    assert len(browser.evaluate(TEXTS.format('.heatmaplayer'))) == 8 * len(LAWS)
    assert browser.evaluate(LEAST) >= 11.0
    assert not browser.console
