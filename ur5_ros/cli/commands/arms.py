"""The command ``ur5 arm``: the arms there are, and new ones from a URDF or a calibration."""

from pathlib import Path

from ur5_ros.cli.commands.lists import arms
from ur5_ros.cli.exit_codes import SUCCESS
from ur5_ros.errors import InputError


def arm(urdf: Path | None, calibration: Path | None, name: str | None, out: Path | None) -> int:
    """List the arms, or write an arm file; see ``ur5 arm --help``."""
    if urdf is None and calibration is None:
        if out is not None or name is not None:
            raise InputError('an arm file is made of a file: give --urdf FILE or --calibration '
                             'FILE')
        return arms()
    if urdf is not None and calibration is not None:
        raise InputError('--urdf and --calibration: give one of the two')
    if out is None:
        raise InputError('give the arm file to write: -o FILE')
    from ur5_ros.config.arm_writer import arm_file_text, write_new_file
    if out.exists():
        raise InputError(f'{out} exists already; give another file')
    if calibration is not None:
        from ur5_ros.config.foreign_arms.calibration import calibrated_arm_text
        text, sentences = calibrated_arm_text(calibration, name)
    else:
        assert urdf is not None
        if name is not None:
            raise InputError('--arm is for --calibration; a URDF describes its own arm')
        from ur5_ros.config.foreign_arms.urdf_arm import arm_of_urdf, mass_beyond_tool
        data = _recorded_urdf(urdf)
        found = arm_of_urdf(urdf, out.stem, data)
        source = f'URDF {urdf.name}'
        text = arm_file_text(found, f'Made of the URDF {urdf.name}.', source, source)
        sentences = [f'masses of {found.mass.sum():.4g} kg, reach of '
                     f'{abs(found.a).sum() + found.d[4]:.4g} m; rotor inertia is not in a URDF: '
                     'zero']
        if beyond := mass_beyond_tool(urdf, data):
            sentences.append(f'links that move behind the six joints were left out: {beyond:.4g} '
                             'kg; give them as a payload')
    write_new_file(out, text)
    for sentence in (*sentences, f'written: {out}'):
        print(sentence)
    return SUCCESS


def _recorded_urdf(path: Path) -> bytes | None:
    """Return the URDF that a bag recorded; None where the path is none of a bag."""
    if not (path.is_dir() or path.suffix in ('.mcap', '.db3')):
        return None
    from ur5_ros.analysis.data.bags import open_bags
    from ur5_ros.analysis.data.described_arm import ROLE, urdf_in
    for bag in open_bags(path)[0]:
        if bag.has(ROLE):
            return urdf_in(bag)
    raise InputError(f'{path}: no /robot_description in it; give the URDF as a file')
