"""Numbers as a person reads them: as many digits as their interval allows."""

import importlib

import pytest

NAME = "bl_ext.user_default.ringdown"


@pytest.fixture
def words(rd):
    return importlib.import_module(f"{NAME}.addon.words")


@pytest.mark.parametrize(
    ("value", "interval", "text"),
    [
        (0.148, [0.1, 0.2], "0.148 ± 0.050"),
        (2931.4, [2889, 2973], "2931 ± 42"),
        (0.148321, [0.148321, 0.148321], "0.148"),
        (5.2641, None, "5.26"),
    ],
)
def test_a_number_has_the_digits_that_its_interval_leaves(words, value, interval, text):
    assert words.number({"value": value, "ci95": interval}) == text


@pytest.mark.parametrize(
    ("part", "text"), [(0.0273, "2.7 %"), (1.572, "157 %"), (0.0996, "10 %"), (0.0, "0.0 %")]
)
def test_a_share_is_in_per_cent(words, part, text):
    assert words.share(part) == text


def test_lines_break_between_words_and_lose_none(words):
    text = "hold it for a minute before one release and for a moment before the next"
    lines = words.wrapped(text, 20)
    assert max(map(len, lines)) <= 20
    assert " ".join(lines) == text


def test_sizes_share_one_unit(words):
    assert words.size([0.08, 0.068, 0.0599], "METRIC") == "8.00 × 6.80 × 5.99 cm"
    assert words.size([2.54, 0.5, 0.1], "IMPERIAL").endswith(" ft")
