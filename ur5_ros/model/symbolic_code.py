"""Formulas as program text: common parts pulled out, one function a quantity."""

from collections.abc import Callable
from typing import Any

import sympy as sp

from ur5_ros.errors import InputError

#: What :func:`write_code` can write.
LANGUAGES = ('python', 'c', 'matlab', 'latex')

#: Written quantities: name, attribute of the formulas, whether the velocities enter.
_QUANTITIES = (('forward_kinematics', 'T', False), ('inertia_matrix', 'M', False),
               ('coriolis_matrix', 'C', True), ('gravity_torque', 'g', False))


def write_code(formulas: Any, language: str) -> str:
    """
    Return program text that computes the flange pose, M, C and g.

    ``language``: python needs the module math alone; C is C99; MATLAB is one file ``ur_model.m``
    that runs in Octave too, called as ``ur_model('inertia_matrix', q, qd, p)``; LaTeX is one
    ``align*`` a quantity.  Where parameters are symbols, functions take them as a last vector
    ``p``, in the order of ``formulas.parameters``.  Returned: the text; matrices are written row
    by row.
    """
    if language not in LANGUAGES:
        raise InputError(f'language is {language!r}; give one of: {", ".join(LANGUAGES)}')
    parts = []
    for name, attribute, moving in _QUANTITIES:
        matrix = getattr(formulas, attribute)
        matrix = matrix[-1] if attribute == 'T' else matrix
        steps, (reduced,) = sp.cse([matrix], symbols=sp.numbered_symbols('x'), order='none')
        vectors = [('q', formulas.q)]
        if moving:
            vectors.append(('qd', formulas.qd))
        if formulas.parameters:
            vectors.append(('p', formulas.parameters))
        parts.append(_WRITERS[language](name, vectors, steps, reduced))
    text = '\n\n'.join(parts)
    order = ', '.join(str(s) for s in formulas.parameters)
    return _frame(text, language, f'p = [{order}]' if order else 'numbers of one arm')


def _used(vectors, steps, reduced) -> list[tuple[str, int, sp.Symbol]]:
    free = set().union(reduced.free_symbols, *(value.free_symbols for _, value in steps))
    return [(name, i, symbol) for name, symbols in vectors
            for i, symbol in enumerate(symbols) if symbol in free]


def _python(name, vectors, steps, reduced) -> str:
    lines = [f'def {name}({", ".join(vector for vector, _ in vectors)}):']
    lines += [f'    {symbol} = {vector}[{i}]' for vector, i, symbol in _used(vectors, steps,
                                                                            reduced)]
    lines += [f'    {symbol} = {sp.pycode(value)}' for symbol, value in steps]
    rows = [', '.join(sp.pycode(entry) for entry in reduced.row(i)) for i in range(reduced.rows)]
    if reduced.cols == 1:
        return '\n'.join([*lines, f'    return [{", ".join(rows)}]'])
    return '\n'.join([*lines, '    return [', *(f'        [{row}],' for row in rows), '    ]'])


def _c(name, vectors, steps, reduced) -> str:
    inputs = ', '.join(f'const double {vector}[{len(symbols)}]' for vector, symbols in vectors)
    lines = [f'void {name}({inputs}, double out[{len(reduced)}])', '{']
    lines += [f'  const double {symbol} = {vector}[{i}];'
              for vector, i, symbol in _used(vectors, steps, reduced)]
    lines += [f'  const double {symbol} = {sp.ccode(value)};' for symbol, value in steps]
    lines += [f'  out[{i}] = {sp.ccode(entry)};' for i, entry in enumerate(reduced)]
    return '\n'.join([*lines, '}'])


def _matlab(name, vectors, steps, reduced) -> str:
    lines = [f'function out = {name}({", ".join(vector for vector, _ in vectors)})']
    lines += [f'  {symbol} = {vector}({i + 1});'
              for vector, i, symbol in _used(vectors, steps, reduced)]
    lines += [f'  {symbol} = {sp.octave_code(value)};' for symbol, value in steps]
    lines.append(f'  out = zeros({reduced.rows}, {reduced.cols});')
    lines += [f'  out({i + 1}, {j + 1}) = {sp.octave_code(reduced[i, j])};'
              for i in range(reduced.rows) for j in range(reduced.cols)]
    return '\n'.join([*lines, 'end'])


def _latex(name, vectors, steps, reduced) -> str:
    letter = {'forward_kinematics': 'T', 'inertia_matrix': 'M', 'coriolis_matrix': 'C',
              'gravity_torque': 'g'}[name]
    names = {symbol: rf'\dot q_{{{i + 1}}}' if vector == 'qd' else sp.latex(symbol)
             for vector, i, symbol in _used(vectors, steps, reduced)}

    def text(expression) -> str:
        return sp.latex(expression, symbol_names=names)

    lines = [f'{text(symbol)} &= {text(value)}' for symbol, value in steps]
    for i in range(reduced.rows):
        for j in range(reduced.cols):
            index = f'{i + 1}' if reduced.cols == 1 else f'{i + 1}{j + 1}'
            lines.append(f'{letter}_{{{index}}} &= {text(reduced[i, j])}')
    body = ' \\\\\n'.join(lines)
    return f'% {name}\n\\begin{{align*}}\n{body}\n\\end{{align*}}'


_WRITERS: dict[str, Callable[..., str]] = {
    'python': _python, 'c': _c, 'matlab': _matlab, 'latex': _latex}


def _frame(text: str, language: str, parameters: str) -> str:
    note = f'Flange pose, M, C and g of a UR arm; SI units; {parameters}'
    if language == 'python':
        return f'"""{note}."""\n\nimport math\n\n\n{text}\n'.replace('\n\ndef', '\n\n\ndef')
    if language == 'c':
        return f'/* {note}. */\n#include <math.h>\n\n{text}\n'
    if language == 'latex':
        return f'% {note}.\n{text}\n'
    cases = []
    for name, _, moving in _QUANTITIES:
        inputs = ', '.join(['q', *(['qd'] if moving else []),
                            *(['p'] if parameters.startswith('p') else [])])
        cases.append(f"    case '{name}'\n      out = {name}({inputs});")
    dispatch = '\n'.join(['function out = ur_model(what, q, qd, p)', f'% {note}.',
                          '  switch what', *cases, '    otherwise',
                          "      error('ur_model: unknown quantity %s', what);", '  end', 'end'])
    return f'{dispatch}\n\n{text}\n'
