"""The one exception that a user's mistake raises."""


class Refusal(ValueError):
    """
    An input is refused; the message is one line: the value, the limit, the way out.

    Command lines and nodes print it without a traceback and exit with code 2.

    """
