"""The error for users: one line that names the fault, its place, and the cure."""

from host_tools.language import _, board_file_error, fill_in


class Failure(Exception):
    """Ends a verb of `passo` with its text on stderr and exit status 1.

        raise Failure("no file {}", path)       # a text of the catalogue (language.py), and the values for its fields

    str() is English, told() the language that was chosen. A value may be another failure."""

    def __str__(self):
        return fill_in(*self.args) if self.args else ""

    def message(self):
        """Return the text in the current language. Half a character, which no terminal takes, is shown by its number."""
        text = _(*(each.message() if isinstance(each, Failure) else each for each in self.args)) if self.args else ""
        return text.encode("utf-8", "backslashreplace").decode()


def reason(error):
    """Return the reason why the system refused something (an OSError), or the firmware a board file (BoardError), in the language that was chosen; of
    any other error its own words."""
    why = getattr(error, "strerror", None)
    return _(why) if why else board_file_error(str(error))
