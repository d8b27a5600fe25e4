"""What is raised when a bag, or a message in one, is damaged or hostile."""

from ur5_ros.errors import Refusal


class BagProblem(Refusal):
    """A file is not what it claims to be; the message is one line: which file and what."""
