"""Every promise, and every row of the scorecard, names a test that exists."""

import ast
import re


def test_every_promise_names_a_test_that_exists(repo):
    text = (repo / 'docs' / 'promises.md').read_text()
    named = re.findall(r'`([\w/]+\.py)::(\w+)`', text)
    assert len(named) > 20
    for file, function in named:
        tree = ast.parse((repo / 'test' / file).read_text())
        functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert function in functions, f'{file}::{function}'


def test_every_row_of_promises_has_a_proof(repo):
    for line in (repo / 'docs' / 'promises.md').read_text().splitlines():
        if line.startswith('| ') and not line.startswith(('| promise', '|---')):
            assert '::' in line.split('|')[2], line


def test_every_row_of_the_scorecard_names_tests_that_exist(repo):
    text = (repo / 'docs' / 'faults.md').read_text()
    named = set(re.findall(r'`(\w+\.py)::(\w+)`', text))
    assert len(named) > 100
    there = {(file.name, node.name) for file in (repo / 'test').rglob('test_*.py')
             for node in ast.walk(ast.parse(file.read_text()))
             if isinstance(node, ast.FunctionDef)}
    assert sorted(named - there) == []
