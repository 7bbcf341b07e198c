"""The glossary: words are defined once, and used on the page by the name that they are found by."""

from fibermelt.report.kit.glossary import TERMS, glossary


def test_every_word_is_defined_once_and_has_a_place_of_its_own() -> None:
    names, anchors = ([getattr(one, name) for one in TERMS] for name in ("name", "anchor"))
    assert len({name.lower() for name in names}) == len(names)
    assert len(set(anchors)) == len(anchors)
    page = glossary()
    for term in TERMS:
        assert page.count(f'id="{term.anchor}"') == 1
        assert term.meaning.endswith(".")
    assert page.startswith('<details class="glossary" id="glossary">')


def test_it_has_what_the_page_links_to() -> None:
    assert "term-sharp-corner" in {term.anchor for term in TERMS}
