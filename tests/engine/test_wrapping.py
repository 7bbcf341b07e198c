"""Words for a person: lines no longer than asked for, and nothing lost but line breaks."""

import pytest

from fibermelt.engine.wrapping import LEAST_WIDTH, hanging, unbroken, wrapped

LINE = "what to do      Dry below 0.014 %, so that the melt cannot boil, and slow down to 11 mm/s."
ROW = "period [s]      r_e                1       3       6       8      10      12      14      16"


def test_what_follows_stands_under_the_text():
    first, *others = wrapped([LINE], 70).split("\n")
    assert first == "what to do      Dry below 0.014 %, so that the melt cannot boil, and"
    assert others == [" " * 16 + "slow down to 11 mm/s."]


@pytest.mark.parametrize("width", range(LEAST_WIDTH, 100, 7))
def test_no_word_is_lost_and_no_line_too_long(width):
    lines = [LINE, "a sentence without a label " * 5, f"{'':16}{'under one ' * 20}"]
    told = wrapped(lines, width)
    assert told.split() == " ".join(lines).split()
    assert max(map(len, told.split("\n"))) <= width


@pytest.mark.parametrize("line", [ROW, LINE[:40], "", "x" * 200, "label           " + "x" * 200])
def test_what_fits_or_is_a_row_of_a_table_stays_as_it_is(line):
    assert wrapped([line], 80) == line


def test_a_path_stays_in_one_piece():
    path = "a folder/of many words/that is longer/than any line/may be here/and still one"
    assert wrapped([f"results         {unbroken(path)}"], 60).endswith(path)


@pytest.mark.parametrize(
    "pair", ["x = 817 Pa s;", "5.72 kPa", "0.63 %", "7 deg", "230 degC", "2 s"]
)
def test_numbers_keep_their_unit_and_their_equals_sign(pair):
    """All but the last word of the pair would fit."""
    fits = LEAST_WIDTH - len(f"label   {pair.rpartition(' ')[0]}")
    told = hanging("label   ", f"{'x' * (fits - 1)} {pair} and so on", LEAST_WIDTH)
    assert told.split("\n")[1] == f"        {pair} and so on"


def test_a_terminal_too_narrow_has_lines_that_can_be_read():
    assert wrapped([LINE], 1) == wrapped([LINE], LEAST_WIDTH)
