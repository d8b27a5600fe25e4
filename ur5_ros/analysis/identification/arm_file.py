"""An identified arm as an arm file."""

from pathlib import Path

import numpy as np

from ur5_ros.analysis.identification.identify import Identified
from ur5_ros.config.arm_writer import arm_file_text, write_new_file


def write_arm(found: Identified, path: Path | str) -> None:
    """Write an identified arm as a file that every command takes for ``--arm``."""
    write_new_file(path, identified_yaml(found))


def identified_yaml(found: Identified) -> str:
    """Return an identified arm, its friction included, as the YAML text of an arm file."""
    source = (f'identified by least squares and the nearest physical arm; torque error on '
              f'{found.test_run}: '
              + ', '.join(f'{value:.2g}' if np.isfinite(value) else '-'
                          for value in found.test_rms) + ' N m RMS a joint')
    if not found.base:
        source = ('bodies and rotors as in the arm that the identification began with; drives and '
                  'friction from motor currents')
    return arm_file_text(found.arm, 'Identified from recorded torques.', source,
                         'as the arm that the identification began with')
