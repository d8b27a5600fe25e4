"""JSON, JUnit and the report: whole, self-contained, and no text of a bag ever acts."""

import base64
import gzip
import hashlib
import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from ur5_ros.analysis.data.given_reference import given_reference
from ur5_ros.analysis.data.run import RecordedEvent
from ur5_ros.analysis.report.figures import CURVE_PIECES, envelope, figures
from ur5_ros.analysis.report.html import html_text, write_html
from ur5_ros.analysis.result import Check, Result, judge
from ur5_ros.analysis.validate import validate
from ur5_ros.errors import InputError

EVIL = '</script><script>alert(1)</script><img src=x onerror=alert(2)>"\'&\x00\x1b\ud800'


@pytest.fixture(scope='module')
def hostile(simulated):
    run = simulated(seconds=0.3)
    side = replace(run.sim, arm_name=EVIL, versions={EVIL: EVIL}, summary={'hashes': {EVIL: EVIL}},
                   parameters={**run.sim.parameters, 'arm': EVIL, 'experiment': EVIL})
    event = RecordedEvent(int(run.stamp[3]), EVIL, EVIL, {})
    return validate(replace(run, name=EVIL, folder=EVIL, sim=side, problems=(EVIL,),
                            control=replace(run.control, arm_name=EVIL), events=(event,)))


def test_the_report_opens_from_disk_and_loads_nothing(clean_run, tmp_path):
    write_html(validate(clean_run), tmp_path / 'report.html')
    text = (tmp_path / 'report.html').read_text(encoding='utf-8')
    assert len(text) < 3_000_000
    without_scripts = re.sub(r'<script.*?</script>', '', text, flags=re.DOTALL)
    assert not re.search(r'(src|href)\s*=', without_scripts)
    assert without_scripts.index('>pass<') < without_scripts.index('<h2>Checks')


def test_a_law_of_others_has_its_path_its_error_and_its_torque_before_the_checks(simulated):
    run = replace(simulated(seconds=0.3), control=None)
    goal = replace(run, reference=given_reference(run, '0.1,-1.2,1.5,-1.8,-1.4,0.2'))
    plots = {each.key: each for each in figures(validate(goal))}
    assert [key for key, each in plots.items() if each.first] == ['path', 'pose_error', 'torque']
    assert [trace['mode'] for trace in plots['path'].traces] == ['markers', 'lines'], 'one point'
    assert 'error' in plots
    alone = figures(validate(replace(run, reference=None)))
    assert [each.key for each in alone if each.first] == ['path', 'joint_position', 'torque']
    assert [trace['name'] for trace in alone[0].traces] == ['measured']


def test_a_report_is_headed_by_the_folder_and_has_the_name_of_the_run_beside(clean_run):
    for folder, head in (('bags/mine', 'mine'), ('bags/mine/sim', 'mine/sim'), ('', 'x')):
        text = html_text(validate(replace(clean_run, name='x', folder=folder)))
        assert f'<h1>{head}</h1>' in text and f'{head}</title>' in text
        assert ('<span>run</span>x</div>' in text) == (head != 'x')


def test_a_single_cause_is_named_once_and_several_as_a_list(clean_run):
    causes = tuple({'kind': 'x', 'sentence': f'cause {i}'} for i in range(2))
    failed = replace(validate(clean_run), checks=(judge('x', 2.0, 1.0, 'm', 'x'),))
    passed = replace(failed, checks=(judge('x', 0.0, 1.0, 'm', 'x'),))
    for result, count, listed in ((failed, 1, False), (failed, 2, True), (passed, 1, True)):
        text = html_text(replace(result, causes=causes[:count]))
        assert ('<li>cause 0</li>' in text) == listed
        assert ('Cause: cause 0.' in text) == (result is failed)


