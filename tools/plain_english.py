"""Count unplain English in a checkout: docstrings, messages, help texts, docs and names.

This prints each finding and a table of counts. It exits with 1 if a category has more findings than
its limit (`--limit N`, `--limit CATEGORY=N`; default 0). CONTRIBUTING.md has the rules. Tuning of
the patterns ended when librosa, httpx, resampy and pedalboard had almost no findings.
"""

import argparse
import ast
import os
import re
import sys
from collections import Counter
from itertools import accumulate
from pathlib import Path

CATEGORIES = {
    "summary": "docstring summaries that begin with neither an imperative nor a noun phrase",
    "idiom": "idioms in docstrings, messages, help texts, docs and page texts",
    "help": "help texts of options and commands without a verb or noun to begin with",
    "name": "names of modules, classes, functions, parameters and fields with a banned word",
    "docs": "docs sentences over 32 words, and paragraphs that continue a code block",
}
LONGEST_SENTENCE = 32
NOT_SOURCES = set(
    ".git venv .venv node_modules site-packages _build _generated gallery generated".split()
)
SKIPPED = re.compile(
    r"(.*/)?((\.git|tests?|build|_build|dist)/|CHANGE|LICENSE|CODE_OF|HISTORY|test_)"
)

NOT_A_PHRASE = (
    "what|where|how|whether|which|who|whose|when|why|whatever|whoever|that|so|because|"
    "of|by|from|with|as|in|on|at|after|before|between|under|beside|behind|within|without|until|"
    "through|among|beyond|up|out|about|since|over|against|towards?|"
    "its?|they|their|them|he|she|you|your|nothing|nobody|somebody|and|or|but|not|also|only|"
    "told|said|made|kept|found|asked|taken|begun|gone|known|seen|heard|says|tells|lets|"
    "goes|felt(?! levels?)"
)
SUMMARY = re.compile(rf"({NOT_A_PHRASE})\b(?!-)", re.I)
HELP = re.compile(rf"({NOT_A_PHRASE}|again|if|for|-?\d|Hz|dB|ms)\b", re.I)

IDIOM = re.compile(
    "|".join(
        [  # speech of programs; clauses for nouns; private metaphors; ellipsis
            r"\b(is|are|was|were|be|been|being) (told(?! apart)|said|believed|begun|left alone|let go|meant[.,;)])",
            r"\btold (of|by|as|that|what|in|about|besides)\b|\b([Tt]ells?|telling) of\b|\bheard of\b",
            r"\bsa(ys?|id) (what|so|where|whether|nothing)\b|\basked (of|since|again)\b",
            r"\bwhat (came|comes|is there|was there|there is|is new|is left|happened|lies|follows[.,])",
            r"\bwhat (is|was|were|are) \w+(ed|t|en|ght|rd)\b(?=[.,;:)]| (by|of|in|on|from|at)\b)",
            r"\b(within|from|beside|under|over|behind|above|after|with|of) what (?!extent|kind|is |went)\w",
            r"\bwhat (an?|the|each|every|it|they|its|this|one) ([\w'-]+ ){0,4}?"
            r"(is given|gets?|gives?|holds?|makes? of|does to|bears?|says?|amounts? to|stands? for)\b",
            r"\b(at|behind|through) the door\b|: the door\b|'s door\b|\bunder (the|a|its|this) (hand|finger)\b",
            r"\b(a|the) (\w+ )?hands? (that|which|is|was|holds?|gets|lets|feels|comes|goes|plays|has|does)\b",
            r"\bholds? on(?! to)\b|\b[Ll]ets? go\b|\b[A-Z][a-z ]+ in, [a-z' ]+ out\b|\bin any cuts\b|the face of\b",
            r"\b(lies|lie|lay) (still|there|beside|ahead|under|behind)\b|\b(has|have|had) (come|gone)\b",
            r"\b(at a look|at a glance|in words|for want of|by chance|of chance|to be had|whoever)\b",
            r"\bpersons?'s?\b|\b[Aa] person\b|\bpeople's\b|\bwho (reads|asks|holds|doesn't|can't|hears)\b",
            r"\bso (long|many|much|large|deep|often)(?=[.;:)]| an? )|\b(after|within|for|than) so long\b",
            r"\b(anew|meanwhile)\b|\bbesides[.,;)]|\b(goes|go|went) on (where|as|until|with)\b",
            r"\bthere (twice|already)\b|\bplays? on[.,;]|\bis there(?=[.,;)])|\bisn't there\b|\bin its place\b",
            r"(?<!there )(?<!There )\b(is|are) (no|none|nothing)\b(?! longer| more| need| way| such| diff"
            r"| one| guarantee| good| harm| problem| reason| doubt|t )",
            r"; (it|they) (is|are) (?=X|\d|an? |one of|or |the |true|rest|whole|finite|not |letters|none)",
            r"\b(an?|one) (line|row|file|column|number|entry|object|sentence|picture|key|command|folder|name"
            r"|curve|message|value|table|mark|lane|ring|step|connection) (an?|each) (?!few|lot|given)\w+",
            r"\bto the bit\b|\bpassed over\b|\btakes? the place of\b|\bas (it|they) (is|was|are|were)[.;]",
        ]
    )
)
BANNED_WORDS = set(
    "told tells said says kept given made came comes asked asks shown met happened happening door "
    "c_abi everyday worth story struck wanted wish gathered noticed apart beside alike ahead hears "
    "heard lies words chance obey begun bears nobody somebody hand hands place places speaks "
    "spoken due anew grown aside".split()
)
MESSAGE_CALLS = re.compile(r"(Error|Warning|Exception|warn|warning|error|say|_say|note|echo|fail)$")


