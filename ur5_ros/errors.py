"""What a user's mistake, or a damaged bag, raises."""

#: Longest sentence about a bag; names in hostile files have any length.
MAX_LENGTH = 500


def one_line(sentence: str) -> str:
    """Return a sentence that may hold names out of a file as one line of bounded length."""
    plain = ''.join(each if each.isprintable() else '?' for each in sentence)
    return plain if len(plain) <= MAX_LENGTH else plain[:MAX_LENGTH] + '...'


class InputError(ValueError):
    """
    An input is refused; the message is one line: the value, the limit, the way out.

    Command lines and nodes print it without a traceback and exit with code 2.

    Examples
    --------
    >>> from ur5_ros import InputError, load_arm
    >>> try:
    ...     load_arm('ur6')
    ... except InputError as error:
    ...     print(str(error)[:17])
    unknown arm 'ur6'

    """


class BagError(InputError):
    """A file is not what it claims to be; the message is one line: which file and what."""

    def __init__(self, sentence: str) -> None:
        super().__init__(one_line(sentence))
