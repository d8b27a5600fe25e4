"""The report of the golden run in a real browser: wide and narrow, light and dark, in silence."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.report.html import write_html
from ur5_ros.analysis.validate import validate

pytestmark = pytest.mark.browser

ROOT = Path(__file__).resolve().parents[2]

@pytest.fixture(scope='module')
def report(tmp_path_factory):
    path = tmp_path_factory.mktemp('report') / 'report.html'
    write_html(validate(load_run(ROOT / 'bags/golden')), path)
    return path


def opened(browser, report, size=(1280, 900), dark=False) -> None:
    """Open the report and wait for its figures."""
    browser.show(report, size, dark=dark)
    time.sleep(1.0)


@pytest.mark.parametrize('dark', [False, True], ids=['light', 'dark'])
@pytest.mark.parametrize('size', [(1280, 900), (420, 900)], ids=['wide', 'narrow'])
def test_the_report_fits_the_window_and_says_nothing(browser, report, size, dark, tmp_path):
    opened(browser, report, size, dark)
    assert browser.page_width <= size[0]
    picture = np.asarray(Image.open(browser.photograph(tmp_path / 'report.png')).convert('RGB'))
    ground = np.median(picture.reshape(-1, 3), axis=0)
    assert (ground.mean() < 90) if dark else (ground.mean() > 200)
    assert not browser.console


def test_the_report_asks_nothing_of_the_network(browser, report):
    opened(browser, report)
    asked = browser.evaluate(
        "performance.getEntriesByType('resource').map(entry => entry.name).join(' ')")
    assert not [each for each in asked.split() if each.startswith('http')]


def test_details_open_and_figures_are_reached_by_keys_only(browser, report):
    opened(browser, report)
    reached = set()
    for _ in range(400):
        browser.key('Tab', 9)
        at = browser.evaluate("document.activeElement.tagName + (document.activeElement.closest("
                              "'.modebar') ? ' of a figure' : '')")
        reached.add(at)
        if at == 'SUMMARY':
            break
    assert {'BUTTON of a figure', 'SUMMARY'} <= reached
    browser.ask('Input.dispatchKeyEvent', type='keyDown', key='Enter', code='Enter', text='\r',
                windowsVirtualKeyCode=13)
    assert browser.evaluate('document.activeElement.parentElement.open')
    assert browser.evaluate('getComputedStyle(document.activeElement).outlineStyle') == 'solid'


#: The places of the first point of a curve of a joint in a figure [pixels].
POINT = """(() => {
  const box = document.getElementById('plot-joint_position');
  box.scrollIntoView({block: 'center'});
  const frame = box.querySelector('.plot .scatterlayer, .xy .plot').getBoundingClientRect();
  const layout = box._fullLayout, area = box.getBoundingClientRect();
  const trace = box._fullData.find((each) => each.name === 'elbow');
  const x = trace.x[200], y = trace.y[200];
  return [area.left + layout._size.l + layout.xaxis.d2p(x),
          area.top + layout._size.t + layout.yaxis.d2p(y), x, y]; })()"""
#: How many curves of each joint are drawn in all figures.
DRAWN = """Object.fromEntries(['pan', 'elbow'].map((name) => [name, [...document.querySelectorAll(
  '.plot')].flatMap((box) => box._fullData || []).filter((each) => each.visible === true
  && each.name.split(',')[0] === name).length]))"""


def test_the_tools_of_a_figure_are_seen_under_the_pointer_only(browser, report):
    opened(browser, report)
    seen = "getComputedStyle(document.querySelector('#plot-torque .modebar-group')).opacity"
    assert browser.evaluate(seen) == '0'
    x, y = browser.evaluate("(() => { const box = document.getElementById('plot-torque');"
                            "box.scrollIntoView({block: 'center'});"
                            "const place = box.getBoundingClientRect();"
                            "return [place.left + 200, place.top + 100]; })()")
    browser.ask('Input.dispatchMouseEvent', type='mouseMoved', x=x, y=y)
    browser.wait(f"{seen} === '1'")
    names = browser.evaluate("[...document.querySelectorAll('.modebar-btn')].map((each) => "
                             "each.getAttribute('data-title')).join()")
    assert 'cloud' not in names.lower() and 'share' not in names.lower()


def test_the_pointer_shows_joint_value_and_units(browser, report):
    opened(browser, report)
    x, y, t, value = browser.evaluate(POINT)
    for dx in (0, 1):
        browser.ask('Input.dispatchMouseEvent', type='mouseMoved', x=x + dx, y=y)
    label = browser.wait("[...document.querySelectorAll('#plot-joint_position .hovertext')]"
                         ".map((each) => each.textContent).join(' ')")
    found = re.search(r'(elbow|elbow, reference): (\S+) rad(\S+) s', label)
    assert found, label
    assert float(found[2].replace('\u2212', '-')) == pytest.approx(value, rel=2e-3)
    assert float(found[3]) == pytest.approx(t, abs=0.1)


def test_a_click_on_a_joint_in_a_legend_hides_it_in_every_figure_and_shows_it_again(browser,
                                                                                    report):
    opened(browser, report)
    before = browser.evaluate(DRAWN)
    assert min(before.values()) >= 3
    for expected in (0, before['elbow']):
        x, y = browser.evaluate(
            "(() => { const item = [...document.querySelectorAll('#plot-torque .legend .traces')]"
            ".find((each) => each.textContent === 'elbow');"
            "item.scrollIntoView({block: 'center'});"
            "const place = item.querySelector('.legendtoggle').getBoundingClientRect();"
            "return [place.left + place.width / 2, place.top + place.height / 2]; })()")
        for kind in ('mouseMoved', 'mousePressed', 'mouseReleased'):
            browser.ask('Input.dispatchMouseEvent', type=kind, x=x, y=y, button='left',
                        clickCount=1)
        browser.wait(f'{DRAWN}.elbow === {expected}')
        assert browser.evaluate(DRAWN) == {'pan': before['pan'], 'elbow': expected}
        time.sleep(0.6)  # two clicks at once would be a double click
    assert not browser.console


def test_a_joint_is_hidden_in_every_figure_by_keys(browser, report):
    opened(browser, report)
    before = browser.evaluate(DRAWN)
    for _ in range(60):
        browser.key('Tab', 9)
        if browser.evaluate("document.activeElement.dataset.joint === 'pan'"):
            break
    for pressed, expected in (('false', 0), ('true', before['pan'])):
        browser.key(' ', 32, 'Space')
        browser.wait(f'{DRAWN}.pan === {expected}')
        assert browser.evaluate("document.activeElement.getAttribute('aria-pressed')") == pressed
    assert browser.evaluate('getComputedStyle(document.activeElement).outlineStyle') == 'solid'