class Findings(list):
    def add(self, category, path, line, text):
        self.append((category, path, line, " ".join(text.split())[:110]))

    def add_idioms(self, path, line, text):
        text = re.sub(r"``?[^`\n]*``?|\]\([^)]*\)|https?://\S+", "X", text)
        rows = [row.strip() for row in text.split("\n")]
        flat, ends = " ".join(rows), list(accumulate(len(row) + 1 for row in rows))
        for match in IDIOM.finditer(flat):
            here = line + sum(end <= match.start() for end in ends)
            self.add("idiom", path, here, flat[max(0, match.start() - 25) : match.end() + 25])


def text_of(node):
    """Return the text of a string expression with X for placeholders; "" for anything else."""
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) or "X" for part in node.values)
    if isinstance(node, ast.BinOp):
        return text_of(node.left) + text_of(node.right)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def is_banned(name):
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)
    return name != "connection_made" and any(word.lower() in BANNED_WORDS for word in words)


def check_python(path, display_path, findings):
    tree = ast.parse(path.read_text("utf-8"))
    tree.name, tree.lineno = path.parent.name if path.stem == "__init__" else path.stem, 1
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            check_docstring(node, display_path, findings)
            check_names(node, display_path, findings)
        elif isinstance(node, ast.Call):
            check_call(node, display_path, findings)


def check_docstring(node, display_path, findings):
    doc = ast.get_docstring(node)
    if not doc:
        return
    line, summary, decorators = (
        node.body[0].lineno,
        doc.split("\n")[0],
        getattr(node, "decorator_list", []),
    )
    if isinstance(node, ast.Module):  # a module may begin with its name and a colon
        summary = re.sub(r"^[\w `'.()-]{1,40}: (?=\w)", "", summary)
    if SUMMARY.match(summary) and node.name != "__init__":
        findings.add("summary", display_path, line, summary)
    if HELP.match(summary) and any("command(" in ast.unparse(one) for one in decorators):
        findings.add("help", display_path, line, summary)
    findings.add_idioms(display_path, line, re.sub(r"^ *(>>>|\.\.\. ).*$", "", doc, flags=re.M))


def check_names(node, display_path, findings):
    names = [(node.name, node.lineno)]
    if hasattr(node, "args"):
        names += [(one.arg, one.lineno) for one in ast.walk(node.args) if isinstance(one, ast.arg)]
    else:
        fields = [one for one in node.body if isinstance(one, ast.AnnAssign)]
        names += [(ast.unparse(one.target), one.lineno) for one in fields]
    for name, line in names:
        if is_banned(name):
            findings.add("name", display_path, line, name)


