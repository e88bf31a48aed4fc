"""Labels of HPGL: the sets of letters that older plotters choose by CS and CA, letters with accents, the space of ES; and lines without a pen."""

import numpy
import pytest

from host_tools.drawings import sources, stroke_font
from host_tools.drawings.hpgl_symbols import SymbolSets

SETS = {  # by the number of CS: the plotter's letters for #$@[\]^`{|}~, as ISO 646 has them
    33: "#$§ÄÖÜ^`äöüß", 32: "#$@ÆØÅ^`æøå~", 31: "#¤ÉÄÖÅÜéäöåü", 34: "£$à°ç§^µéùè¨", 36: "£$§°çé^ùàòèì", 37: "£$§¡Ñ¿^`°ñç~", 38: "#$§ÃÇÕ^`ãçõ°", 0: "#$@[\\]^`{|}~",
}


def drawn(folder, words):
    path = folder / "a.plt"
    path.write_bytes(b"IN;SP1;SI0.5,0.8;PU1000,1000;" + words.encode("latin-1") + b"PU;")
    page = sources.open_drawing(path).outlines(0.01)
    return [line.round(3).tolist() for lines in page.layers.values() for line in lines], dict(page.left_out)


@pytest.mark.parametrize("number", SETS)
def test_the_letters_of_each_country(number):
    sets = SymbolSets()
    assert sets.choose_set("CS", [number]) and sets.decode_letters("#$@[\\]^`{|}~ abc") == SETS[number] + " abc"
    sets.choose_set("IN", [])
    assert sets.decode_letters("#[") == "#["


def test_german_letters_are_drawn_by_cs_by_sd_and_by_shifts(tmp_path):
    """hp2xx has the same by CS33; a shift takes the alternate set, also in a later label."""
    wanted = drawn(tmp_path, "SD1,14;LBaÄÖÜ\3")
    assert wanted[1] == {} and len(wanted[0]) > 10
    for words in ("CS33;LBa[\\]\3", "SD1,39;LBa[\\]\3", "CS0;CA33;LBa\x0e[\\]\3", "CA33;LBa\x0e\3LB[\\]\3", "CA33;LBa\3SA;LB[\\]\3", "CS33;CA0;LB\x0e\x0fa[\\]\3"):
        assert drawn(tmp_path, words) == wanted, words


def test_a_set_that_is_not_known_is_named(tmp_path):
    assert drawn(tmp_path, "CS8;LBA\3")[1] == {"letters of a set that is not known (drawn as ASCII)": 1}


@pytest.mark.parametrize("letters", ["áàâãéêíóôõúüçÁÀÂÃÉÊÍÓÔÕÚÜÇñÑ", "äöüßåæøÄÖÜÅÆØ", "£§¿¡¨°±µ·×"])
def test_letters_with_accents_are_drawn(tmp_path, letters):
    assert drawn(tmp_path, f"SD1,14;LB{letters}\3")[1] == {}


@pytest.mark.parametrize("base, letter", [("a", "á"), ("A", "Ã"), ("o", "ô"), ("e", "è"), ("u", "ü"), ("O", "Ó")])
def test_an_accent_stands_above_its_letter(base, letter):
    plain, accented = stroke_font.letter_strokes(base), stroke_font.letter_strokes(letter)
    top = max(stroke.imag.max() for stroke in plain)
    assert all((a == b).all() for a, b in zip(plain, accented)) and len(accented) > len(plain)
    more = numpy.concatenate(accented[len(plain) :])
    assert more.imag.min() > top and more.imag.max() < top + 0.35 and abs(more.real).max() < 0.3


def test_a_cedilla_hangs_below_and_an_i_loses_its_dot():
    assert min(stroke.imag.min() for stroke in stroke_font.letter_strokes("ç")) < -0.15 and max(stroke.imag.max() for stroke in stroke_font.letter_strokes("ç")) < 0.7
    assert len(stroke_font.letter_strokes("í")) == len(stroke_font.letter_strokes("i"))


@pytest.mark.parametrize("words, gap, down", [("", 300, 640), ("ES0.5;", 450, 640), ("ES0.5,1;", 450, 1280), ("ES-0.2,0.25;", 240, 800), ("ES1;ES;", 300, 640)])
def test_es_spreads_letters_and_lines(tmp_path, words, gap, down):
    """In cells of one and a half widths and two heights, as hp2xx has them."""
    unit = 96 / 25.4 / 40
    lines, left_out = drawn(tmp_path, f"{words}LBII\r\nI\3")
    places = [line[0] for line in lines]
    assert left_out == {} and len(places) == 3
    assert abs(places[1] - places[0]).real == pytest.approx(gap * unit, abs=0.01) and places[2].real == places[0].real
    assert abs(places[2].imag - places[0].imag) == pytest.approx(down * unit, abs=0.01)


def test_lines_without_a_pen_are_left_out_and_named(tmp_path):
    """As hp2xx has it; a file that names no other pen is drawn."""
    lines, left_out = drawn(tmp_path, "PD2000,1000;PU;SP0;PU0,0;PD9,9,99,0;PU3,3;PD5,5;")
    assert len(lines) == 1 and left_out == {"line without a pen (SP0)": 2}
    path = tmp_path / "b.plt"
    path.write_text("IN;SP0;PU0,0;PD400,0;")
    page = sources.open_drawing(path).outlines(0.01)
    assert len(page.layers[1]) == 1 and not page.left_out
