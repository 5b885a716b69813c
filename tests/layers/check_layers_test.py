#!/usr/bin/env python3
"""check_layers.py must find every kind of violation: each test plants one in a small correct tree."""

import pathlib
import tempfile
import unittest

import check_layers

ARROWS = """
common:
worker/engine/a: common
worker/engine/b: common
worker/engine/top: common worker/engine/a worker/engine/b
face: common
proto: common
server: common proto
forbid worker/engine: grpc .pb.h
"""


class Tree:
    """A tree without violations, to be spoilt by a test."""

    def __init__(self):
        self.arrows = ARROWS
        self.modules = {
            "base": ("common/base", [], ["common/base/base.h", "common/base/version.h.in"]),
            "job": ("common/job", ["base"], ["common/job/job.h"]),
            "a": ("worker/engine/a", ["base"], ["worker/engine/a/a.h", "worker/engine/a/a.cpp"]),
            "b": ("worker/engine/b", ["job"], ["worker/engine/b/b.h"]),
            "top": ("worker/engine/top", ["a", "b"], ["worker/engine/top/top.cpp"]),
            "convert": ("proto/convert", ["job"], ["proto/convert/convert.h"]),
            "api": ("server/api", ["convert"], ["server/api/api.cpp"]),
        }
        self.files = {
            "common/base/base.h": ["<vector>", '"common/base/version.h"'],
            "common/base/version.h.in": [],
            "common/job/job.h": ['"common/base/base.h"'],
            "worker/engine/a/a.h": ['"common/base/base.h"'],
            "worker/engine/a/a.cpp": ['"worker/engine/a/a.h"', "<Imath/ImathVec.h>"],
            "worker/engine/b/b.h": ['"common/job/job.h"'],
            "worker/engine/top/top.cpp": ['"worker/engine/a/a.h"', '"worker/engine/b/b.h"'],
            "proto/convert/convert.h": ['"proto/v1/jobs.pb.h"', '"common/job/job.h"'],
            "server/api/api.cpp": ['"proto/v1/jobs.grpc.pb.h"', '"proto/convert/convert.h"', "<grpcpp/grpcpp.h>"],
            "tests/support/fake.h": ['"common/base/base.h"'],
        }

    def check(self):
        manifest = "\n".join(
            f"module {name}\nfolder {folder}\ndeps {' '.join(deps)}\nfiles {' '.join(files)}\n"
            for name, (folder, deps, files) in self.modules.items())
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for file, includes in self.files.items():
                (root / file).parent.mkdir(parents=True, exist_ok=True)
                (root / file).write_text("#pragma once\n" + "".join(f"#include {what}\n" for what in includes))
            return check_layers.check_tree(root, manifest, self.arrows)


class CheckLayersTest(unittest.TestCase):
    def setUp(self):
        self.tree = Tree()

    def assert_only(self, *fragments):
        """Exactly one violation, whose text holds all fragments."""
        problems = self.tree.check()
        self.assertEqual(len(problems), 1, problems)
        for fragment in fragments:
            self.assertIn(fragment, problems[0])

    def test_correct_tree_passes(self):
        self.assertEqual(self.tree.check(), [])

    def test_include_without_dependency(self):
        self.tree.files["worker/engine/a/a.cpp"].append('"common/job/job.h"')
        self.assert_only("worker/engine/a/a.cpp:4", "job is not in the DEPS of a")

    def test_indirect_dependency_is_not_enough(self):
        self.tree.files["worker/engine/top/top.cpp"].append('"common/base/base.h"')
        self.assert_only("worker/engine/top/top.cpp", "base is not in the DEPS of top")

    def test_spaced_directive_is_seen(self):
        self.tree.files["common/base/base.h"].append('"common/job/job.h"\n  #  include "common/job/job.h"')
        self.assertEqual(len(self.tree.check()), 2)

    def test_two_modules_of_one_folder_are_apart(self):
        self.tree.modules["a2"] = ("worker/engine/a", [], ["worker/engine/a/a2.h"])
        self.tree.files["worker/engine/a/a2.h"] = ['"worker/engine/a/a.h"']
        self.assert_only("worker/engine/a/a2.h:2", "a is not in the DEPS of a2")

    def test_rivals_do_not_depend_on_one_another(self):
        self.tree.modules["a"][1].append("b")
        self.assert_only("module a", "worker/engine/a must not depend on worker/engine/b")

    def test_arrow_of_one_module(self):
        """An interface in the top folder, for the rivals to implement: the arrows name it alone."""
        self.tree.modules["face"] = ("worker/engine/top", ["base"], [])
        self.tree.modules["a"][1].append("face")
        self.assert_only("worker/engine/a must not depend on worker/engine/top (module face)")
        self.tree.arrows = ARROWS.replace("worker/engine/a: common", "worker/engine/a: common face")
        self.assertEqual(self.tree.check(), [])
        self.tree.modules["face"][1].append("a")
        problems = self.tree.check()
        self.assertTrue(any("face must not depend on worker/engine/a" in line for line in problems), problems)

    def test_arrow_downwards_only(self):
        self.tree.modules["base"][1].append("api")
        problems = self.tree.check()
        self.assertTrue(any("common must not depend on server/api" in line for line in problems), problems)

    def test_cycle(self):
        self.tree.modules["base"][1].append("job")
        self.assert_only("cycle of DEPS: base -> job -> base")

    def test_unknown_dependency(self):
        self.tree.modules["a"][1].append("Imath::Imath")
        self.assert_only("module a", "Imath::Imath, which is no module")

    def test_forbidden_word_in_angle_brackets(self):
        self.tree.files["worker/engine/b/b.h"].append("<grpcpp/grpcpp.h>")
        self.assert_only("worker/engine/b/b.h:3", "must not be included below worker/engine")

    def test_generated_messages_only_where_proto_is_a_dependency(self):
        self.tree.files["common/job/job.h"].append('"proto/v1/jobs.pb.h"')
        self.assert_only("common/job/job.h:3", "generated code")

    def test_tests_are_included_by_tests_alone(self):
        self.tree.files["worker/engine/a/a.cpp"].append('"tests/support/fake.h"')
        self.assert_only("worker/engine/a/a.cpp:4", "only tests may include tests")

    def test_unlisted_file(self):
        self.tree.files["server/api/stray.cpp"] = []
        self.assert_only("server/api/stray.cpp: no module lists this file")

    def test_listed_file_is_missing(self):
        del self.tree.files["worker/engine/top/top.cpp"]
        self.assert_only("worker/engine/top/top.cpp: listed by top, but missing")

    def test_file_of_two_modules(self):
        self.tree.modules["b"][2].append("worker/engine/a/a.h")
        problems = self.tree.check()
        self.assertTrue(any("belongs to both a and b" in line for line in problems), problems)

    def test_include_relative_to_the_folder(self):
        self.tree.files["worker/engine/a/a.cpp"].append('"a.h"')
        self.assert_only('"a.h": no such file')

    def test_folder_without_arrow(self):
        self.tree.modules["x"] = ("extra", [], [])
        self.assert_only("module x: no arrow speaks of its folder extra")

    def test_empty_tree_is_no_success(self):
        self.tree.files.clear()
        self.tree.modules.clear()
        self.assert_only("no sources found")


if __name__ == "__main__":
    unittest.main()