def check_call(node, display_path, findings):
    for keyword in node.keywords:
        text = text_of(keyword.value) if keyword.arg in ("help", "short_help", "epilog") else ""
        findings.add_idioms(display_path, keyword.value.lineno, text)
        if HELP.match(text.strip()):
            findings.add("help", display_path, keyword.value.lineno, text)
    if MESSAGE_CALLS.search(ast.unparse(node.func)):
        for argument in node.args:
            findings.add_idioms(display_path, argument.lineno, text_of(argument))


def check_docs(path, display_path, findings):
    text = re.sub(r"(?s)<!--.*?-->", lambda m: "\n" * m[0].count("\n"), path.read_text("utf-8"))
    text = re.sub(
        r"(?ms)^( *)(```|~~~).*?^\1\2.*?$", lambda m: "CODE" + "\n" * m[0].count("\n"), text
    )
    text = re.sub(r"^( *\.\. .*| {4,}\S.*|\|.*|:.*)$", "", text, flags=re.M)
    line, after_code = 1, False
    for paragraph in re.split(r"(\n\s*\n|\n(?=\s*[-*#] )|\n(?=\d+\. ))", text):
        if paragraph.strip():
            findings.add_idioms(display_path, line, paragraph)
            if after_code and re.match(r"\s*[a-z]+ ", paragraph):
                findings.add("docs", display_path, line, "continues code: " + paragraph)
            after_code = paragraph.rstrip().endswith("CODE")
            plain = re.sub(r"``?[^`]*``?|\]\([^)]*\)|\([^)]*\)", "X", paragraph)
            for sentence in re.split(r"(?<=[.!?:;])[\s*_]+", plain):
                if len(re.findall(r"[A-Za-z][\w'-]*", sentence)) > LONGEST_SENTENCE:
                    findings.add("docs", display_path, line, sentence)
        line += paragraph.count("\n")


def check_page(path, display_path, findings):
    """Check string literals, text nodes and JSDoc comments of a script or page."""
    text = path.read_text("utf-8")
    for match in re.finditer(
        r"(?s)/\*\*(.*?)\*/|\"([^\"\n]{12,})\"|`([^`]{12,})`|>([^<>{}=;]{12,})<", text
    ):
        found = re.sub(r"\$\{[^}]*\}", "X", next(filter(None, match.groups()))).replace("*", " ")
        findings.add_idioms(display_path, text[: match.start()].count("\n") + 1, found)


CHECKS = {
    ".py": check_python,
    ".pyi": check_python,
    ".md": check_docs,
    ".rst": check_docs,
    ".js": check_page,
    ".ts": check_page,
    ".html": check_page,
}


def sources(root):
    """Yield the files of a checkout, except environments, packages and build output."""
    for folder, folders, names in os.walk(root):
        folders[:] = [one for one in folders if one not in NOT_SOURCES]
        yield from (Path(folder) / name for name in names)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("checkout", type=Path, help="Root folder to check.")
    parser.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="[CATEGORY=]N",
        help="Highest count allowed, of every category or of one (default: 0).",
    )
    parser.add_argument("--show", choices=[*CATEGORIES, "all", "none"], default="all")
    options = parser.parse_args()
    limits = dict(one.rpartition("=")[::2] for one in options.limit)
    findings, lines = Findings(), 0
    for path in sorted(sources(options.checkout)):
        display_path = path.relative_to(options.checkout).as_posix()
        if path.suffix in CHECKS and not SKIPPED.match(display_path):
            lines += path.read_bytes().count(b"\n")
            CHECKS[path.suffix](path, display_path, findings)
    for category, display_path, line, text in findings:
        if options.show in (category, "all"):
            print(f"{display_path}:{line}: {category}: {text}")
    counts = Counter(one[0] for one in findings)
    for name, meaning in CATEGORIES.items():
        print(
            f"{name:8}{counts[name]:6}{1000 * counts[name] / lines:8.2f} per 1000 lines: {meaning}"
        )
    print(
        f"{'all':8}{len(findings):6}{1000 * len(findings) / lines:8.2f} per 1000 lines of {lines}"
    )
    return int(any(counts[one] > int(limits.get(one, limits.get("", 0))) for one in CATEGORIES))


if __name__ == "__main__":
    sys.exit(main())
