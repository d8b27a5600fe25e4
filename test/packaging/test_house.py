"""The house's own rules: few modules a folder, short modules and functions."""

import ast
import re
from collections import Counter
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

#: Rooms that gain nothing by being split.
FLAT = ('ur5_ros/sim', 'ur5_ros/control')
MODULES_A_FOLDER = 16
LINES_A_MODULE = 300
LINES_A_FUNCTION = 70
#: Words that had no meaning, or two, for a reader of the field.
BANNED = {
    'steering', 'answering', 'diary', 'crowd', 'onlookers', 'deaf', 'glance',
    'patience', 'living', 'wanted', 'told', 'tell', 'tells', 'says', 'said', 'somebody',
    'anybody', 'nobody', 'whoever', 'hang', 'believe', 'believed', 'obey', 'usual', 'plainly',
    'blame', 'lacking', 'rivals', 'promise', 'lumped', 'hear', 'heard',
}


@cache
def modules() -> dict[Path, ast.Module]:
    """Return every module of the product, parsed."""
    return {path: ast.parse(path.read_text(encoding='utf-8'))
            for path in sorted((ROOT / 'ur5_ros').rglob('*.py'))}


def without_docstrings(node: ast.AST) -> int:
    """Return how many lines a module, class or function has, docstrings left out."""
    docstrings = [each.body[0] for each in ast.walk(node)
                  if isinstance(each, ast.Module | ast.ClassDef | ast.FunctionDef)
                  and ast.get_docstring(each) is not None]
    last = node.body[-1].end_lineno
    first = getattr(node, 'lineno', 1)
    return last - first + 1 - sum(each.end_lineno - each.lineno + 1 for each in docstrings)


def names(tree: ast.AST) -> set[str]:
    """Return every name that a module gives: of modules, classes, functions, values, fields."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            found.add(node.id if isinstance(node, ast.Name) else node.attr)
    return found


def words(name: str) -> set[str]:
    """Return the words of a name in snake_case or CamelCase."""
    return {word.lower() for word in re.findall(r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])', name)}


def test_a_folder_can_be_read_at_a_glance():
    count = Counter(str(path.parent.relative_to(ROOT)) for path in modules()
                    if path.name != '__init__.py')
    assert not {folder: number for folder, number in count.items()
                if number > MODULES_A_FOLDER and folder not in FLAT}


def test_a_module_has_one_subject():
    assert not {str(path.relative_to(ROOT)): lines for path, tree in modules().items()
                if tree.body and (lines := without_docstrings(tree)) > LINES_A_MODULE}


def test_a_function_fits_a_screen():
    assert not {f'{path.relative_to(ROOT)}: {node.name}': lines
                for path, tree in modules().items() for node in ast.walk(tree)
                if isinstance(node, ast.FunctionDef)
                and (lines := without_docstrings(node)) > LINES_A_FUNCTION}


def test_names_are_words_of_the_field():
    tests = {path: ast.parse(path.read_text(encoding='utf-8'))
             for path in sorted((ROOT / 'test').rglob('*.py'))}
    found = {f'{path.relative_to(ROOT)}: {name}' for path, tree in (modules() | tests).items()
             for name in {path.stem, *names(tree)}
             if words(name) & BANNED and not name.startswith('test_')}  # those are sentences
    assert not found


def test_the_files_that_contributing_names_exist():
    text = (ROOT / 'CONTRIBUTING.md').read_text(encoding='utf-8')
    named = re.findall(r'`((?:ur5_ros|test|docs)?/?[\w/]+/\w*(?:\.\w+)?)`', text)
    missing = [name for name in named
               if not (ROOT / name).exists() and not (ROOT / 'ur5_ros' / name).exists()]
    assert len(named) > 20 and not missing
