#!/usr/bin/env python3
"""Holds the documents to the tree.

Usage: check_docs.py ROOT

Every link of a Markdown file to a file must lead somewhere, and every paper cited by key (a name and a
year, as in references.bib) in a document or a comment must be in docs/references.bib. Prints violations
and exits with 1 if there is one.
"""

import pathlib
import re
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")
BIB_KEY = re.compile(r"^@\w+\{(\w+),", re.MULTILINE)
CITATION = re.compile(r"\b[a-z]{3,}(?:19|20)[0-9]{2}[a-z]?\b")
CODE = (".h", ".cpp")


def sources(root):
    for path in sorted(root.rglob("*")):
        relative = path.relative_to(root)
        if path.is_file() and not any(part.startswith(".") or part in ("build", "out") for part in relative.parts):
            yield relative, path


def check_links(root, relative, text):
    for link in LINK.findall(text):
        target = link.partition("#")[0]
        if not target or "://" in target:
            continue
        if not (root / relative.parent / target).exists():
            yield f"{relative}: link to {target}, which does not exist"


def check_citations(relative, text, known):
    for number, line in enumerate(text.splitlines(), 1):
        # In code only comments cite.
        spoken = line if relative.suffix == ".md" else line.partition("//")[2]
        for key in CITATION.findall(spoken):
            if key not in known:
                yield f"{relative}:{number}: cites {key}, which docs/references.bib does not have"


def check_tree(root):
    known = set(BIB_KEY.findall((root / "docs/references.bib").read_text(encoding="utf-8")))
    problems = [] if known else ["docs/references.bib: no entries found"]
    for relative, path in sources(root):
        if relative.suffix not in CODE + (".md",):
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if relative.suffix == ".md":
            problems += check_links(root, relative, text)
        problems += check_citations(relative, text, known)
    return problems


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    problems = check_tree(pathlib.Path(arguments[0]))
    for problem in problems:
        print(problem)
    print(f"docs: {len(problems)} violations" if problems else "docs: links and citations lead somewhere")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
