"""Every page that a command writes, in a real browser: readable, reachable by keys, silent."""

import time
from pathlib import Path

import polars
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.identification.identify import identify
from ur5_ros.analysis.report.html import write_html
from ur5_ros.analysis.report.identification import write_identification_html
from ur5_ros.analysis.validate import validate
from ur5_ros.bench.report import write_report as write_bench
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.sweep.report import write_report as write_sweep
from ur5_ros.sweep.run import row_of
from ur5_ros.sweep.spec import expand, parse_sweep
from ur5_ros.sweep.table import SweepFolder

pytestmark = pytest.mark.browser

ROOT = Path(__file__).resolve().parents[2]
PAGES = ('report', 'contact', 'grid', 'random', 'identification', 'bench')
#: What a sweep of each kind varies.
SWEEPS = {
    'grid': 'control_rate: [125, 500]\n  sim.payload.mass: [0.0, 1.0, 2.0]',
    'random': 'sim.payload.mass: {uniform: [0.0, 2.0]}\n'
              '  initial_error: {uniform: [-0.1, 0.1], size: 6}'}
#: Smallest ratio of luminance between a text and what is behind it.
CONTRAST = """(() => {
  const light = (colour) => {
    const [r, g, b] = colour.match(/[\\d.]+/g).map((each) => {
      const share = each / 255;
      return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4; });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const behind = (node) => {
    for (; node; node = node.parentElement) {
      const colour = getComputedStyle(node).backgroundColor;
      if (!colour.endsWith(', 0)') && colour !== 'transparent') return light(colour); }
    return 1; };
  const found = [];
  for (const node of document.querySelectorAll('p, h1, h2, td, th, li, b, span, figcaption')) {
    if (!node.innerText || !node.getClientRects().length) continue;
    const [low, high] = [light(getComputedStyle(node).color), behind(node)].sort((a, b) => a - b);
    found.push((high + 0.05) / (low + 0.05)); }
  return Math.min(...found); })()"""
SMALLEST = """Math.min(...[...document.querySelectorAll('p, td, th, li, text')].filter(
  (node) => node.textContent.trim() && node.getClientRects().length).map(
  (node) => parseFloat(getComputedStyle(node).fontSize)))"""
EMPTY = """[...document.querySelectorAll('.plot')].filter((plot) => !plot.querySelector(
  '.trace, .heatmaplayer image, .barlayer path, .scatterlayer path')).map((plot) => plot.id)"""


@pytest.fixture(scope='module')
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp('pages')
    write_html(validate(load_run(ROOT / 'bags/golden')), folder / 'report.html')
    pushed = as_run(run_closed_loop(run_config('push_block', duration=2.0)), 'pushed')
    write_html(validate(pushed), folder / 'contact.html')
    for name, vary in SWEEPS.items():
        samples = 'samples: 6\n' if name == 'random' else ''
        sweep = parse_sweep(f'name: {name}\nduration: 0.3\njudge: metrics\n{samples}success: '
                            f'{{final_error: 0.2}}\nvary:\n  {vary}\n', f'{name}.yaml')
        table = SweepFolder(folder / name, sweep)
        table.add([row_of(sweep, run, None) for run in expand(sweep)])
        write_sweep(table, folder / f'{name}.html')
    moved = as_run(run_closed_loop(run_config('exciting', arm='ur5_real', duration=12.0,
                                              control_rate=500)), 'exciting')
    write_identification_html(identify([moved]), folder / 'identification.html')
    rows = polars.read_parquet(ROOT / 'benchmarks/results/laws.parquet').to_dicts()
    write_bench(rows, [], folder / 'bench.html')
    return folder


def opened(browser, pages, page, size, dark=False) -> None:
    browser.show(pages / f'{page}.html', size, dark=dark)
    time.sleep(1.0)


@pytest.mark.parametrize(('size', 'dark'), [
    ((1400, 900), False), ((1400, 900), True), ((420, 900), False), ((420, 900), True)],
    ids=['wide light', 'wide dark', 'narrow light', 'narrow dark'])
@pytest.mark.parametrize('page', PAGES)
def test_a_page_is_readable_complete_and_silent(browser, pages, page, size, dark):
    opened(browser, pages, page, size, dark)
    assert browser.page_width <= size[0]
    assert browser.evaluate('document.documentElement.lang') == 'en'
    assert browser.evaluate('document.title') and browser.evaluate(
        "document.querySelectorAll('h1').length") == 1
    assert browser.evaluate(CONTRAST) >= 4.5
    assert browser.evaluate(SMALLEST) >= 8.0
    assert not browser.evaluate(EMPTY), 'no empty axes'
    words = browser.evaluate('document.body.innerText')
    assert 'WebGL' not in words and 'NaN' not in words and 'undefined' not in words
    assert not browser.evaluate(r"(document.querySelector('main').innerText.match("
                                r"/\d\.\d{7,}/) || []).join(' ')"), 'at most six digits'
    asked = browser.evaluate(
        "performance.getEntriesByType('resource').map(entry => entry.name).join(' ')")
    assert not [each for each in asked.split() if each.startswith('http')]
    assert not browser.console


@pytest.mark.parametrize('page', PAGES)
def test_the_keyboard_goes_through_a_page_from_top_to_bottom_and_is_seen(browser, pages, page):
    opened(browser, pages, page, (1400, 900))
    places = []
    for _ in range(40):
        browser.key('Tab', 9)
        at = browser.evaluate(
            "(() => { const node = document.activeElement;"
            "if (node === document.body) return null;"
            "const figure = node.closest('figure') || node; const style = getComputedStyle(node);"
            "return [figure.getBoundingClientRect().top + scrollY, figure.getBoundingClientRect()"
            ".left, style.outlineStyle]; })()")
        if at is None or (places and at[0] < places[0][0]):
            break
        places.append(at)
    assert len(places) >= 4
    assert {style for _, _, style in places} == {'solid'}
    lines = [(round(top / 100), left) for top, left, _ in places]
    assert all(one[0] <= other[0] + 1 for one, other in zip(lines[:-1], lines[1:], strict=True))
