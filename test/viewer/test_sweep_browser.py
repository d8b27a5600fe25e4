"""The page of a sweep in a real browser: a table that sorts and filters, and a quiet console."""


import pytest

from ur5_ros.sweep.report import write_report
from ur5_ros.sweep.run import row_of
from ur5_ros.sweep.spec import expand, parse_sweep
from ur5_ros.sweep.table import SweepFolder

pytestmark = pytest.mark.browser

SWEEP = """
name: drawn
duration: 0.3
judge: metrics
samples: 8
success: {final_error: 0.05}
vary:
  arm: [ur5]
  initial_error: {uniform: [-0.1, 0.1], size: 6}
  sim.payload.mass: {uniform: [0.0, 2.0]}
"""
FIRST = "document.querySelector('table.sortable').tBodies[0].rows[0].cells[0].textContent"
VISIBLE = "[...document.querySelector('table.sortable').tBodies[0].rows].filter(r => !r.hidden)"


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    spec = parse_sweep(SWEEP, 'drawn.yaml')
    folder = SweepFolder(tmp_path_factory.mktemp('sweep') / 'drawn', spec)
    folder.add([row_of(spec, run, None) for run in expand(spec)])
    write_report(folder, folder.path / 'report.html')
    return folder.path / 'report.html'


@pytest.mark.parametrize('size', [(1400, 900), (420, 900)], ids=['wide', 'narrow'])
def test_the_page_fits_its_window_and_logs_nothing(browser, page, size):
    browser.show(page, size, figures=5)
    assert browser.page_width <= size[0]
    assert not browser.console


def test_rows_are_sorted_by_a_header_and_filtered_by_a_word(browser, page):
    browser.open(page.as_uri(), 1400, 900)
    browser.wait("document.querySelectorAll('th button').length > 3")
    browser.evaluate("document.querySelector('th button').click()")
    assert browser.evaluate(FIRST) == '0'
    browser.evaluate("document.querySelector('th button').click()")
    assert browser.evaluate(FIRST) == '7'
    browser.evaluate("(() => { const field = document.querySelector('input[type=search]');"
                     "field.value = '--only 3'; field.dispatchEvent(new Event('input')); })()")
    assert browser.evaluate(f'{VISIBLE}.length') == 1
    assert browser.evaluate("document.querySelectorAll('[data-title^=Share]').length") == 0
