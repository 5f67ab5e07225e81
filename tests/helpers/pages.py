"""Links of a Markdown page, and the anchors that its headings have where it is shown; what elements HTML has."""

import re
from html.parser import HTMLParser

_FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\]\((?![a-z]+:)([^)#\s]*)(?:#([^)\s]*))?\)")


def links(text):
    """Relative links outside of blocks of code, as (file, anchor); either may be empty."""
    return _LINK.findall(re.sub(r"`[^`\n]*`", "", _FENCE.sub("", text)))


def anchors(text):
    """The names of the headings, as GitHub and MyST make them."""
    headings = re.findall(r"^#+ (.*)$", _FENCE.sub("", text), re.MULTILINE)
    words = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w\- ]", "", word).strip().lower().replace(" ", "-") for word in words}


class _Tags(HTMLParser):
    def __init__(self):
        super().__init__()
        self.names = set()

    def handle_starttag(self, tag, attrs):
        self.names.add(tag)


def tags(*texts):
    """The names of all elements in pieces of HTML."""
    parser = _Tags()
    for text in texts:
        parser.feed(text)
        parser.close()
        parser.rawdata = ""
    return parser.names
