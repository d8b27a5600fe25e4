"""The soak, in short: what `make soak` does for an hour is done here for some seconds."""

import json
import subprocess
import sys

import pytest


@pytest.mark.slow
def test_a_short_soak_reads_every_part_and_memory_stays(repo, tmp_path):
    figures = tmp_path / 'soak.json'
    done = subprocess.run(
        [sys.executable, repo / 'benchmarks/soak.py', '--minutes', '0.6', '--split', '3',
         '--json', figures], cwd=tmp_path, text=True, capture_output=True,
        stdin=subprocess.DEVNULL, timeout=300)
    assert figures.is_file(), done.stderr[-2000:]
    lockstep, paced = json.loads(figures.read_text(encoding='utf-8'))
    assert lockstep['failures'] == []
    assert [each for each in paced['failures'] if 'later at the end' not in each] == []
    for result in (lockstep, paced):
        assert result['sim states'] > 1000
    assert abs(lockstep['sim states'] - lockstep['control states']) <= 5
