"""Names and colours of joints and curves, the same in report, viewer, render and layouts."""

#: One colour a joint; each stands out on white and on black.
JOINT_COLOURS = ('#3d85c6', '#e0803a', '#3fa66b', '#d0505e', '#9070c8', '#a08438')
#: Short names of the joints, base to wrist.
SHORT_NAMES = ('pan', 'lift', 'elbow', 'wrist 1', 'wrist 2', 'wrist 3')
#: What was measured, and what it should have been; no colour below is near one of a joint.
MEASURED, REFERENCE = '#0b9c9c', '#c83cb4'
#: What succeeded and what failed.
GOOD, BAD = '#2a5bff', '#ff2a1a'
#: The axes x, y and z, and what is given along or about them.
AXIS_COLOURS = ('#ff2a1a', '#0a9a00', '#2a5bff')
#: Things of one kind, side by side: parts of a torque, laws.
SERIES_COLOURS = ('#7f7f7f', '#5b4fe0', '#ff2a1a', '#5aa800', '#8c564b', '#0b9c9c', '#c83cb4',
                  '#e6005c')


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue of a colour ``#rrggbb``, 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
