"""Every row of the catalogue is broken by a test, or says why it does not apply."""

import re
from pathlib import Path

import yaml

TEST = Path(__file__).parents[1]


def claimed_rows() -> set[int]:
    """Return the rows that any test file claims."""
    rows: set[int] = set()
    for path in TEST.rglob('test_*.py'):
        for arguments in re.findall(r'mark\.fault\(([\d,\s]+)\)', path.read_text()):
            rows |= {int(number) for number in re.findall(r'\d+', arguments)}
    return rows


def test_every_row_has_a_test_or_a_reason():
    groups = yaml.safe_load((TEST / 'faults' / 'catalogue.yaml').read_text())
    rows = {number: row for group in groups.values() for number, row in group.items()}
    claimed = claimed_rows()
    assert sorted(rows) == list(range(1, 85))
    assert claimed <= set(rows)
    without = {number for number, row in rows.items() if 'not_applicable' in row}
    assert not claimed & without
    missing = [f"{number}: {rows[number]['fault']}"
               for number in sorted(set(rows) - claimed - without)]
    assert not missing, missing
