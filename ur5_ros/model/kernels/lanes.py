"""States side by side: copied so that the processor works on eight of them at once."""

from ur5_ros.model.kernels.compiled import inlined

#: States side by side; number i of state ``lane`` stands at i * LANES + lane.
LANES = 8


@inlined
def gather(x, first, count, lanes):
    """Copy six numbers of each of ``count`` states side by side; repeat the last to fill up."""
    for lane in range(LANES):
        state = first + min(lane, count - 1)
        for i in range(6):
            lanes[i * LANES + lane] = x[6 * state + i]


@inlined
def scatter(lanes, rows, first, count, x):
    """Copy back ``rows`` numbers of each of ``count`` states, one state after the other."""
    for lane in range(count):
        for i in range(rows):
            x[rows * (first + lane) + i] = lanes[i * LANES + lane]


@inlined
def put(out, at, step, i, j, value):
    """Write an entry of a matrix that stands in six rows."""
    out[at + i, j] = value


@inlined
def store_simd(out, at, step, i, j, value):
    """Write an entry of one of eight matrices side by side."""
    out[at + (6 * i + j) * step] = value
