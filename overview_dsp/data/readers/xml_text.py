"""XML as text that no parser can be harmed by: UTF-8, without a document type."""

from __future__ import annotations

import re

from overview_dsp.data.readers.source import Source
from overview_dsp.errors import InputError

_DECLARATION = re.compile(r"\s*<\?xml\b[^>]{0,200}\?>")
_ROOT = re.compile(r"<([A-Za-z_][\w.:-]{0,99})[\s/>]")
_ASIDE = re.compile(r"<!--.*?-->|<\?.*?\?>", re.S)


def root_name(source: Source) -> str:
    """Return the name of an XML file's outermost element without its prefix, "" for no XML."""
    if source.head_text is None or not source.head_text.lstrip().startswith("<"):
        return ""
    found = _ROOT.search(_ASIDE.sub("", source.head_text))
    return found[1].rpartition(":")[2] if found else ""


def xml_text(source: Source) -> str:
    """Return an XML file's text without its declaration, as what it was decoded by may differ.

    Raises
    ------
    InputError
        A document type: its entities can make gigabytes of a few lines or read other files, and no
        format that is read here has one; what `Source.text` raises.
    """
    text = source.text
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(
            f"{source.where}: the XML has a document type (<!DOCTYPE ...>), which may hide a bomb; "
            "remove it"
        )
    return _DECLARATION.sub("", text, count=1)
