"""What rounding leaves is no signal: it is written as a number and never drawn as a band."""

import base64
import re

import numpy as np

from ur5_ros.analysis.report.figure import Figure, packed

#: Values below these mean nothing, by unit: far above the rounding of double precision, far
#: below what any sensor of a robot resolves.
RESOLUTION = {'N m': 1e-10, 'rad': 1e-12, 'mm': 1e-8, 'mrad': 1e-9, 'm': 1e-11, 'J': 1e-9,
              'rad/s': 1e-11, 'N': 1e-9}


def without_rounding(figure: Figure) -> Figure:
    """
    Return a figure without what is rounding alone.

    Where all curves are below the resolution of their unit, a sentence stands in their place; on a
    logarithmic axis values below it become gaps.
    """
    unit = re.search(r'\[([^],]+)', figure.y)
    smallest = RESOLUTION.get(unit[1], 0.0) if unit else 0.0
    curves = [np.abs(_unpacked(trace['y'])) for trace in figure.traces if 'bdata' in trace['y']]
    if not smallest or not curves or len(curves) < len(figure.traces):
        return figure
    known = [values[np.isfinite(values)] for values in curves]
    most = max((float(values.max()) for values in known if len(values)), default=0.0)
    if most < smallest:
        return figure._replace(traces=[], note=f'Within rounding: at most {most:.2g} '
                               f'{unit[1] if unit else ""}.')
    if not figure.log:
        return figure
    traces = [{**trace, 'y': packed(np.where(values < smallest, np.nan, values))}
              for trace, values in zip(figure.traces, curves, strict=True)]
    return figure._replace(traces=[trace for trace, values in zip(traces, curves, strict=True)
                                   if (values >= smallest).any()])


def _unpacked(data: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(data['bdata']), dtype='<f4')
