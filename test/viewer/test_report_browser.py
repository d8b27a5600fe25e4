"""The report of the golden run in a real browser: wide and narrow, light and dark, in silence."""

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


@pytest.mark.parametrize('dark', [False, True], ids=['light', 'dark'])
@pytest.mark.parametrize('size', [(1280, 900), (420, 900)], ids=['wide', 'narrow'])
def test_the_report_fits_the_window_and_says_nothing(browser, report, size, dark, tmp_path):
    browser.console.clear()
    browser.open(report.as_uri(), *size, dark=dark)
    browser.wait("document.querySelectorAll('.main-svg').length > 0")
    time.sleep(1.0)
    assert browser.evaluate('document.documentElement.scrollWidth') <= size[0]
    picture = np.asarray(Image.open(browser.photograph(tmp_path / 'report.png')).convert('RGB'))
    ground = np.median(picture.reshape(-1, 3), axis=0)
    assert (ground.mean() < 90) if dark else (ground.mean() > 200)
    assert not browser.console


def test_the_report_asks_nothing_of_the_network(browser, report):
    browser.open(report.as_uri(), 1280, 900)
    browser.wait("document.querySelectorAll('.main-svg').length > 0")
    asked = browser.evaluate(
        "performance.getEntriesByType('resource').map(entry => entry.name).join(' ')")
    assert not [each for each in asked.split() if each.startswith('http')]


def test_details_open_and_figures_are_reached_by_keys_only(browser, report):
    browser.open(report.as_uri(), 1280, 900)
    browser.wait("document.querySelectorAll('.main-svg').length > 0")
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