def test_only_the_script_of_the_page_may_run_and_what_it_unpacks(clean_run):
    text = html_text(validate(clean_run))
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src 'none'" in policy and "script-src 'unsafe" not in policy
    scripts = re.findall(r'<script>(.*?)</script>', text, flags=re.DOTALL)
    assert len(scripts) == 1
    digest = base64.b64encode(hashlib.sha256(scripts[0].encode()).digest()).decode()
    assert policy.endswith(f"script-src 'sha256-{digest}' blob:")
    packed = re.search(r'id="library">([^<]*)</script>', text)[1]
    assert gzip.decompress(base64.b64decode(packed)).decode() == get_plotlyjs()


def test_texts_of_a_bag_never_become_markup(hostile):
    text = html_text(hostile)
    page = re.sub(r'<script>.*?</script>', '', text, flags=re.DOTALL)
    assert '<img' not in page and 'alert(1)</script>' not in page
    assert page.count('<script') == page.count('</script>') == 2
    json.loads(re.search(r'id="figures">(.*?)</script>', page, flags=re.DOTALL)[1])


def test_a_hostile_result_is_written_all_the_same(hostile, tmp_path):
    write_html(hostile, tmp_path / 'report.html')
    assert ElementTree.fromstring(hostile.to_junit()).get('failures') == '1'
    hostile.to_json().encode('utf-8')


def test_the_json_document_holds_every_check(clean_run):
    result = validate(clean_run)
    document = json.loads(result.to_json())
    assert document['format'] == 'ur5_ros validation' and document['version'] == 1
    assert [check['name'] for check in document['checks']] == [c.name for c in result.checks]
    assert document['verdict'] == result.verdict == 'pass'


def test_what_is_not_finite_is_null_in_json_and_fails():
    check = judge('x', np.nan, 1.0, 'm', 'no number')
    assert check.verdict == 'fail'
    assert json.loads(Result('r', {}, (check,)).to_json())['checks'][0]['value'] is None


def test_a_result_without_a_passed_check_fails():
    assert Result('r', {}, (Check('x', 'not applicable', ''),)).verdict == 'fail'


def test_junit_counts_what_ci_counts(clean_run):
    suite = ElementTree.fromstring(validate(clean_run).to_junit())
    assert suite.get('failures') == '0'
    assert int(suite.get('tests')) == len(suite.findall('testcase'))
    assert int(suite.get('skipped')) == len(suite.findall('testcase/skipped'))


def test_thinned_curves_keep_every_peak():
    values = np.sin(np.linspace(0.0, 200.0, 600_000))
    values[123_457], values[400_001] = 9.0, -9.0
    rows = envelope(values)
    assert len(rows) <= 2 * CURVE_PIECES + 6 and np.all(np.diff(rows) > 0)
    assert values[rows].max() == 9.0 and values[rows].min() == -9.0
    holes = np.where(np.arange(600_000) % 7 < 6, np.nan, values)
    assert np.nanmax(holes[envelope(holes)]) == np.nanmax(holes)


def test_every_figure_that_is_promised_is_there(looped):
    keys = {figure.key for figure in figures(validate(looped('kebria_fig11', 'ur5', 2.0)))}
    assert {'position', 'orientation', 'error', 'torque_1', 'torque_6', 'residual_control',
            'residual_sim', 'energy'} <= keys


def test_a_report_that_cannot_be_written_is_refused(clean_run, tmp_path):
    with pytest.raises(InputError, match='cannot be written'):
        write_html(validate(clean_run), tmp_path / 'absent' / 'report.html')


def test_what_is_added_to_the_plant_is_a_line_in_every_figure_and_stands_in_the_head(clean_run):
    wrench = RecordedEvent(int(clean_run.stamp[2000]), 'wrench', 'pushed',
                           {'force': [0.0, 0.0, 5.0], 'torque': [0.0, 0.0, 0.0]})
    text = html_text(validate(replace(clean_run, events=(wrench,))))
    marks = json.loads(re.search(r'id="figures">(.*?)</script>', text)[1])['marks']
    assert marks == [{'t': 2.0, 'text': 'wrench 0 0 5 N, 0 0 0 N m'}]
    assert 'wrench 0 0 5 N, 0 0 0 N m from 2 s' in text.partition('<h2>')[0]
