"""Nouns and verbs agree with the number before them."""

import pytest

from ur5_ros.wording import agree, number_of


@pytest.mark.parametrize(('count', 'sentence'), [
    (0, '0 states of 9 have no stamp'), (1, '1 state of 9 has no stamp'),
    (2, '2 states of 9 have no stamp')])
def test_noun_and_verb_agree_with_their_number(count, sentence):
    assert f'{number_of(count, "state", 9)} {agree(count, "have no stamp")}' == sentence


@pytest.mark.parametrize(('plural', 'singular'), [
    ('are cut off', 'is cut off'), ('go back', 'goes back'), ('pass', 'passes'),
    ('repeat a stamp', 'repeats a stamp'), ('do', 'does')])
def test_verbs_have_their_singular(plural, singular):
    assert (agree(2, plural), agree(1, plural)) == (plural, singular)
