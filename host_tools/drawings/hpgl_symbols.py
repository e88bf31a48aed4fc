"""Which letters the bytes of an HPGL label are: by the symbol set of SD or AD, without one by Roman-8, HP-GL/2's own.

    sets = SymbolSets()
    sets.choose("SD", [1, 277])
    sets.letters("\\xf61.0")         # "—1.0"
"""

_KIND = 1  # the first number of a pair of SD: the symbol set follows
_ROMAN_8 = "hp-roman8"
_CODECS = {14: "latin-1", 277: _ROMAN_8, 309: "cp1252", 341: "cp437", 405: "cp850", 629: "cp1252"}


class SymbolSets:
    def __init__(self):
        self.choose("IN", [])

    def choose(self, name, given):
        """Carry out SD, AD, SS, SA, IN or DF."""
        if name in ("IN", "DF"):
            self._sets, self._chosen = {"SD": None, "AD": None}, "SD"
        elif name in ("SS", "SA"):
            self._chosen = "SD" if name == "SS" else "AD"
        elif name in self._sets:
            pairs = dict(zip(given[::2], given[1::2]))
            self._sets[name] = int(pairs[_KIND]) if _KIND in pairs else None

    def letters(self, text):
        """The letters of a text whose bytes are read as Latin-1. Of a file that names no set, bytes that are UTF-8 are taken as such."""
        if text.isascii():
            return text
        data, number = text.encode("latin-1"), self._sets[self._chosen]
        if number is None:
            try:
                return data.decode("utf-8")
            except UnicodeDecodeError:
                pass
        return data.decode(_CODECS.get(number, _ROMAN_8), "replace")
