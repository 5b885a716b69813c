#!/usr/bin/env python3
"""check_docs.py must find dead links and unknown papers."""

import pathlib
import tempfile
import unittest

import check_docs


class CheckDocsTest(unittest.TestCase):
    def check(self, **spoilt):
        files = {
            "docs/references.bib": "@article{known2001,\n  title = {T},\n}\n",
            "README.md": "See [docs](docs/page.md#part), [the web](https://example.com/x) and known2001.",
            "docs/page.md": "Up: [readme](../README.md)",
            "common/a.h": "int stranger1999;  // After known2001, see [page](nowhere.md).\n",
            "build/b.md": "[dead](dead.md) stranger1999",
        }
        files.update({name.replace("__", "/").replace("_md", ".md").replace("_h", ".h"): text
                      for name, text in spoilt.items()})
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            return check_docs.check_tree(root)

    def test_sound_tree_passes(self):
        self.assertEqual(self.check(), [])

    def test_dead_link(self):
        self.assertEqual(self.check(docs__page_md="[up](README.md)"),
                         ["docs/page.md: link to README.md, which does not exist"])

    def test_unknown_paper_in_a_comment(self):
        self.assertEqual(self.check(common__a_h="\n// As in stranger1999.\n"),
                         ["common/a.h:2: cites stranger1999, which docs/references.bib does not have"])

    def test_unknown_paper_in_a_document(self):
        self.assertEqual(len(self.check(README_md="[stranger1999]")), 1)


if __name__ == "__main__":
    unittest.main()
