"""Files that are no timeline: one line says what each is and what to do."""

from __future__ import annotations

import pytest

import overview_dsp as ov

RSS = '<rss version="2.0"><channel><title>News</title><item><pubDate>Mon, 01 Jan</pubDate></item>'
ATOM = '<feed xmlns="http://www.w3.org/2005/Atom"><title>a</title><updated>2024-01-01</updated>'
LOGIN = '<!DOCTYPE html><html><body><form><input type="password" name="p"></form></body></html>'

DOCUMENTS = [
    ("feed.xml", f'<?xml version="1.0"?>\n{RSS}</channel></rss>', "news feed", "CSV"),
    ("feed.csv", f"{RSS}\n</channel></rss>\n", "news feed", "CSV"),
    ("atom.xml", f'<?xml version="1.0"?>\n<!-- a, b -->\n{ATOM}</feed>', "news feed", "CSV"),
    ("atom.json", ATOM, "news feed", "CSV"),
    ("rdf.xml", '<rdf:RDF xmlns:rdf="x"><item>1,2</item></rdf:RDF>', "news feed", "CSV"),
    ("song.lrc", "[ar:A]\n[ti:B]\n[00:01.00]one\n[00:02.50]two\n", "lyrics", "time and label"),
    ("song.txt", "\n[00:01.00]one, two\n[00:02.50]three, four\n", "lyrics", "time and label"),
    ("page.html", "<!DOCTYPE html>\n<html><p>1,2\n3,4\n</html>", "web page", "table as CSV"),
    ("table.csv", "\ufeff<html><table><tr><td>1</td></tr></table></html>", "web page", "CSV"),
    ("part.csv", "<head><title>1,2</title></head>\n<body>3,4</body>", "web page", "CSV"),
    ("xhtml.csv", '<?xml version="1.0"?><html><body>a</body></html>', "web page", "CSV"),
    ("data.csv", LOGIN, "login page", "sign in"),
    ("data.json", LOGIN.lower(), "login page", "sign in"),
    ("blank.csv", " \r\n\t\n", "blanks only", "get it again"),
    ("empty.json", "", "empty", "get it again"),
]


@pytest.mark.parametrize(("name", "text", "what", "remedy"), DOCUMENTS, ids=lambda one: one[:12])
def test_a_document_of_another_kind_is_named_in_one_line(tmp_path, name, text, what, remedy):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ov.InputError) as refused:
        ov.load_timeline(path)
    message = str(refused.value)
    assert "\n" not in message
    assert name in message
    assert what in message
    assert remedy in message


@pytest.mark.parametrize(
    "text",
    [
        "[12:30:45] started\n[12:31:10] connected\n[12:33:02] stopped\n",
        "time,label\n1,<html>\n2,[ti:x]\n",
        '<gpx><metadata><head/><body>a</body></metadata><trk><trkseg><trkpt lat="1" lon="2">'
        '<time>2024-01-01T00:00:00Z</time></trkpt><trkpt lat="1" lon="2.1">'
        "<time>2024-01-01T00:00:09Z</time></trkpt></trkseg></trk></gpx>",
    ],
    ids=["log", "labels", "track"],
)
def test_a_log_and_labels_that_look_like_markup_are_read(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text)
    assert ov.load_timeline(path).duration_s > 0
