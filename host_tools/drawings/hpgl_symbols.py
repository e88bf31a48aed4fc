"""Which letters the bytes of an HPGL label are: by the symbol set of SD or AD, or by CS and CA of older plotters; without one by Roman-8,
HP-GL/2's own.

    sets = SymbolSets()
    sets.choose_set("SD", [1, 277])
    sets.decode_letters("\\xf61.0")         # "—1.0"
"""

import re

_KIND = 1  # the first number of a pair of SD: the symbol set follows
_ROMAN_8 = "hp-roman8"
_CODECS = {14: "latin-1", 277: _ROMAN_8, 309: "cp1252", 341: "cp437", 405: "cp850", 629: "cp1252"}
_PLACES = "#$@[\\]^`{|}~"  # of ASCII, where each country has letters of its own (ISO 646)
_NATIONAL = {  # by the number of CS: the letters there
    30: "#¤@ÄÖÅ^`äöå~", 31: "#¤ÉÄÖÅÜéäöåü", 32: "#$@ÆØÅ^`æøå~", 33: "#$§ÄÖÜ^`äöüß", 34: "£$à°ç§^µéùè¨", 35: "£$@[\\]^`{|}~",
    36: "£$§°çé^ùàòèì", 37: "£$§¡Ñ¿^`°ñç~", 38: "#$§ÃÇÕ^`ãçõ°", 39: "§$@ÆØÅ^`æøå|",
}  # fmt: skip
_OF_SD = {115: 30, 19: 31, 4: 32, 39: 33, 38: 34, 37: 35, 9: 36, 83: 37, 147: 38, 36: 39}
_ASCII = (0, 5, 6)  # of CS
_SHIFT = re.compile("([\x0e\x0f])")  # to the alternate set, and back


class SymbolSets:
    def __init__(self):
        self.choose_set("IN", [])

    def choose_set(self, name, given):
        """Carry out SD, AD, CS, CA, SS, SA, IN or DF; False if a set is not known."""
        if name in ("IN", "DF"):
            self._sets, self._chosen = {"SD": None, "AD": None}, "SD"
        elif name in ("SS", "SA"):
            self._chosen = "SD" if name == "SS" else "AD"
        elif name in self._sets:
            pairs = dict(zip(given[::2], given[1::2]))
            number = int(pairs[_KIND]) if _KIND in pairs else None
            self._sets[name] = _OF_SD.get(number, number)
        elif name in ("CS", "CA"):
            number = int(given[0]) if given else 0
            self._sets["SD" if name == "CS" else "AD"] = number if number in _NATIONAL else None
            return number in _NATIONAL or number in _ASCII
        return True

    def decode_letters(self, text):
        """The letters of a text whose bytes are read as Latin-1. Of a file that names no set, bytes that are UTF-8 are taken as such."""
        found = ""
        for part in _SHIFT.split(text):
            if part in ("\x0e", "\x0f"):
                self._chosen = "AD" if part == "\x0e" else "SD"
            else:
                found += self._of_set(part)
        return found

    def _of_set(self, text):
        """Return a text's letters by the chosen set. A national set (ISO 646) has letters of its own at _PLACES; bytes from 128 on are read by
        _of_bytes()."""
        national = _NATIONAL.get(self._sets[self._chosen])
        if national:
            text = text.translate(str.maketrans(_PLACES, national))
            return text if text.isascii() else "".join(self._of_bytes(each) if ord(each) in range(128, 256) and each not in national else each for each in text)
        return text if text.isascii() else self._of_bytes(text)

    def _of_bytes(self, text):
        """Return a text's letters by the chosen set's codec, by default Roman-8; without a set as UTF-8, if its bytes are. Unknown bytes become
        U+FFFD."""
        data, number = text.encode("latin-1"), self._sets[self._chosen]
        if number is None:
            try:
                return data.decode("utf-8")
            except UnicodeDecodeError:
                pass
        return data.decode(_CODECS.get(number, _ROMAN_8), "replace")
